"""Files whose streams come in an unusual order, begin late, or have no decoder."""

from fractions import Fraction
from pathlib import Path

import av
import pytest
from av.subtitles.subtitle import SubtitleSet
from makeup_video.pipeline import Settings, StrictError, UsageError, process_video
from media import ASS_HEADER, add_video, encode_frames, make_clip, packets_of, picture, tone

ENDS = (".mp4", ".mov", ".mkv")
FRAMES = 12


def sound_first(path: Path, codec: str = "aac", video: str = "h264") -> Path:
    with av.open(str(path), "w") as out:
        sound = out.add_stream(codec, rate=44100, layout="stereo")
        stream = add_video(out, video)
        tone(out, sound, 0.4)
        encode_frames(out, stream, range(FRAMES))
    return path


def subtitle_first(path: Path) -> Path:
    with av.open(str(path), "w") as out:
        titles, stream = out.add_stream("ass"), add_video(out)
        titles.codec_context.subtitle_header = ASS_HEADER
        titles.time_base = Fraction(1, 1000)
        encode_frames(out, stream, range(FRAMES))
        for start in (0, 200):
            event = SubtitleSet.create(b"0,0,Default,,0,0,0,,Hello", 0, 100)
            packet = titles.codec_context.encode_subtitle(event)
            packet.stream, packet.time_base = titles, Fraction(1, 1000)
            packet.pts = packet.dts = start
            packet.duration = 100
            out.mux(packet)
    return path


def flv_sound_first(path: Path) -> Path:
    """FLV numbers its streams in the order of their first packets."""
    with av.open(str(path), "w", format="flv") as out:
        stream = out.add_stream("flv1", rate=30)
        stream.width, stream.height, stream.pix_fmt = 96, 64, "yuv420p"
        sound = out.add_stream("libmp3lame", rate=44100, layout="stereo")
        tone(out, sound, 0.4)
        for index in range(FRAMES):
            frame = picture(index, 96, 64)
            frame.pts = index + 3
            out.mux(stream.encode(frame))
        out.mux(stream.encode(None))
    return path


def kinds_and_counts(path: Path) -> list[tuple[str, int]]:
    with av.open(str(path)) as container:
        found = [[stream.type, 0] for stream in container.streams]
        for packet in container.demux():
            found[packet.stream.index][1] += bool(packet.size)
    return [(kind, count) for kind, count in found]


@pytest.mark.parametrize("end", ENDS)
@pytest.mark.parametrize("begin", [".mp4", ".mkv", ".mov"])
def test_sound_before_the_video_stays_before_it(tmp_path, begin, end):
    src, dst = sound_first(tmp_path / f"in{begin}"), tmp_path / f"out{end}"
    report = process_video(src, dst)
    assert report.frames_out == FRAMES and not report.dropped and not report.damaged
    kinds = kinds_and_counts(dst)
    assert [kind for kind, _ in kinds] == ["audio", "video"] and kinds[1][1] == FRAMES
    assert [p for _, p in packets_of(dst, "audio")] == [p for _, p in packets_of(src, "audio")]


@pytest.mark.parametrize("end", ENDS)
def test_an_flv_whose_sound_comes_first_keeps_its_video(tmp_path, end):
    src, dst = flv_sound_first(tmp_path / "in.flv"), tmp_path / f"out{end}"
    with av.open(str(src)) as container:
        assert container.streams[0].type == "audio"
    assert process_video(src, dst).frames_out == FRAMES
    assert dict(kinds_and_counts(dst))["video"] == FRAMES
    assert [p for _, p in packets_of(dst, "audio")] == [p for _, p in packets_of(src, "audio")]


@pytest.mark.parametrize("end", ENDS)
def test_subtitles_before_the_video_are_kept(tmp_path, end):
    src, dst = subtitle_first(tmp_path / "in.mkv"), tmp_path / f"out{end}"
    assert process_video(src, dst).frames_out == FRAMES
    kinds = kinds_and_counts(dst)
    assert [kind for kind, _ in kinds] == ["subtitle", "video"]
    assert kinds[0][1] >= 2 and kinds[1][1] == FRAMES


def test_sound_first_into_webm_is_converted_and_whole(tmp_path):
    src, dst = sound_first(tmp_path / "in.mp4"), tmp_path / "out.webm"
    assert process_video(src, dst).frames_out == FRAMES
    kinds = kinds_and_counts(dst)
    assert [kind for kind, _ in kinds] == ["audio", "video"] and kinds[1][1] == FRAMES


def mp4_without_decoder(path: Path) -> Path:
    """Write an MP4 with two audio streams. FFmpeg has no decoder for the second."""
    with av.open(str(path), "w") as out:
        stream = add_video(out)
        sounds = [out.add_stream("aac", rate=44100, layout="stereo") for _ in range(2)]
        encode_frames(out, stream, range(FRAMES))
        for sound in sounds:
            tone(out, sound, 0.4)
    data = path.read_bytes()
    entry = data.index(b"mp4a", data.rindex(b"stsd"))  # the sample entry of the second audio stream
    esds = data.index(b"esds", entry)  # this box names the codec, too
    path.write_bytes(data[:entry] + b"apac" + data[entry + 4 : esds] + b"free" + data[esds + 4 :])
    return path


