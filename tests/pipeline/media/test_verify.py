"""A finished file is read back before it gets its name."""

import av
import pytest
from hypothesis import given
from hypothesis import strategies as st
from makeup_video.pipeline import OutputError, process_video
from makeup_video.pipeline.media.codecs import container_of
from makeup_video.pipeline.media.mux import Muxer
from makeup_video.pipeline.media.verify import SentStream, missing_from
from media import add_video, encode_frames, make_clip, tone

ENDS = [".mp4", ".mov", ".mkv", ".webm"]


def clip(path):
    if path.suffix == ".webm":
        return make_clip(path, "vp9", audio="libopus", frames=12)
    return make_clip(path, audio="aac", frames=12)


def sent_to(path):
    """The streams of a whole file, as its muxer would have counted them."""
    with av.open(str(path), options={"fflags": "noparse+nofillin"}) as container:
        streams = [
            SentStream(f"{s.type} #{s.index}", s.type, s.name, exact=s.type == "video")
            for s in container.streams
        ]
        for packet in container.demux():
            streams[packet.stream.index].packets += bool(packet.size)
    return streams


@pytest.mark.parametrize("end", ENDS)
def test_a_whole_file_misses_nothing(tmp_path, end):
    path = clip(tmp_path / f"in{end}")
    assert missing_from(path, container_of(path), sent_to(path)) is None


@pytest.mark.parametrize("end", ENDS)
def test_one_packet_too_few_is_missed_in_every_stream(tmp_path, end):
    path = clip(tmp_path / f"in{end}")
    for number, stream in enumerate(sent_to(path)):
        sent = sent_to(path)
        sent[number].packets += 1
        missing = missing_from(path, container_of(path), sent)
        assert missing == (
            f"{stream.name} has {stream.packets} packets, {stream.packets + 1} were sent"
        )


@pytest.mark.parametrize("end", ENDS)
def test_a_video_with_too_many_packets_is_noticed(tmp_path, end):
    path = clip(tmp_path / f"in{end}")
    sent = sent_to(path)
    sent[0].packets -= 1
    assert "video #0 has 12 packets, 11 were sent" in missing_from(path, container_of(path), sent)


@pytest.mark.parametrize("end", ENDS)
def test_missing_and_swapped_streams_are_noticed(tmp_path, end):
    path = clip(tmp_path / f"in{end}")
    sent = sent_to(path)
    more = [*sent, SentStream("subtitle #2", "subtitle", "subrip", packets=1)]
    assert missing_from(path, container_of(path), more) == (
        "subtitle #2 was sent, its place holds nothing"
    )
    assert "its place holds" in missing_from(path, container_of(path), sent[::-1])


@pytest.mark.parametrize("end", ENDS)
def test_a_stream_without_packets_may_be_missing(tmp_path, end):
    path = clip(tmp_path / f"in{end}")
    sent = sent_to(path)
    for at in range(len(sent) + 1):
        for kind in ("subtitle", "audio", "video"):
            empty = SentStream(f"{kind} #9", kind, "none")
            more = [*sent[:at], empty, *sent[at:]]
            assert missing_from(path, container_of(path), more) is None
    sent[1].packets = 0  # the file holds packets of it all the same: empty titles, as mp4 has them
    assert missing_from(path, container_of(path), sent) is None


@given(at=st.integers(0, 40), data=st.binary(min_size=0, max_size=40))
def test_a_file_that_is_no_video_is_reported_and_never_raises(tmp_path_factory, at, data):
    path = tmp_path_factory.mktemp("odd") / "in.mp4"
    path.write_bytes(bytes(at) + data)
    assert missing_from(path, "mp4", [SentStream("video #0", "video", "h264", packets=1)])


@pytest.mark.parametrize("end", ENDS)
def test_an_output_that_lost_a_packet_stays_a_part(tmp_path, monkeypatch, end):
    src, dst = clip(tmp_path / "in.mkv"), tmp_path / f"out{end}"
    muxed = Muxer._mux

    def losing(self, stream, packet):
        if self.video_packets != 5 or stream is not self._video:
            muxed(self, stream, packet)
        else:
            self._sent[stream.index].packets += 1

    monkeypatch.setattr(Muxer, "_mux", losing)
    with pytest.raises(OutputError, match="the painted video has 11 packets, 12 were sent"):
        process_video(src, dst)
    assert not dst.exists()
    assert (tmp_path / f"out.part{end}").exists()


def test_packets_for_the_first_stream_alone_are_noticed(tmp_path, monkeypatch):
    """The fault that this check is the belt for: packets that do not know their stream."""
    src = tmp_path / "in.mkv"
    with av.open(str(src), "w") as out:
        sound = out.add_stream("pcm_s16le", rate=8000, layout="mono")
        stream = add_video(out)
        tone(out, sound, 0.4)
        encode_frames(out, stream, range(12))

    def to_the_first(self, stream, packet):
        packet.stream = self._container.streams[0]
        self._container.mux_one(packet)
        self._sent[stream.index].packets += 1

    monkeypatch.setattr(Muxer, "_mux", to_the_first)
    with pytest.raises(OutputError):
        process_video(src, tmp_path / "out.mkv")
    assert not (tmp_path / "out.mkv").exists()


def test_flac_whose_last_packet_is_empty_is_whole(tmp_path):
    """Sound that Matroska refuses becomes FLAC, and that encoder ends with a packet of no bytes."""
    src = make_clip(tmp_path / "in.mp4", audio="aac", frames=12)
    data = src.read_bytes()
    at = data.index(b"esds")
    src.write_bytes(data[:at] + b"free" + data[at + 4 :])  # what says how the AAC is coded
    report = process_video(src, tmp_path / "out.mkv")
    assert report.converted == ["audio #1 (aac) -> flac"] and report.frames_out == 12
