"""Live recordings: complete whenever they stop, with times from the clock."""

import contextlib
import subprocess
import sys
from fractions import Fraction
from pathlib import Path

import av
import media
import numpy as np
import pytest
from makeup_video.pipeline import DecodeError, EncodeError, OutputError, UsageError
from makeup_video.pipeline.live.interfaces import LivePicture
from makeup_video.pipeline.live.sinks.recording import Recording
from makeup_video.pipeline.live.sound import SoundTap
from makeup_video.pipeline.live.sources.camera import CameraSettings, open_source
from makeup_video.pipeline.live.sources.normalise import NormaliseCamera
from media import decoded, make_clip, picture, times_of

UNEVEN = [0, 33, 70, 71, 500, 9000]  # milliseconds


def live(milliseconds, pix_fmt="yuv420p", size_wh=(96, 64)):
    """Live pictures at these times, with an arbitrary offset of the clock."""
    door = NormaliseCamera(is_device=True)
    for index, milliseconds_in in enumerate(milliseconds):
        yield LivePicture(
            door(picture(index, *size_wh, pix_fmt), 55555.123 + milliseconds_in / 1000)
        )


def record(path, pictures, **settings):
    recording = Recording(path, **settings)
    for live_picture in pictures:
        recording(live_picture)
    recording.finish()
    return recording


@pytest.mark.parametrize("end", [".mkv", ".mp4", ".mov", ".webm"])
def test_times_are_those_of_the_clock_and_begin_at_zero(tmp_path, end):
    path = tmp_path / f"out{end}"
    recording = record(path, live(UNEVEN))
    assert [round(float(t) * 1000) for t in times_of(path)] == UNEVEN
    assert [left.name for left in tmp_path.iterdir()] == [path.name] == [recording.name]


@pytest.mark.parametrize(("pix_fmt", "matrix", "span"), [("yuvj422p", 5, 2), ("yuyv422", 6, 1)])
def test_colours_arrive_with_their_tags(tmp_path, pix_fmt, matrix, span):
    path = tmp_path / "out.mkv"
    live_pictures = list(live([0, 40], pix_fmt))
    if span == 2:
        assert live_pictures[0].frame.tags.range == 2
    record(path, live_pictures)
    got = decoded(path)[0]
    want = live_pictures[0].frame
    assert (got.color_range, got.color_primaries, got.color_trc) == (span, 1, 1)
    assert got.colorspace == want.tags.matrix
    luma = np.frombuffer(got.planes[0], np.uint8).reshape(64, -1)[:, :96]
    assert np.abs(luma.astype(int) - want.planes[0]).mean() < 2


def test_the_pictures_are_only_read(tmp_path):
    live_pictures = list(live([0, 40, 80]))
    before = [[p.copy() for p in live_picture.frame.planes] for live_picture in live_pictures]
    record(tmp_path / "out.mp4", live_pictures)
    for live_picture, planes in zip(live_pictures, before, strict=True):
        assert live_picture.frame.picture.pts == live_picture.frame.pts
        assert live_picture.frame.picture.pict_type == 0
        for now, then in zip(live_picture.frame.planes, planes, strict=True):
            np.testing.assert_array_equal(now, then)


def test_a_recording_that_has_ended_keeps_no_encoder(tmp_path):
    """The run keeps each recording for its figures, and a page may record often."""
    tasks = Path("/proc/self/task")  # Python does not list FFmpeg's threads
    threads = len(list(tasks.iterdir())) if tasks.exists() else 0
    recording = Recording(tmp_path / "out.mp4")
    for live_picture in live([0, 40, 80]):
        recording(live_picture)
    state = recording.state
    recording.finish()
    assert recording.state == state and "0.1 s" in state
    assert not threads or len(list(tasks.iterdir())) <= threads


def test_a_rotation_is_kept(tmp_path):
    clip = make_clip(tmp_path / "in.mp4", frames=3, rotation_degrees=90)
    camera = open_source(CameraSettings(name=str(clip)), pytest.fail)
    record(tmp_path / "out.mp4", (LivePicture(frame) for frame in camera.frames()))
    assert round(decoded(tmp_path / "out.mp4")[0].rotation) % 360 == 90


