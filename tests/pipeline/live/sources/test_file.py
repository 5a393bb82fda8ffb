"""Video files played in real time."""

import itertools
import threading
import time
from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from makeup_video.pipeline import DecodeError
from makeup_video.pipeline.live.sources import file
from makeup_video.pipeline.live.sources.camera import CameraSettings, open_source
from makeup_video.pipeline.live.sources.file import Timeline
from media import damage, make_clip


def test_a_timeline_counts_from_the_first_frame():
    line = Timeline(0.1)
    assert [line(t) for t in (-5.0, -4.9, -4.7)] == pytest.approx([0, 0.1, 0.3])


def test_missing_and_repeated_times_are_fixed_without_drift():
    line = Timeline(0.1)
    got = [line(t, 0.1) for t in (0.0, None, 0.2, 0.2, 0.1, 0.5, 0.6)]
    assert got == pytest.approx([0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6])


def test_long_durations_do_not_make_times_drift():
    line = Timeline(0.1)
    got = [line(t, 0.1) for t in (0.0, 0.04, 0.08, 0.08, *(0.08 + 0.04 * i for i in range(1, 30)))]
    assert got[4] > got[3] > got[2]
    assert got[-5:] == pytest.approx([0.08 + 0.04 * i for i in range(25, 30)])


@pytest.mark.parametrize("jump", [3600.0, -3600.0])
def test_a_clock_that_jumps_is_one_frame_long(jump):
    line = Timeline(0.1)
    assert [line(t) for t in (0.0, 0.1, jump, jump + 0.1)] == pytest.approx([0, 0.1, 0.2, 0.3])


def test_another_pass_goes_on_where_the_last_ended():
    line = Timeline(0.1)
    first = [line(t, 0.1) for t in (1.0, 1.1)]
    line.begin_pass()
    assert first + [line(t, 0.1) for t in (1.0, 1.1)] == pytest.approx([0, 0.1, 0.2, 0.3])


@given(st.lists(st.one_of(st.none(), st.floats(-1e6, 1e6)), max_size=30))
def test_the_times_of_a_timeline_always_increase(times):
    line = Timeline(1 / 30)
    got = [line(t) for t in times]
    assert all(a < b for a, b in itertools.pairwise(got))


def played(path, count=None, **settings):
    """[(frame, seconds of delay after its due time)]"""
    camera = open_source(CameraSettings(name=str(path), **settings), pytest.fail)
    got = []
    for frame in camera.frames():
        got.append((frame, time.monotonic() - frame.seconds))
        if len(got) == count:
            camera.close()
    return camera, got


def test_a_file_plays_to_its_end_and_no_frame_comes_early(tmp_path):
    camera, got = played(make_clip(tmp_path / "in.mp4", frames=8))
    assert len(got) + camera.dropped == 8 and camera.path == tmp_path / "in.mp4"
    assert all(late >= -1e-5 for _, late in got)
    steps = np.diff([frame.seconds for frame, _ in got])
    assert steps == pytest.approx(np.round(steps * 30) / 30, abs=1e-5)


def test_a_variable_rate_is_played_from_its_first_frame(tmp_path):
    pts = [500, 520, 600, 610, 700]
    path = make_clip(tmp_path / "in.mkv", pts=pts, time_base=Fraction(1, 1000))
    _, got = played(path)
    times = np.array([frame.seconds for frame, _ in got]) - got[0][0].seconds
    assert set(np.round(times, 3)) <= {0, 0.02, 0.1, 0.11, 0.2}


@pytest.mark.parametrize("end", ["mp4", "avi"])
def test_a_loop_has_no_seam(tmp_path, end, monkeypatch):
    path, now = make_clip(tmp_path / f"in.{end}", "mjpeg", frames=5, pix_fmt="yuvj420p"), [100.0]
    monkeypatch.setattr(file.time, "monotonic", lambda: now[0])
    camera = open_source(CameraSettings(name=str(path), loop=True), pytest.fail)
    camera._closing = FakeWait(now)
    got = [frame.seconds for frame in itertools.islice(camera.frames(), 14)]
    assert np.diff(got) == pytest.approx(1 / 30, abs=1e-5)
    assert camera.damaged == camera.dropped == 0


@pytest.mark.parametrize("began", [100.0, 0.0])  # clocks may count from the start of the machine
def test_a_file_catches_up_after_a_stall(tmp_path, monkeypatch, began):
    """After a stall no old frame is shown, and the clock keeps its origin."""
    path = make_clip(tmp_path / "in.mp4", frames=60, options={"g": "10"})
    now = [began]
    monkeypatch.setattr(file.time, "monotonic", lambda: now[0])
    camera = open_source(CameraSettings(name=str(path)), pytest.fail)
    camera._closing = FakeWait(now)
    frames = camera.frames()
    first = next(frames)
    now[0] += 1.5  # 45 frames
    later = list(frames)
    assert later[0].seconds >= now[0] - 1.5 and later[0].seconds - first.seconds >= 1.3
    steps = [(frame.seconds - began) * 30 for frame in later]
    assert all(abs(step - round(step)) < 1e-3 for step in steps)
    assert len(later) + 1 + camera.dropped == 60


