"""What a run reports meanwhile, and how it ends when the report fails or stops it."""

import threading
import time

import pytest
from makeup_video.pipeline.engine.runner import Runner
from makeup_video.pipeline.errors import StoppedError


class Sink:
    """Counts items; `finish` takes as long as half a dozen ticks."""

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


def our_threads():
    return [t for t in threading.enumerate() if t.name.startswith("makeup-")]


def test_ticks_report_what_reached_the_sink():
    counts = []
    runner(range(30), Sink(slow_seconds=0.01)).run(counts.append, tick_seconds=0.02)
    assert len(counts) > 3 and counts == sorted(counts) and counts[-1] <= 30


def test_nothing_is_reported_while_the_sink_finishes():
    sink, late = Sink(slow_seconds=0.01), []
    runner(range(5), sink).run(lambda done: late.append(sink.is_finishing), tick_seconds=0.01)
    assert late and not any(late)
    assert sink.finished == ["whole"]


def test_the_sink_waits_for_the_last_report():
    sink = Sink()

    def tick(done):
        time.sleep(0.05)  # meanwhile all items reach the sink
        raise OSError("terminal gone")

    with pytest.raises(OSError, match="terminal gone"):
        runner(range(3), sink).run(tick, 0.0)
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
