import threading
import time
from fractions import Fraction

import pytest
from live_doubles import Camera, Frames, List, frame, numbers, our_threads, started, until
from makeup_video.pipeline import EncodeError, InputError, OutputError, StoppedError
from makeup_video.pipeline.live import runner as live_runner
from makeup_video.pipeline.live.interfaces import LIVE_TIME_BASE, LivePicture
from makeup_video.pipeline.live.runner import LiveRunner


@pytest.fixture
def camera():
    """A camera whose thread ends before the next test."""
    source = Camera()
    yield source
    until(lambda: source.closed.is_set() or source.allowed.release())


def test_all_frames_reach_every_sink_in_order():
    sinks = [List("a", waiting=9), List("b", waiting=9)]

    def frames():
        for number in range(5):
            yield frame(number)
            time.sleep(0.02)

    LiveRunner(Frames(frames()), LivePicture, sinks, log=pytest.fail).run()
    for sink in sinks:
        assert numbers(sink.pictures) == sorted(set(numbers(sink.pictures)))
        assert numbers(sink.pictures)[-1] == 4
        assert sink.is_finished
    until(lambda: not our_threads())


def test_slow_work_gets_the_newest_frame_and_counts_others(camera):
    busy, gate, sink = threading.Event(), threading.Event(), List(waiting=9)

    def work(item):
        busy.set()
        gate.wait(20)
        return LivePicture(item)

    runner = LiveRunner(camera, work, [sink], log=pytest.fail)
    thread, _ = started(runner)
    camera.allowed.release()
    assert busy.wait(20)  # the first frame is in work
    camera.allowed.release(6)
    until(lambda: runner.inbox.dropped == 5)
    assert runner.inbox.fill == 1
    gate.set()
    until(lambda: len(sink.pictures) == 2)
    assert numbers(sink.pictures) == [1, 7]
    runner.stop()
    thread.join(20)


def test_a_stalled_sink_delays_nobody_and_gets_the_newest(camera):
    gate = threading.Event()
    stalled, other = List("stalled", gate=gate), List("other", waiting=99)
    runner = LiveRunner(camera, LivePicture, [stalled, other], log=pytest.fail)
    thread, _ = started(runner)
    for number in range(1, 20):
        camera.allowed.release()
        until(lambda number=number: numbers(other.pictures)[-1:] == [number])
    assert stalled.pictures == []
    gate.set()
    until(lambda: len(stalled.pictures) == 2)
    assert numbers(stalled.pictures)[-1] == 19
    assert runner.outlets[0].channel.dropped + len(stalled.pictures) == 19
    runner.stop()
    thread.join(20)


def test_a_sink_that_fails_is_logged_and_the_others_go_on(camera):
    lines = []
    broken = List("out.mkv", error=EncodeError("the disk is full"))
    other = List("other", waiting=9)
    runner = LiveRunner(camera, LivePicture, [broken, other], lines.append)
    thread, raised = started(runner)
    camera.allowed.release()
    until(lambda: lines)
    camera.allowed.release(2)
    until(lambda: numbers(other.pictures)[-1:] == [3])
    assert lines == ["EncodeError: the disk is full; the rest goes on"]
    runner.stop()
    thread.join(20)
    assert isinstance(raised[0], StoppedError)
    assert isinstance(runner.outlets[0].error, EncodeError) and not broken.is_finished


class NeverWorked(List):
    """Accepts every picture but sends none, like a stream without a receiver."""

    def finish(self):
        raise OutputError(f"{self.name} was never reached")


def test_a_sink_that_never_worked_is_logged_at_the_end():
    lines, good = [], List("good", waiting=9)
    runner = LiveRunner(
        Frames(frame(n) for n in [7]), LivePicture, [NeverWorked("rtmp"), good], lines.append
    )
    runner.run()
    assert lines == ["OutputError: rtmp was never reached"] and good.is_finished
    assert isinstance(runner.outlets[0].error, OutputError)


def test_when_no_sink_ever_worked_the_error_is_raised():
    runner = LiveRunner(
        Frames(frame(n) for n in [7]), LivePicture, [NeverWorked("rtmp")], log=pytest.fail
    )
    with pytest.raises(OutputError, match="rtmp was never reached"):
        runner.run()


def test_when_the_last_sink_fails_the_run_ends_with_its_error():
    broken = List(error=OutputError("nowhere to write"))

    def frames():
        while True:
            yield frame(0)
            time.sleep(0.001)

    with pytest.raises(OutputError, match="nowhere"):
        LiveRunner(Frames(frames()), LivePicture, [broken], log=pytest.fail).run(tick_seconds=0.01)
    until(lambda: not our_threads())


def test_a_run_ends_when_its_last_open_sink_fails(camera):
    ended, broken = List("ended"), List("broken", error=OutputError("nowhere to write"))
    runner = LiveRunner(camera, LivePicture, [ended, broken], log=pytest.fail)
    thread, raised = started(runner)
    runner.end(ended)
    until(lambda: ended.is_finished)
    camera.allowed.release()
    thread.join(20)
    assert isinstance(raised[0], OutputError)


