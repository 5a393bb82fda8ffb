"""Live runs with a camera that waits for the painter, so drops do not depend on the machine."""

import threading
from types import SimpleNamespace

import numpy as np
import pytest
from makeup_video.pipeline import Look, product
from makeup_video.pipeline.errors import StoppedError
from makeup_video.pipeline.live import run as live
from makeup_video.pipeline.live.frame_budget import NOTICES, Budget
from makeup_video.pipeline.live.interfaces import LIVE_TIME_BASE
from makeup_video.pipeline.live.run import LiveRun
from makeup_video.pipeline.render.build_scene import BuildScene
from people import clip, clip_points, frame_of

RED, BLUE = (Look(lips=product(rgb, "matte")) for rgb in ((200, 0, 30), (20, 40, 200)))


class Camera:
    """A camera that gives the next frame after the last one is painted."""

    notice, dropped, damaged = "", 0, 0

    def __init__(self, count, before_frame=lambda number: None):
        self.count, self.before_frame = count, before_frame
        self.painted, self.closed = threading.Semaphore(1), False
        self.codes = []

    def frames(self):
        for number, rgb8 in enumerate(clip(self.count)):
            self.painted.acquire()
            self.before_frame(number)
            frame = frame_of(rgb8, 1_000_000 + 33_333 * number, time_base=LIVE_TIME_BASE)
            self.codes.append([plane.copy() for plane in frame.planes])
            yield frame

    def close(self):
        self.closed = True


class Sink:
    name, kind, waiting = "list", "recording", 99
    notice, state, seconds = "", "", 0.0

    def __init__(self, camera):
        self.camera, self.pictures, self.sent = camera, [], 0

    def __call__(self, picture):
        self.pictures.append(picture)
        self.camera.painted.release()

    def finish(self):
        self.is_finished = True


def lips_change(picture, codes, number):
    """Mean change of Cb and Cr in the middle of the lower lip."""
    x, y = (clip_points()[number, 17] * 0.4 + clip_points()[number, 14] * 0.6) / 2
    area = np.s_[round(y) - 1 : round(y) + 2, round(x) - 3 : round(x) + 4]
    return [
        float(new[area].astype(int).mean() - old[area].astype(int).mean())
        for new, old in zip(picture.frame.planes[1:], codes[1:], strict=True)
    ]


def test_every_frame_is_painted_with_its_own_time():
    camera = Camera(6)
    sink = Sink(camera)
    LiveRun(camera, RED, [sink]).run()
    assert [p.frame.pts for p in sink.pictures] == [1_000_000 + 33_333 * n for n in range(6)]
    for number, picture in enumerate(sink.pictures):
        assert lips_change(picture, camera.codes[number], number)[1] > 15
        assert picture.before is None
    assert camera.closed and sink.is_finished


def test_a_new_look_begins_at_the_next_frame_and_drops_none():
    def change(number):
        if number == 3:
            run.set_look(BLUE)

    camera = Camera(6, change)
    sink = Sink(camera)
    run = LiveRun(camera, RED, [sink])
    run.run()
    changes = [lips_change(p, camera.codes[n], n) for n, p in enumerate(sink.pictures)]
    assert len(changes) == 6 and run.look == BLUE
    assert all(cr > 15 and cb < 5 for cb, cr in changes[:3])
    assert all(cb > 15 for cb, cr in changes[3:])


def test_comparing_adds_the_unpainted_picture():
    def compare(number):
        run.compare = 2 <= number < 4

    camera = Camera(6, compare)
    sink = Sink(camera)
    run = LiveRun(camera, RED, [sink])
    run.run()
    assert [p.before is not None for p in sink.pictures] == [n in (2, 3) for n in range(6)]
    for number in (2, 3):
        for before, codes in zip(sink.pictures[number].before, camera.codes[number], strict=True):
            np.testing.assert_array_equal(before, codes)


def test_a_bare_look_leaves_every_byte_alone():
    camera = Camera(3)
    sink = Sink(camera)
    LiveRun(camera, Look(), [sink]).run()
    for picture, codes in zip(sink.pictures, camera.codes, strict=True):
        for new, old in zip(picture.frame.planes, codes, strict=True):
            np.testing.assert_array_equal(new, old)


