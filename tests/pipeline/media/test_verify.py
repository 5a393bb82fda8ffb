"""A finished file is read back before it gets its final name."""

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
    """Return the streams of a complete file, as its muxer would have counted them."""
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
            f"{stream.name} has {stream.packets} packets, but {stream.packets + 1} were sent"
        )


@pytest.mark.parametrize("end", ENDS)
def test_a_video_with_too_many_packets_is_noticed(tmp_path, end):
    path = clip(tmp_path / f"in{end}")
    sent = sent_to(path)
    sent[0].packets -= 1
    assert "video #0 has 12 packets, but 11 were sent" in missing_from(
        path, container_of(path), sent
    )


@pytest.mark.parametrize("end", ENDS)
def test_missing_and_swapped_streams_are_noticed(tmp_path, end):
    path = clip(tmp_path / f"in{end}")
    sent = sent_to(path)
    more = [*sent, SentStream("subtitle #2", "subtitle", "subrip", packets=1)]
    assert missing_from(path, container_of(path), more) == (
        "subtitle #2 was sent, but its place in the file holds nothing"
    )
    assert "but its place in the file holds" in missing_from(path, container_of(path), sent[::-1])


@pytest.mark.parametrize("end", ENDS)
def test_a_stream_without_packets_may_be_missing(tmp_path, end):
    path = clip(tmp_path / f"in{end}")
    sent = sent_to(path)
    for position in range(len(sent) + 1):
        for kind in ("subtitle", "audio", "video"):
            empty = SentStream(f"{kind} #9", kind, "none")
            more = [*sent[:position], empty, *sent[position:]]
            assert missing_from(path, container_of(path), more) is None
    sent[1].packets = 0  # more packets are allowed: MP4 adds empty subtitles
    assert missing_from(path, container_of(path), sent) is None


@given(zeros=st.integers(0, 40), data=st.binary(min_size=0, max_size=40))
def test_a_file_that_is_no_video_is_reported_and_never_raises(tmp_path_factory, zeros, data):
    path = tmp_path_factory.mktemp("odd") / "in.mp4"
    path.write_bytes(bytes(zeros) + data)
    assert missing_from(path, "mp4", [SentStream("video #0", "video", "h264", packets=1)])


@pytest.mark.parametrize("end", ENDS)
def test_an_output_that_lost_a_packet_stays_a_part(tmp_path, monkeypatch, end):
    src, dst = clip(tmp_path / "in.mkv"), tmp_path / f"out{end}"
    original_mux = Muxer._mux

    def drop_one_packet(self, stream, packet):
        if self.video_packets != 5 or stream is not self._video:
            original_mux(self, stream, packet)
        else:
            self._sent[stream.index].packets += 1

    monkeypatch.setattr(Muxer, "_mux", drop_one_packet)
    with pytest.raises(OutputError, match="the painted video has 11 packets, but 12 were sent"):
        process_video(src, dst)
    assert not dst.exists()
    assert (tmp_path / f"out.part{end}").exists()


def test_packets_for_the_first_stream_alone_are_noticed(tmp_path, monkeypatch):
    """The fault that this check guards against: packets that do not name their stream."""
    src = tmp_path / "in.mkv"
    with av.open(str(src), "w") as out:
        sound = out.add_stream("pcm_s16le", rate=8000, layout="mono")
        stream = add_video(out)
        tone(out, sound, 0.4)
        encode_frames(out, stream, range(12))

    def mux_to_the_first(self, stream, packet):
        packet.stream = self._container.streams[0]
        self._container.mux_one(packet)
        self._sent[stream.index].packets += 1

    monkeypatch.setattr(Muxer, "_mux", mux_to_the_first)
    with pytest.raises(OutputError):
        process_video(src, tmp_path / "out.mkv")
    assert not (tmp_path / "out.mkv").exists()


def test_flac_whose_last_packet_is_empty_is_whole(tmp_path):
    """Audio that Matroska refuses becomes FLAC, whose encoder ends with an empty packet."""
    src = make_clip(tmp_path / "in.mp4", audio="aac", frames=12)
    data = src.read_bytes()
    offset = data.index(b"esds")
    # without the box that describes the AAC coding
    src.write_bytes(data[:offset] + b"free" + data[offset + 4 :])
    report = process_video(src, tmp_path / "out.mkv")
    assert report.converted == ["audio #1 (aac) -> flac"] and report.frames_out == 12


@pytest.mark.parametrize("end", [".mp4", ".mov"])
def test_packets_that_share_a_sample_are_not_missed(tmp_path, end):
    """mp4 and mov put several packets of E-AC-3 into one sample."""
    path = clip(tmp_path / f"in{end}")
    video, audio = sent_to(path)
    audio.codec, audio.packets = "eac3", 3 * audio.packets
    assert missing_from(path, container_of(path), [video, audio]) is None
    path = make_clip(tmp_path / f"silent{end}", frames=12)
    assert "audio #1" in missing_from(path, container_of(path), [video, audio])
