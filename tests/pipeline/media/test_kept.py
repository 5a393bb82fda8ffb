"""What outputs keep of an input, and the line that names what they lose: data, names, captions."""

from fractions import Fraction
from types import SimpleNamespace

import av
import pytest
from makeup_video.pipeline import (
    InputError,
    LookError,
    Settings,
    StrictError,
    UsageError,
    process_video,
)
from makeup_video.pipeline.batch.sources import inputs_of
from makeup_video.pipeline.look.named import look_files
from makeup_video.pipeline.media.pcm_gaps import FillPcmGaps, has_pcm
from makeup_video.pipeline.media.streams import tags
from media import add_video, encode_frames, make_clip, packets_of, tone

ID3 = b"ID3\x04\x00\x00\x00\x00\x00\x1fTXXX\x00\x00\x00\x15\x00\x00\x03segmentmetadata\x00{}.."


WIDTHS = {"pcm_s16le": 2, "pcm_u8": 1, "pcm_f32le": 4, "pcm_s24le": 3}


def with_id3(path, at_seconds=0):
    """A recording of a stream with timed metadata, as services broadcast it."""
    with av.open(str(path), "w") as out:
        video, data = add_video(out, "h264"), out.add_data_stream("timed_id3")
        data.time_base = Fraction(1, 90000)
        out.start_encoding()
        packet = av.Packet(ID3)
        packet.stream, packet.time_base = data, data.time_base
        packet.pts = packet.dts = 90000 * at_seconds

        def with_packet(frame, index):
            if index == 30 * at_seconds:
                out.mux(packet)
            return frame

        count = min(30 * at_seconds, 150) + 10  # at 99 s: never
        encode_frames(out, video, range(count), change=with_packet)
    return path


@pytest.mark.parametrize("at_seconds", [0, 5])  # the second after the output was opened
@pytest.mark.parametrize("end", [".mp4", ".mov", ".mkv"])
def test_data_that_a_container_cannot_describe_is_dropped(tmp_path, end, at_seconds):
    out = tmp_path / f"out{end}"
    report = process_video(with_id3(tmp_path / "in.ts", at_seconds), out)
    assert [text for text in report.dropped if "timed_id3" in text and "cannot hold it" in text]
    with av.open(str(out)) as container:
        assert [stream.type for stream in container.streams] == ["video"]


@pytest.mark.parametrize("end", [".mp4", ".mov"])
def test_data_that_is_announced_but_never_comes_is_no_loss(tmp_path, end):
    src = with_id3(tmp_path / "in.ts", at_seconds=99)
    with av.open(str(src)) as container:
        assert [stream.type for stream in container.streams] == ["video", "data"]
    assert process_video(src, tmp_path / f"out{end}", None, Settings(strict=True)).dropped == []


@pytest.mark.parametrize("end", [".mp4", ".mov"])
def test_strict_refuses_data_that_comes_late_and_is_lost(tmp_path, end):
    src = with_id3(tmp_path / "in.ts", at_seconds=5)
    with pytest.raises(StrictError, match="timed_id3"):
        process_video(src, tmp_path / f"out{end}", None, Settings(strict=True))


@pytest.mark.parametrize("rate", [1, 5])
@pytest.mark.parametrize("end", [".mp4", ".mov", ".mkv"])
def test_sound_that_begins_later_stays_there(tmp_path, rate, end):
    """The ticks of the source's video are as long as a frame."""
    src = tmp_path / "in.mp4"
    options = {"video_track_timescale": str(rate), "movie_timescale": "1000"}
    with av.open(str(src), "w", container_options=options) as out:
        video = add_video(out, "h264", rate=rate, time_base=Fraction(1, rate))
        sound = out.add_stream("aac", rate=48000, layout="mono")
        encode_frames(out, video, range(4))
        tone(out, sound, 1.0, start_seconds=0.768)
    out = tmp_path / f"out{end}"
    process_video(src, out)
    began, begins = (float(packets_of(path, "audio")[0][0]) for path in (src, out))
    assert began > 0.7 and begins == pytest.approx(began, abs=1e-3)


