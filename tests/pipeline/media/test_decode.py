"""Invalid inputs and outputs are refused in one line, and nothing is left behind."""

import io
import os
import random
from fractions import Fraction

import av
import pytest
from makeup_video.pipeline import (
    DecodeError,
    InputError,
    MakeupVideoError,
    OutputError,
    Settings,
    UsageError,
    process_video,
)
from media import add_video, decoded, encode_frames, make_clip, packets_of, picture, tone


def refused(src, dst, error, match, **settings):
    """Assert that the run raises `error` in one line, leaves no file and keeps the input as is."""
    before = src.read_bytes() if src.is_file() else None
    files = set(os.listdir(dst.parent)) if dst.parent.is_dir() else set()
    with pytest.raises(error, match=match) as caught:
        process_video(src, dst, None, Settings(**settings))
    assert "\n" not in str(caught.value)
    assert files == (set(os.listdir(dst.parent)) if dst.parent.is_dir() else set())
    assert before == (src.read_bytes() if src.is_file() else None)
    return caught.value


def test_a_missing_file_is_refused(tmp_path):
    refused(tmp_path / "no.mp4", tmp_path / "out.mp4", InputError, "does not exist")


def test_a_folder_is_refused(tmp_path):
    refused(tmp_path, tmp_path / "out.mp4", InputError, "is a folder")


def test_an_empty_file_is_refused(tmp_path):
    (tmp_path / "in.mp4").write_bytes(b"")
    refused(tmp_path / "in.mp4", tmp_path / "out.mp4", InputError, "is empty")


def test_a_pipe_is_not_opened(tmp_path):
    os.mkfifo(tmp_path / "in.mp4")
    with pytest.raises(InputError, match="not an ordinary file"):
        process_video(tmp_path / "in.mp4", tmp_path / "out.mp4")


def test_text_renamed_to_mp4_is_refused(tmp_path):
    (tmp_path / "in.mp4").write_text("this is no video\n" * 100)
    refused(tmp_path / "in.mp4", tmp_path / "out.mp4", InputError, "is not a video")


@pytest.mark.parametrize("size", [1, 7, 100, 5000])
def test_random_bytes_are_refused(tmp_path, size):
    (tmp_path / "in.mp4").write_bytes(random.Random(size).randbytes(size))
    refused(tmp_path / "in.mp4", tmp_path / "out.mp4", MakeupVideoError, "in.mp4")


def test_an_mp4_without_its_index_is_refused(tmp_path):
    whole = make_clip(tmp_path / "whole.mp4", frames=60).read_bytes()
    (tmp_path / "in.mp4").write_bytes(whole[: len(whole) // 2])
    refused(tmp_path / "in.mp4", tmp_path / "out.mp4", InputError, "has no index")


def test_a_file_with_only_audio_is_refused(tmp_path):
    with av.open(str(tmp_path / "in.m4a"), "w", format="mp4") as out:
        sound = out.add_stream("aac", rate=48000, layout="stereo")
        tone(out, sound, 0.5)
    error = refused(tmp_path / "in.m4a", tmp_path / "out.mp4", DecodeError, "no video stream")
    assert "audio/aac" in str(error)


def test_a_video_of_zero_frames_is_refused(tmp_path):
    with av.open(str(tmp_path / "in.mp4"), "w") as out:
        add_video(out)
        out.start_encoding()
    refused(tmp_path / "in.mp4", tmp_path / "out.mp4", MakeupVideoError, "in.mp4")


def test_a_size_that_changes_mid_stream(tmp_path):
    """Two H.264 streams of different size, one after the other, as broadcasters splice them."""
    stream = io.BytesIO()
    for size_wh in ((96, 64), (128, 96)):
        part = tmp_path / "part.h264"
        with av.open(str(part), "w", format="h264") as out:
            encode_frames(out, add_video(out, size_wh=size_wh), range(10))
        stream.write(part.read_bytes())
        part.unlink()
    (tmp_path / "in.h264").write_bytes(stream.getvalue())
    refused(tmp_path / "in.h264", tmp_path / "out.mp4", DecodeError, "changes from 96x64")


@pytest.mark.parametrize("codec", ["h264", "mjpeg", "ffv1"])
def test_one_pixel(tmp_path, codec):
    src = make_clip(tmp_path / "in.mkv", "ffv1", size_wh=(1, 1), frames=3)
    report = process_video(src, tmp_path / "out.mkv")
    assert report.frames_out == 3
    assert picture(0, 1, 1).width == 1 and codec


HLS = "#EXTM3U\n#EXT-X-TARGETDURATION:1\n#EXTINF:1,\n%s\n#EXT-X-ENDLIST\n"
SDP = "v=0\no=- 0 0 IN IP4 127.0.0.1\ns=x\nc=IN IP4 127.0.0.1\nm=video 9 RTP/AVP 96\n"
DASH = "<MPD><Period><BaseURL>{folder}/secret.mp4</BaseURL></Period></MPD>"


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("list.ffconcat", "ffconcat version 1.0\nfile 'secret.mp4'\n"),
        ("list.mp4", "ffconcat version 1.0\nfile '{folder}/secret.mp4'\n"),
        ("list.m3u8", HLS % "{folder}/secret.mp4"),
        ("web.m3u8", HLS % "http://127.0.0.1:9/x.ts"),
        ("list.mp4", HLS % "file://{folder}/secret.mp4"),
        ("list.sdp", SDP),
        ("list.mpd", "<?xml version='1.0'?>" + DASH),
    ],
)
def test_a_file_that_points_at_another_is_refused(tmp_path, name, text):
    make_clip(tmp_path / "secret.mp4")
    (tmp_path / name).write_text(text.format(folder=tmp_path))
    refused(tmp_path / name, tmp_path / "out.mp4", InputError, "playlists are not followed")