@pytest.mark.parametrize(
    "frames", [60, 400]
)  # the second is longer than the search for a key frame
def test_with_a_single_key_frame_a_file_plays_on_late(tmp_path, monkeypatch, frames):
    path = make_clip(tmp_path / "in.mp4", frames=frames, options={"g": "9999"})
    now = [100.0]
    monkeypatch.setattr(file.time, "monotonic", lambda: now[0])
    camera = open_source(CameraSettings(name=str(path)), pytest.fail)
    camera._closing = FakeWait(now)
    playing = camera.frames()
    next(playing)
    now[0] += 1.5
    later = [frame.seconds for frame in playing]
    assert len(later) + 1 + camera.dropped == frames and camera.dropped < 15
    assert camera.turn == 2  # the sound goes back as well
    assert later[0] >= 101.5 and np.diff(later) == pytest.approx(1 / 30, abs=1e-3)


def test_a_pass_lasts_until_the_next_begins(tmp_path, monkeypatch):
    """The sound asks which pass plays, even under a last frame that stays for long."""
    path = make_clip(tmp_path / "in.mp4", pts=[0, 30, 60], time_base=Fraction(1, 30))
    now, turns = [100.0], []
    monkeypatch.setattr(file.time, "monotonic", lambda: now[0])
    camera = open_source(CameraSettings(name=str(path), loop=True), pytest.fail)
    camera._closing = FakeWait(now, lambda: turns.append(camera.turn))
    given = [(camera.turn, camera.zero_seconds) for _ in itertools.islice(camera.frames(), 7)]
    length = given[3][1] - given[2][1]
    assert [turn for turn, _ in given] == [1, 1, 1, 2, 2, 2, 3] and length >= 2
    assert turns == [0, 1, 1, 1, 2, 2, 2]  # while the frames of `given` are waited for


def test_a_frame_due_while_the_process_stood_still_is_dropped(tmp_path, monkeypatch):
    path, now = make_clip(tmp_path / "in.mp4", frames=6), [100.0]
    monkeypatch.setattr(file.time, "monotonic", lambda: now[0])
    camera = open_source(CameraSettings(name=str(path)), pytest.fail)
    camera._closing = FakeWait(now)
    frames = camera.frames()
    next(frames)
    camera._closing.stands_still = 0.12
    rest = [round((frame.seconds - 100) * 30) for frame in frames]
    assert rest == [2, 3, 4, 5] and camera.dropped == 1


class FakeWait:
    """An Event for a clock that moves only during waits, and once by too much."""

    def __init__(self, now, while_waiting=lambda: None):
        self.now, self.while_waiting = now, while_waiting
        self.stands_still = 0.0

    def is_set(self):
        return False

    def wait(self, seconds):
        self.while_waiting()
        self.now[0] += seconds + self.stands_still
        self.stands_still = 0.0
        return False


def test_close_wakes_the_thread_that_waits_for_a_frame(tmp_path):
    path = make_clip(tmp_path / "in.mkv", pts=[0, 9000], time_base=Fraction(1, 1000))
    camera = open_source(CameraSettings(name=str(path)), pytest.fail)
    frames = camera.frames()
    next(frames)
    threading.Timer(0.05, camera.close).start()
    began = time.monotonic()
    assert next(frames, None) is None
    assert time.monotonic() - began < 8  # the next frame is due after nine seconds


def test_damage_in_a_file_does_not_end_the_run(tmp_path):
    path = make_clip(tmp_path / "in.avi", "mjpeg", frames=12, pix_fmt="yuvj420p")
    damage(path)
    camera, got = played(path)
    assert len(got) + camera.dropped + camera.damaged >= 11


def test_a_rotated_file_keeps_its_rotation(tmp_path):
    path = make_clip(tmp_path / "in.mp4", frames=2, rotation_degrees=90)
    assert {frame.rotation_degrees for frame, _ in played(path)[1]} == {90}


def test_colours_that_cannot_be_converted_are_one_line(tmp_path):
    path = make_clip(tmp_path / "in.mkv", "ffv1", pix_fmt="yuv444p", colorspace=8, frames=2)
    with pytest.raises(DecodeError, match=r"yuv444p, matrix 8 .* cannot be converted"):
        played(path)