@pytest.mark.parametrize("codec", [*WIDTHS])
@pytest.mark.parametrize("end", [".mov", ".mkv"])
def test_sound_after_a_gap_stays_there(tmp_path, codec, end):
    """mp4 and mov time PCM by counting its samples, so they know no gaps."""
    src = tmp_path / "in.mkv"
    with av.open(str(src), "w") as out:
        video, sound = add_video(out), out.add_stream(codec, rate=8000, layout="mono")
        encode_frames(out, video, range(90))
        for begins in (0.0, 2.4):
            for first in range(0, 4000, 1000):
                packet = av.Packet(bytes(range(1, 251)) * 4 * WIDTHS[codec])
                packet.stream, packet.time_base = sound, Fraction(1, 8000)
                packet.pts = packet.dts = round(begins * 8000) + first
                packet.duration = 1000
                out.mux(packet)
    process_video(src, tmp_path / f"out{end}")
    packets = [(at, data) for at, data in packets_of(tmp_path / f"out{end}", "audio") if data]
    loud = [float(at) for at, data in packets if len(set(data)) > 2]
    assert min(loud) == pytest.approx(0, abs=0.01) and max(loud) > 2.5
    assert not [at for at in loud if 0.6 < at < 2.2]


@pytest.mark.parametrize(
    ("start", "end", "has_line"),
    [(".mov", ".mp4", True), (".mkv", ".m4v", True), (".mp4", ".mp4", False),
     (".mov", ".mov", False), (".mov", ".mkv", False)],
)  # fmt: skip
@pytest.mark.parametrize("codec", ["pcm_s16le", "pcm_f32le"])
def test_a_line_says_where_few_players_can_play_pcm(tmp_path, start, end, has_line, codec):
    src, dst = make_clip(tmp_path / f"in{start}", audio=codec), tmp_path / f"out{end}"
    report = process_video(src, dst, None, Settings(strict=True))  # nothing is lost
    line = f"audio #1 ({codec}): few players can play PCM in mp4; more can in mov"
    assert report.warnings() == [line] * has_line
    old, new = (b"".join(data for _, data in packets_of(one, "audio")) for one in (src, dst))
    assert old == new


def pcm(name):
    """What FillPcmGaps sees of a stream: mono at 8000 Hz."""
    context = SimpleNamespace(sample_rate=8000, layout=SimpleNamespace(nb_channels=1))
    return SimpleNamespace(name=name, type="audio", codec_context=context)


def filled(fill, data, milliseconds):
    """The silence that `fill` puts before a packet at this time."""
    packet = av.Packet(data)
    packet.time_base = Fraction(1, 1000)
    packet.pts = packet.dts = milliseconds
    *silence, last = fill(packet)
    assert last is packet
    return b"".join(map(bytes, silence))


@pytest.mark.parametrize("gap_ms", [0, 5, 40, 60, 300])
def test_short_gaps_add_up_and_are_filled_together(gap_ms):
    fill, written = FillPcmGaps(pcm("pcm_s16le")), 0
    for number in range(100):
        at = number * (20 + gap_ms)
        written += len(filled(fill, b"\x01\x02" * 160, at)) // 2
        assert abs(written / 8 - at) <= 50
        written += 160


@pytest.mark.parametrize(
    ("name", "silence"), [("pcm_u8", 0x80), ("pcm_s8", 0), ("pcm_alaw", 0xD5), ("pcm_mulaw", 0xFF)]
)
def test_silence_is_the_middle_of_a_codes_range(name, silence):
    assert has_pcm(pcm(name)) and not has_pcm(pcm("aac"))
    fill = FillPcmGaps(pcm(name))
    assert filled(fill, bytes(8), 0) == b""
    assert set(filled(fill, bytes(8), 3000)) == {silence}


@pytest.mark.parametrize("end", [".mp4", ".mov", ".mkv"])
def test_names_of_tracks_are_kept(tmp_path, end):
    src = tmp_path / "in.mp4"
    with av.open(str(src), "w") as out:
        video, sound = add_video(out, "h264"), out.add_stream("aac", rate=48000, layout="mono")
        sound.metadata["title"] = "Kommentar"
        encode_frames(out, video, range(10))
        tone(out, sound, 0.3)
    process_video(src, tmp_path / f"out{end}")
    with av.open(str(tmp_path / f"out{end}")) as container:
        names = container.streams.audio[0].metadata
        assert names.get("title", names.get("name")) == "Kommentar"


