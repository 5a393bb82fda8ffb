"""A start beyond the end of a video is a usage error that gives the length of the video."""

from contextlib import closing
from dataclasses import replace
from fractions import Fraction

import av
import pytest
from makeup_video.pipeline import DecodeError, Settings, UsageError, process_video
from makeup_video.pipeline.media.duration import check_start
from makeup_video.pipeline.media.input_file import open_video
from makeup_video.pipeline.offline import video as offline_video
from media import add_video, decoded, encode_frames, make_clip, tone

CODECS = {".webm": "vp9", ".flv": "h264", ".ts": "h264", ".avi": "mpeg4", ".mkv": "h264"}


def make_video(folder, end, frames=30, **settings):
    return make_clip(folder / f"in{end}", CODECS.get(end, "h264"), frames=frames, **settings)


def start(seconds, **more):
    return Settings(start_seconds=Fraction(seconds), **more)


@pytest.mark.parametrize("end", [".mp4", ".mov", ".mkv", ".webm", ".ts", ".avi", ".flv"])
@pytest.mark.parametrize("seconds", ["1.1", "10", "123456"])
def test_a_start_beyond_the_end_is_refused_at_once(tmp_path, monkeypatch, end, seconds):
    src = make_video(tmp_path, end)
    monkeypatch.setattr(
        offline_video, "OutputFile", lambda *_, **__: pytest.fail("the output was opened")
    )
    with pytest.raises(UsageError) as caught:
        process_video(src, tmp_path / "out.mkv", None, start(seconds))
    message = f"start_seconds {float(seconds):g} s is beyond the end: {src} is 1.0"
    assert str(caught.value).startswith(message) and str(caught.value).endswith("s long")
    assert [path.name for path in tmp_path.iterdir()] == [src.name]


@pytest.mark.parametrize("end", [".h264", ".y4m"])
def test_without_a_length_in_the_header_decoding_finds_it(tmp_path, end):
    kind = {".h264": "h264", ".y4m": "yuv4mpegpipe"}[end]
    src = tmp_path / f"in{end}"
    with av.open(str(src), "w", format=kind) as out:
        if end == ".h264":
            encode_frames(out, add_video(out), range(30))
        else:
            stream = out.add_stream("wrapped_avframe", rate=30)
            stream.width, stream.height, stream.pix_fmt = 96, 64, "yuv420p"
            stream.time_base = stream.codec_context.time_base = Fraction(1, 30)
            encode_frames(out, stream, range(30))
    with pytest.raises(
        UsageError, match=r"start_seconds 10 s is beyond the end: .* is \d\.\d+ s long"
    ):
        process_video(src, tmp_path / "out.mkv", None, start(10))
    assert [path.name for path in tmp_path.iterdir()] == [src.name]


def test_a_part_is_kept_and_its_end_may_be_too_late(tmp_path):
    src = make_video(tmp_path, ".mp4")
    report = process_video(
        src, tmp_path / "out.mp4", None, start("0.9", end_seconds=Fraction(1000))
    )
    assert report.frames_out == len(decoded(tmp_path / "out.mp4")) == 3


@pytest.mark.parametrize("seconds", ["0.98", "1"])
def test_the_last_picture_lasts_until_its_own_end(tmp_path, seconds):
    """The last frame lasts from 0.967 to 1.0 s. A start within it is no usage error."""
    src = make_video(tmp_path, ".mp4")
    with closing(open_video(src)) as source:
        if seconds == "1":
            with pytest.raises(UsageError, match=r"is 1\.0 s long"):
                check_start(source, Fraction(seconds))
        else:
            check_start(source, Fraction(seconds))


def test_times_are_counted_from_where_a_player_begins(tmp_path):
    """A recording whose timestamps begin at a time of day, not at 0."""
    src = make_video(tmp_path, ".ts", pts=range(108_000, 108_030))
    with pytest.raises(UsageError, match=r"start_seconds 10 s is beyond the end: .* is 1\.0"):
        process_video(src, tmp_path / "out.mp4", None, start(10))
    assert process_video(src, tmp_path / "out.mp4", None, start("0.5")).frames_out == 15


def test_a_start_in_sound_after_the_last_picture_is_refused(tmp_path):
    src = tmp_path / "in.mkv"
    with av.open(str(src), "w") as out:
        video = add_video(out)
        sound = out.add_stream("libopus", rate=48000, layout="stereo")
        encode_frames(out, video, range(30))
        tone(out, sound, 8.0)
    with pytest.raises(
        UsageError, match=r"start_seconds 5 s is beyond the last frame: .* frames until 1.0 s"
    ):
        process_video(src, tmp_path / "out.mkv", None, start(5))
    assert [path.name for path in tmp_path.iterdir()] == ["in.mkv"]


def test_a_header_that_declares_too_little_is_not_trusted(tmp_path):
    """A recorder may write the header before the end of the file is known."""
    src = make_video(tmp_path, ".mkv", frames=90)
    data = src.read_bytes()
    offset = data.index(b"\x44\x89\x88") + 3  # the Duration element: 8 bytes
    src.write_bytes(data[:offset] + b"\x40\x8f\x40" + bytes(5) + data[offset + 8 :])  # 1000 ms
    with closing(open_video(src)) as source:
        assert source.container.duration == 1_000_000
    report = process_video(src, tmp_path / "out.mp4", None, start(2))
    assert report.frames_out == 30
    split = replace(start(2), split_minutes=Fraction(1, 60), overwrite=True)
    report = process_video(src, tmp_path / "out.mp4", None, split)
    assert report.frames_out == 30


def test_a_part_that_does_not_decode_is_damage(tmp_path):
    src = make_video(tmp_path, ".mp4", frames=60, options={"g": "10"})
    data = bytearray(src.read_bytes())
    offset = data.index(b"mdat") + 4
    size = int.from_bytes(data[offset - 8 : offset - 4], "big") - 8
    data[offset : offset + size] = bytes(size)
    src.write_bytes(data)
    with pytest.raises(DecodeError, match="no frame could be decoded in the chosen excerpt"):
        process_video(src, tmp_path / "out.mp4", None, start(1))