def test_a_played_video_is_not_overwritten_by_its_recording(tmp_path):
    clip = make_clip(tmp_path / "in.mp4", frames=2)
    with pytest.raises(UsageError, match="the output is the input"):
        Recording(clip, source=clip, overwrite=True)


def test_an_existing_file_is_overwritten_only_on_request(tmp_path):
    path = tmp_path / "out.mkv"
    path.write_bytes(b"old")
    with pytest.raises(UsageError, match="add overwrite=True"):
        Recording(path)
    record(path, live([0, 40]), overwrite=True)
    assert len(times_of(path)) == 2


def test_a_run_without_a_picture_leaves_nothing(tmp_path):
    record(tmp_path / "out.mp4", [])
    assert list(tmp_path.iterdir()) == []


def test_a_folder_that_does_not_exist_is_refused(tmp_path):
    with pytest.raises(OutputError, match="does not exist"):
        Recording(tmp_path / "no" / "out.mp4")
    assert list(tmp_path.iterdir()) == []


def test_an_encoder_that_refuses_is_one_line_and_no_file(tmp_path):
    with pytest.raises(EncodeError, match="libx264 refuses 16400x2") as caught:
        record(tmp_path / "out.mp4", live([0], size_wh=(16400, 2)))
    assert "\n" not in str(caught.value) and list(tmp_path.iterdir()) == []


def test_pictures_of_another_size_end_it_in_one_line(tmp_path):
    path, sound = tmp_path / "out.mkv", SoundTap("microphone", 1)
    recording = Recording(path, sound=sound)
    with pytest.raises(DecodeError, match=r"; the recording so far is .*out\.part\.mkv"):
        for one in [*live(range(0, 600, 33), "rgb24"), *live([700], "rgb24", (128, 96))]:
            recording(one)
    assert sound.is_closed and frames_that_play(tmp_path / "out.part.mkv") > 9


FULL_DISK = """
import resource, signal, sys
sys.path[:0] = sys.argv[3:]
resource.setrlimit(resource.RLIMIT_FSIZE, (int(sys.argv[2]), int(sys.argv[2])))
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
from test_recording import live
from makeup_video.pipeline.live.sinks.recording import Recording
from makeup_video.pipeline import OutputError
recording = Recording(sys.argv[1])
try:
    for live_picture in live(range(0, 9000, 33), size_wh=(320, 240)):
        recording(live_picture)
    recording.finish()
except OutputError as error:
    print(error)
"""


def frames_that_play(path):
    count = 0
    with av.open(str(path)) as container, contextlib.suppress(av.FFmpegError):
        for _ in container.decode(video=0):
            count += 1
    return count


def recorded_with_room(path, most_bytes):
    """What a recording prints when no file may exceed `most_bytes`."""
    folders = Path(__file__).parent, Path(media.__file__).parent
    return subprocess.run(
        [sys.executable, "-c", FULL_DISK, path, str(most_bytes), *folders],
        capture_output=True, text=True, timeout=60, check=True,
    ).stdout  # fmt: skip


@pytest.mark.parametrize("end", [".mkv", ".mp4"])
def test_a_disk_that_was_full_before_leaves_no_empty_part(tmp_path, end):
    output = recorded_with_room(tmp_path / f"out{end}", 0)
    assert "cannot be written" in output and "so far" not in output
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("end", [".mkv", ".mp4"])
def test_a_full_disk_is_one_line_and_what_was_recorded_plays(tmp_path, end):
    """A limit on file sizes stands in for a full disk; the kernel's error is almost the same."""
    path = tmp_path / f"out{end}"
    output = recorded_with_room(path, 200_000)
    part = tmp_path / f"out.part{end}"
    assert "cannot be written" in output and len(output.splitlines()) == 1
    assert output.strip().endswith(f"the recording so far is {part}")
    assert frames_that_play(part) >= 5 and not path.exists()


def test_rates_that_are_no_whole_number_are_taken(tmp_path):
    for rate in (Fraction(30000, 1001), 29.97, 7):
        record(tmp_path / "out.mkv", live([0, 40]), rate=rate, overwrite=True)