def test_painting_does_not_wait_while_a_photo_is_read():
    camera = Camera(3)
    sink = Sink(camera)
    run = LiveRun(camera, RED, [sink])
    thread = threading.Thread(target=run.run, daemon=True)
    with BuildScene()._surface._lock:  # a thread of low priority may hold the lock for long
        thread.start()
        thread.join(20)
        assert not thread.is_alive() and len(sink.pictures) == 3


def test_figures_count_what_was_painted_and_what_sinks_took():
    camera = Camera(5)
    sink = Sink(camera)
    sink.sent = 5
    run = LiveRun(camera, RED, [sink])
    before = run.figures()
    assert (before.pictures, before.fps, before.latency_ms) == (0, 0.0, None)
    camera.notice, camera.damaged = "the camera is gone", 3
    run.run()
    after = run.figures()
    assert (after.pictures, after.dropped, after.damaged) == (5, 0, 3)
    assert after.latency_ms >= 0
    assert [(s.name, s.pictures, s.dropped) for s in after.sinks] == [("list", 5, 0)]
    assert after.notice == "the camera is gone"
    sink.notice = "rtmp://host does not answer"
    assert run.figures().notice == "the camera is gone; rtmp://host does not answer"


def outlet(name, kind="recording", error=None):
    return SimpleNamespace(sink=SimpleNamespace(name=name, kind=kind, notice=""), error=error)


def test_a_failed_recording_is_told_until_another_begins(monkeypatch):
    run, first = LiveRun(Camera(1), RED, []), outlet("a")
    runner = run._runner
    runner.outlets = [outlet("url", "stream", "refused"), first]
    monkeypatch.setattr(runner, "add", lambda sink: runner.outlets.append(outlet(sink.name)))
    first.error = "disk full"
    assert run._notice() == "url: refused; a: disk full"
    run.add_sink(SimpleNamespace(name="b", kind="recording"))
    assert run._notice() == "url: refused"
    runner.outlets[-1].error = "disk full"  # fails after it has begun
    assert run._notice() == "url: refused; b: disk full"


def test_pictures_that_a_sink_threw_away_do_not_count_as_sent():
    camera = Camera(5)
    sink = Sink(camera)
    sink.sent = 2  # of the five that the sink accepts
    run = LiveRun(camera, RED, [sink])
    run.run()
    assert len(sink.pictures) == 5 and run.figures().sinks[0].pictures == 2


def test_stages_get_the_level_and_changes_are_logged_seldom(monkeypatch):
    levels = iter([0, 1, 0, 1, 0, 1, 2])

    class Wavering(Budget):
        def __call__(self, *_):
            self.level = next(levels)
            return self.level

    monkeypatch.setattr(live, "Budget", Wavering)
    camera, lines, stage_levels = Camera(8), [], []
    run = LiveRun(camera, RED, [Sink(camera)], log=lines.append)
    camera.before_frame = lambda number: stage_levels.append((run.figures().level, run._find.level))
    run.run()
    assert stage_levels == [
        (level, level) for level in (0, 0, 0, 1, 0, 1, 0, 1)
    ]  # after each frame
    assert lines == [NOTICES[1], "fast enough again: nothing is left out", NOTICES[2]]


def test_frames_that_the_camera_dropped_count_in_the_budget(monkeypatch):
    intervals = []

    class Asked(Budget):
        def __call__(self, work_seconds, interval_seconds, dropped=0):
            intervals.append((round(interval_seconds, 3), dropped))
            return 0

    def late(number):
        camera.dropped += 2 * (number == 3)

    monkeypatch.setattr(live, "Budget", Asked)
    camera = Camera(5, late)
    run = LiveRun(camera, RED, [Sink(camera)])
    run.run()
    assert intervals == [(0.033, 0), (0.033, 0), (0.033, 2), (0.033, 0)]
    assert run.figures().dropped == 2


def test_a_stop_from_another_thread_ends_run_and_camera():
    camera = Camera(40, lambda number: run.stop() if number == 4 else None)
    sink = Sink(camera)
    run = LiveRun(camera, RED, [sink])
    with pytest.raises(StoppedError):
        run.run()
    assert camera.closed and sink.is_finished and len(sink.pictures) == 4