def matroska_without_decoder(path: Path) -> Path:
    make_clip(path, audio="aac", frames=FRAMES)
    data = path.read_bytes()
    assert data.count(b"A_AAC") == 1
    path.write_bytes(data.replace(b"A_AAC", b"A_XYZ"))
    return path


def avi_without_decoder(path: Path) -> Path:
    """Write an AVI whose second stream has an unknown type."""
    make_clip(path, "mpeg4", audio="libmp3lame", frames=FRAMES)
    data = path.read_bytes()
    assert data.count(b"auds") == 1
    path.write_bytes(data.replace(b"auds", b"qqqq"))
    return path


@pytest.mark.parametrize("end", [*ENDS, ".webm"])
@pytest.mark.parametrize(
    ("make", "begin", "lost"),
    [
        (mp4_without_decoder, ".mp4", "audio #2 (unknown codec)"),
        (matroska_without_decoder, ".mkv", "audio #1 (unknown codec)"),
        (avi_without_decoder, ".avi", "#1 (unknown codec)"),
    ],
)
def test_a_stream_without_a_decoder_is_left_out_by_name(tmp_path, make, begin, lost, end):
    report = process_video(make(tmp_path / f"in{begin}"), tmp_path / f"out{end}")
    assert report.frames_out == FRAMES and not report.damaged
    assert len(report.dropped) == 1 and lost in report.dropped[0]


def test_strict_refuses_to_lose_a_stream_without_a_decoder(tmp_path):
    with pytest.raises(StrictError, match="unknown codec"):
        process_video(
            mp4_without_decoder(tmp_path / "in.mp4"),
            tmp_path / "out.mp4",
            None,
            Settings(strict=True),
        )
    assert [path.name for path in tmp_path.iterdir()] == ["in.mp4"]


def late_sound(path: Path, seconds: int) -> Path:
    """Write a file that announces audio at its beginning and carries it from `seconds` on."""
    with av.open(str(path), "w") as out:
        stream = add_video(out, rate=5)
        sound = out.add_stream("aac", rate=44100, layout="stereo")
        encode_frames(out, stream, range(5 * (seconds + 2)))
        tone(out, sound, 1.0, start_seconds=seconds)
    return path


@pytest.mark.parametrize("seconds", [8, 60])
def test_sound_that_begins_late_in_mpegts_is_kept(tmp_path, seconds):
    src, dst = late_sound(tmp_path / "in.ts", seconds), tmp_path / "out.mkv"
    report = process_video(src, dst)
    assert report.dropped == []
    assert len(packets_of(dst, "audio")) == len(packets_of(src, "audio")) > 40


def test_sound_that_begins_too_late_is_left_out(tmp_path):
    report = process_video(late_sound(tmp_path / "in.ts", 130), tmp_path / "out.mkv")
    assert len(report.dropped) == 1
    assert "audio #1 (aac)" in report.dropped[0] and "so late" in report.dropped[0]


def audio_from_mid_file(path: Path) -> Path:
    """Write MPEG-TS with audio only in the middle: FFmpeg probes the beginning and the end."""
    mute, loud = path.with_name("mute.ts"), path.with_name("loud.ts")
    make_clip(mute, "mpeg4", frames=90, rate=30, options={"qscale": "1"})
    make_clip(loud, "mpeg4", frames=30, rate=30, audio="libmp3lame")
    path.write_bytes(mute.read_bytes() * 12 + loud.read_bytes() + mute.read_bytes() * 12)
    mute.unlink()
    loud.unlink()
    return path


def test_a_stream_that_appears_mid_file_is_left_out_by_name(tmp_path):
    src = audio_from_mid_file(tmp_path / "in.ts")
    with av.open(str(src)) as container:
        assert len(container.streams) == 1
    report = process_video(src, tmp_path / "out.mkv", None, Settings(preset="ultrafast"))
    assert report.frames_out > 0
    assert [text.split(":")[0] for text in report.dropped] == ["audio #1 (mp3)"]


def test_strict_refuses_a_stream_that_appears_in_mid_file(tmp_path):
    src = audio_from_mid_file(tmp_path / "in.ts")
    with pytest.raises(StrictError, match="audio #1"):
        process_video(src, tmp_path / "out.mkv", None, Settings(preset="ultrafast", strict=True))
    assert [path.name for path in tmp_path.iterdir()] == ["in.ts"]


def test_a_start_beyond_such_a_file_shows_its_length(tmp_path):
    src = audio_from_mid_file(tmp_path / "in.ts")
    with pytest.raises(UsageError, match="beyond the end"):
        process_video(src, tmp_path / "out.mkv", None, Settings(start_seconds=Fraction(9999)))