@pytest.mark.parametrize(
    "name", ["concat:a.mp4", "http:x.mp4", "pipe:0.mp4", "-dash.mp4", "a%03d.mp4"]
)
def test_a_strange_file_name_is_a_file_name(tmp_path, name):
    src = make_clip(tmp_path / "in.mp4").rename(tmp_path / name)
    out = tmp_path / f"out {name}"
    assert process_video(src, out).frames_out == 12
    assert out.exists()


@pytest.mark.parametrize(
    "target", ["http://h/out.mp4", "pipe:1.mp4", "concat:o.mp4", "rtmp://h/o.mp4"]
)
def test_an_output_is_never_an_address(tmp_path, monkeypatch, target):
    monkeypatch.chdir(tmp_path)
    src = make_clip(tmp_path / "in.mp4")
    if "/" in target:
        refused(src, tmp_path / target, OutputError, "does not exist")
    else:
        process_video(src, target)
        assert (tmp_path / target).exists()


def test_an_output_in_a_missing_folder_is_refused(tmp_path):
    src = make_clip(tmp_path / "in.mp4")
    refused(src, tmp_path / "no" / "out.mp4", OutputError, "does not exist")


def test_an_output_that_is_a_folder_is_refused(tmp_path):
    src = make_clip(tmp_path / "in.mp4")
    (tmp_path / "out.mp4").mkdir()
    refused(src, tmp_path / "out.mp4", OutputError, "is a folder")


def test_an_existing_output_is_replaced_only_on_request(tmp_path):
    src = make_clip(tmp_path / "in.mp4")
    (tmp_path / "out.mp4").write_text("precious")
    refused(src, tmp_path / "out.mp4", UsageError, "add overwrite=True")
    assert (tmp_path / "out.mp4").read_text() == "precious"
    process_video(src, tmp_path / "out.mp4", None, Settings(overwrite=True))
    assert len(decoded(tmp_path / "out.mp4")) == 12


def test_a_failed_run_keeps_the_file_it_was_to_overwrite(tmp_path):
    (tmp_path / "in.mp4").write_text("no video")
    (tmp_path / "out.mp4").write_text("precious")
    refused(tmp_path / "in.mp4", tmp_path / "out.mp4", InputError, "not a video", overwrite=True)
    assert (tmp_path / "out.mp4").read_text() == "precious"


@pytest.mark.parametrize("name", ["out", "out.txt", "out.avi", "out.jpg"])
def test_an_output_of_unknown_kind_is_refused(tmp_path, name):
    src = make_clip(tmp_path / "in.mp4")
    refused(src, tmp_path / name, UsageError, "must end in")


def test_sound_that_lies_far_behind_its_picture_is_kept(tmp_path):
    """A file in which all pictures precede the sound."""
    src, far = tmp_path / "in.mkv", {"max_interleave_delta": "1"}
    with av.open(str(src), "w", container_options=far) as out:
        video, sound = add_video(out), out.add_stream("aac", rate=48000, layout="stereo")
        encode_frames(out, video, range(120))
        tone(out, sound, 4)
    with av.open(str(src)) as container:
        kinds = [packet.stream.type for packet in container.demux() if packet.size]
    assert kinds.index("audio") > 100
    process_video(src, tmp_path / "out.mkv", None, Settings(end_seconds=Fraction(2)))
    assert len(packets_of(tmp_path / "out.mkv", "audio")) == pytest.approx(2 * 48000 / 1024, abs=2)