@pytest.mark.parametrize("where", ["camera", "work", "sink"])
def test_an_error_ends_the_run_and_the_sinks_still_finish(where):
    good = List("good", waiting=9)

    def frames():
        yield frame(1)
        until(lambda: good.pictures)
        if where == "camera":
            raise InputError("no camera")
        while True:
            yield frame(2)
            time.sleep(0.001)

    def work(item):
        if where == "work" and item.pts == 2:
            raise InputError("no camera")
        return LivePicture(item)

    class Bad(List):
        def __call__(self, picture):
            if where == "sink" and picture.frame.pts == 2:
                raise ZeroDivisionError

    bad = Bad("bad")
    with pytest.raises(ZeroDivisionError if where == "sink" else InputError):
        LiveRunner(Frames(frames()), work, [good, bad], log=pytest.fail).run(tick_seconds=0.01)
    assert good.is_finished and bad.is_finished
    until(lambda: not our_threads())


def test_a_stop_from_another_thread_ends_sinks_and_camera(camera):
    sink = List()
    runner = LiveRunner(camera, LivePicture, [sink], log=pytest.fail)
    thread, raised = started(runner)
    camera.allowed.release()
    until(lambda: sink.pictures)
    runner.stop()
    thread.join(20)
    assert isinstance(raised[0], StoppedError) and sink.is_finished
    assert camera.closed.wait(20)


def test_ctrl_c_finishes_the_sinks_while_the_camera_is_stuck(camera, monkeypatch):
    monkeypatch.setattr(live_runner, "_CAMERA_SECONDS", 0.05)
    sink, camera.is_stuck = List(), True
    runner = LiveRunner(camera, LivePicture, [sink], log=pytest.fail)

    def interrupt():
        raise KeyboardInterrupt

    with pytest.raises(StoppedError):
        runner.run(interrupt, tick_seconds=0.01)
    assert sink.is_finished


def test_a_second_ctrl_c_still_finishes_each_sink_once():
    class Impatient(Camera):
        presses = 1

        def close(self):
            super().close()
            if self.presses:
                self.presses -= 1
                raise KeyboardInterrupt

    class Once(List):
        def finish(self):
            assert not self.is_finished
            super().finish()

    def interrupt():
        raise KeyboardInterrupt

    camera, sink = Impatient(), Once()
    runner = LiveRunner(camera, LivePicture, [sink], log=pytest.fail)
    with pytest.raises(KeyboardInterrupt):
        runner.run(interrupt, tick_seconds=0.01)
    with pytest.raises(StoppedError):
        runner.run()
    assert sink.is_finished and camera.closed.is_set()


def test_after_a_fault_a_sink_that_hangs_is_left_behind(monkeypatch):
    monkeypatch.setattr(live_runner, "_FINISH_SECONDS", 0.05)
    entered, gate, lines = threading.Event(), threading.Event(), []

    class Hanging(List):
        def __call__(self, picture):
            entered.set()
            super().__call__(picture)

    def frames():
        yield frame(1)
        assert entered.wait(20)
        raise InputError("no camera")

    runner = LiveRunner(Frames(frames()), LivePicture, [Hanging(gate=gate)], lines.append)
    with pytest.raises(InputError):
        runner.run(tick_seconds=0.01)
    assert lines == ["an output did not finish in time and is abandoned"]
    gate.set()
    until(lambda: not our_threads())


def test_pictures_waiting_for_a_failed_sink_are_released(camera):
    gate = threading.Event()
    broken = List("out.mkv", waiting=9, gate=gate, error=EncodeError("the disk is full"))
    other, lines = List("other", waiting=9), []
    runner = LiveRunner(camera, LivePicture, [broken, other], lines.append)
    thread, raised = started(runner)
    for number in range(1, 6):
        camera.allowed.release()
        until(lambda number=number: numbers(other.pictures)[-1:] == [number])
    assert runner.outlets[0].channel.fill == 4
    gate.set()
    until(lambda: lines)
    assert runner.outlets[0].channel.fill == 0
    camera.allowed.release()
    until(lambda: numbers(other.pictures)[-1:] == [6])
    runner.stop()
    thread.join(20)
    assert isinstance(raised[0], StoppedError)


def test_a_run_without_sinks_paints_until_the_camera_ends():
    painted = []

    def work(item):
        painted.append(item.pts)
        return LivePicture(item)

    LiveRunner(Frames(frame(n) for n in [7]), work, [], log=pytest.fail).run()
    assert painted == [7]


def test_preparing_precedes_frames_and_can_be_stopped(camera, monkeypatch):
    monkeypatch.setattr(live_runner, "_CAMERA_SECONDS", 0.05)
    prepared, gate, sink = [], threading.Event(), List()

    def prepare():
        gate.wait(20)
        prepared.append(camera.given)

    runner = LiveRunner(camera, LivePicture, [sink], pytest.fail, prepare)
    camera.allowed.release(5)
    thread, raised = started(runner)
    runner.stop()
    thread.join(20)
    assert isinstance(raised[0], StoppedError) and sink.is_finished
    gate.set()
    assert camera.closed.wait(20)
    assert prepared in ([0], [])


def test_the_time_base_of_live_frames_counts_microseconds():
    assert Fraction(1, 10**6) == LIVE_TIME_BASE
