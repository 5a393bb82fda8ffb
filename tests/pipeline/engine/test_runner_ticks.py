"""The progress reports of a run, and how the run ends when a report fails or stops it."""

import threading
import time

import pytest
from makeup_video.pipeline.engine.runner import Runner
from makeup_video.pipeline.errors import StoppedError


class Sink:
    """A sink whose `finish` takes as long as half a dozen ticks."""

    def __init__(self, slow_seconds=0.0):
        self.slow_seconds, self.finished, self.is_finishing = slow_seconds, [], False

    def __call__(self, item):
        time.sleep(self.slow_seconds)

    def finish(self, stopped):
        self.is_finishing = True
        time.sleep(0.06)
        self.finished.append("stopped" if stopped else "whole")


def forever():
    while True:
        yield 0


def runner(items, sink):
    return Runner(("source", (item for item in items)), [], ("sink", sink))


def items_after(event, count):
    """Items that come once the event is set, however busy the machine is."""
    assert event.wait(20)
    yield from range(count)


def our_threads():
    return [t for t in threading.enumerate() if t.name.startswith("makeup-")]


def test_ticks_report_what_reached_the_sink():
    counts = []

    def items():
        yield from range(30)
        while len(counts) <= 3:
            time.sleep(0.005)

    runner(items(), Sink()).run(counts.append, tick_seconds=0.01)
    assert counts == sorted(counts) and counts[-1] == 30


@pytest.mark.parametrize("count", [0, 1, 7])
def test_the_last_report_has_all_however_short_the_run(count):
    counts, sink = [], Sink()
    runner(range(count), sink).run(counts.append, tick_seconds=60)
    assert counts == [count] and sink.finished == ["whole"]


def test_nothing_is_reported_while_the_sink_finishes():
    sink, late, ticked = Sink(slow_seconds=0.01), [], threading.Event()

    def tick(done):
        late.append(sink.is_finishing)
        ticked.set()

    runner(items_after(ticked, 5), sink).run(tick, tick_seconds=0.01)
    assert late and not any(late)
    assert sink.finished == ["whole"]


def test_the_sink_waits_for_the_last_report():
    sink, ticking = Sink(), threading.Event()

    def tick(done):
        ticking.set()
        time.sleep(0.05)  # enough for all items to reach the sink
        raise OSError("terminal gone")

    with pytest.raises(OSError, match="terminal gone"):
        runner(items_after(ticking, 3), sink).run(tick, 0.0)
    assert sink.finished == []


@pytest.mark.parametrize(
    ("error", "raised", "finished"),
    [
        (OSError, OSError, []),
        (KeyboardInterrupt, StoppedError, ["stopped"]),
        (StoppedError, StoppedError, ["stopped"]),
    ],
)
def test_only_what_its_user_stops_is_finished(error, raised, finished):
    sink = Sink()

    def tick(done):
        raise error("no more")

    with pytest.raises(raised):
        runner(forever(), sink).run(tick, 0.01)
    assert sink.finished == finished
    assert our_threads() == []


def test_an_error_of_a_stage_counts_before_one_of_a_report():
    def failing():
        yield 0
        raise ValueError("no more frames")

    def tick(done):
        raise OSError("terminal gone")

    with pytest.raises(ValueError, match="no more frames"):
        runner(failing(), Sink()).run(tick, tick_seconds=60)
    assert our_threads() == []