def mpeg2(path, first, interlaced):
    """A part of a broadcast: 60 pictures from number `first` on."""
    flags = "+ilme+ildct" if interlaced else "0"
    with av.open(str(path), "w") as out:
        video = out.add_stream("mpeg2video", rate=25, options={"flags": flags})
        video.width, video.height, video.pix_fmt = 96, 64, "yuv420p"
        video.codec_context.time_base = Fraction(1, 25)
        encode_frames(out, video, range(first, first + 60))
    return path


def joined(path, *parts):
    """Parts one after the other; each key frame of MPEG-2 says anew how its pictures are stored."""
    with av.open(str(path), "w") as out:
        stream = None
        for part in parts:
            with av.open(str(part)) as container:
                stream = stream or out.add_stream_from_template(container.streams.video[0])
                for packet in container.demux(video=0):
                    if packet.size:
                        packet.stream = stream
                        out.mux(packet)
    return path


@pytest.mark.parametrize("split", [None, 0.02])
def test_fields_that_come_later_are_reported(tmp_path, split):
    parts = mpeg2(tmp_path / "a.mkv", 0, False), mpeg2(tmp_path / "b.mkv", 60, True)
    src = joined(tmp_path / "in.mkv", *parts)
    settings = Settings(split_minutes=split)
    report = process_video(src, tmp_path / "out.mp4", settings=settings)
    assert report.frames_out == 120 and (split is None or report.segments > 1)
    assert len([text for text in report.dropped if text.startswith("fields from 2.")]) == 1
    settings = Settings(split_minutes=split, strict=True)
    with pytest.raises(StrictError, match=r"cannot keep fields from .* Cut the video there"):
        process_video(src, tmp_path / "strict.mp4", settings=settings)
    assert not (tmp_path / "strict.mp4").exists()


@pytest.mark.parametrize(("end", "codec", "advice"), [
    (".webm", None, r"choose another container, such as \.mkv, or deinterlace"),
    (".mp4", "hevc", "use codec h264, or deinterlace"),
    (".mkv", "av1", "use codec h264, ffv1 or prores, or deinterlace"),
])  # fmt: skip
def test_advice_for_fields_names_what_the_container_holds(tmp_path, end, codec, advice):
    src = mpeg2(tmp_path / "in.mkv", 0, True)
    with pytest.raises(UsageError, match=f"cannot keep its fields: {advice}"):
        process_video(src, tmp_path / f"out{end}", settings=Settings(codec=codec))


def test_an_excerpt_before_the_first_picture_says_so(tmp_path):
    src = tmp_path / "in.mkv"
    with av.open(str(src), "w") as out:
        video, sound = add_video(out), out.add_stream("aac", rate=48000, layout="mono")
        tone(out, sound, 2.0)
        encode_frames(out, video, range(45, 60))
    with pytest.raises(
        UsageError, match=r"end_seconds 1 s is before the first frame: .* from 1\.50 s on"
    ):
        process_video(src, tmp_path / "out.mp4", settings=Settings(end_seconds=1))


def test_folders_that_cannot_be_read_are_one_line(tmp_path, monkeypatch):
    def refuse(*_):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr("os.scandir", refuse)
    monkeypatch.setattr("pathlib.Path.iterdir", refuse)
    with pytest.raises(InputError, match="cannot be read: Permission denied; allow it"):
        inputs_of([str(tmp_path)])
    with pytest.raises(LookError, match="cannot be read: Permission denied; allow it"):
        look_files(str(tmp_path))


@pytest.mark.parametrize("form", ["mp4", "mov", "matroska"])
def test_a_name_becomes_a_title_only_of_a_track_without_one(form):
    container, track = SimpleNamespace(), SimpleNamespace(index=0)
    container.metadata = {"title": "Video", "NAME": "x"}
    assert tags(container, form) == {"title": "Video", "NAME": "x"}
    track.metadata = {"name": "Kommentar"}
    assert tags(track, form) == {"title": "Kommentar"}
    track.metadata = {"title": "Deutsch", "name": "Kommentar"}
    assert tags(track, form)["title"] == "Deutsch"
