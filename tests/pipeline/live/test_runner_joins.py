"""Outputs that join a live run, and outputs that end before it does."""

import pytest
from live_doubles import Camera, List, started, until
from makeup_video.pipeline import OutputError, StoppedError, UsageError
from makeup_video.pipeline.live.interfaces import LivePicture
from makeup_video.pipeline.live.runner import LiveRunner


@pytest.fixture
def camera():
    """A camera whose thread ends before the next test."""
    source = Camera()
    yield source
    until(lambda: source.closed.is_set() or source.allowed.release())


def test_a_sink_joins_and_leaves_while_the_run_goes_on(camera):
    first, later = List("first"), List("later", waiting=9)
    runner = LiveRunner(camera, LivePicture, [first], log=pytest.fail)
    with pytest.raises(UsageError, match="no live run"):
        runner.add(List())
    thread, raised = started(runner)
    camera.allowed.release()
    until(lambda: first.pictures)
    runner.add(later)
    camera.allowed.release()
    until(lambda: len(later.pictures) == 1)
    runner.end(later)
    until(lambda: later.is_finished)
    seen = len(first.pictures)
    camera.allowed.release()
    until(lambda: len(first.pictures) == seen + 1)
    assert len(later.pictures) == 1 and not first.is_finished
    runner.stop()
    thread.join(20)
    assert isinstance(raised[0], StoppedError) and first.is_finished
    assert [outlet.is_over for outlet in runner.outlets] == [True, True]
    with pytest.raises(UsageError, match="no live run"):
        runner.add(List())


def test_a_sink_that_comes_as_the_run_ends_is_refused(camera):
    """Nobody would close its channel, and the run would wait for it for ever."""
    first, refused = List("first"), []
    runner = LiveRunner(camera, LivePicture, [first], log=pytest.fail)
    channel = runner.outlets[0].channel
    close = channel.close

    def join_and_close():
        with pytest.raises(UsageError, match="no live run"):
            runner.add(List("late"))
        refused.append(True)
        close()

    channel.close = join_and_close
    thread, _ = started(runner)
    camera.allowed.release()
    until(lambda: first.pictures)
    runner.stop()
    thread.join(20)
    assert refused and not thread.is_alive()


def test_a_joined_sink_that_fails_leaves_the_others(camera):
    first, lines = List("first", waiting=9), []
    runner = LiveRunner(camera, LivePicture, [first], log=lines.append)
    thread, _ = started(runner)
    camera.allowed.release()
    until(lambda: first.pictures)
    runner.add(List("later", error=OutputError("full")))
    camera.allowed.release()
    until(lambda: lines)
    assert "full; the rest goes on" in lines[0]
    camera.allowed.release()
    until(lambda: len(first.pictures) == 3)
    runner.stop()
    thread.join(20)


def test_a_recording_that_fails_as_it_ends_leaves_the_others(camera):
    class Full(List):
        def finish(self):
            raise OutputError("the disk is full")

    first, full, lines = List("first", waiting=9), Full(), []
    runner = LiveRunner(camera, LivePicture, [first, full], log=lines.append)
    thread, _ = started(runner)
    camera.allowed.release()
    until(lambda: first.pictures and full.pictures)
    runner.end(full)
    until(lambda: lines)
    camera.allowed.release()
    until(lambda: len(first.pictures) == 2)
    runner.stop()
    thread.join(20)
    assert lines == ["OutputError: the disk is full; the rest goes on"]
