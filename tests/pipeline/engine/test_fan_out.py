"""A sink made of several sinks: each gets every item, and an error ends only its own sink."""

import threading

import pytest
from hypothesis import given
from hypothesis import strategies as st
from makeup_video.pipeline.engine.fan_out import FanOut
from makeup_video.pipeline.engine.machine import cores
from makeup_video.pipeline.engine.runner import Runner
from makeup_video.pipeline.engine.split_evenly import split_evenly


class Keep:
    """A sink that keeps its items; it may fail at one item, or at the end."""

    def __init__(self, fails_at=None):
        self.fails_at, self.items, self.finished = fails_at, [], None

    def __call__(self, item):
        if item == self.fails_at:
            raise OSError(f"no room for {item}")
        self.items.append(item)

    def finish(self, stopped):
        if self.fails_at == "finish":
            raise OSError("no room at the end")
        self.finished = stopped


def fan_of(sinks):
    spans = split_evenly(len(sinks), cores())
    groups = [sinks[span.start : span.stop] for span in spans]
    return FanOut(groups, lambda item: [item] * len(sinks))


def run(fan, items):
    def source():
        yield from items

    Runner(("source", source()), [], ("fan", fan)).run()


@given(
    st.lists(st.one_of(st.none(), st.integers(0, 30), st.just("finish")), min_size=1, max_size=6),
    st.integers(0, 20),
)
def test_every_sink_gets_all_items_up_to_its_own_error(fails, count):
    sinks = [Keep(at) for at in fails]
    fan = fan_of(sinks)
    failing = [at == "finish" or (at is not None and at < count) for at in fails]
    try:
        run(fan, range(count))
    except OSError:
        assert all(failing)
    for sink, fails_at, failed, error in zip(sinks, fails, failing, fan.errors, strict=True):
        if all(failing):
            break  # the run may have ended before the last item
        end = fails_at if failed and fails_at != "finish" else count
        assert sink.items == list(range(end))
        assert (error is not None) == failed
        assert sink.finished == (None if failed else False)
    fan.cancel()


def test_the_run_ends_once_every_sink_has_failed():
    fan = fan_of([Keep(0), Keep(1)])
    taken = []

    def endless():
        number = 0
        while True:
            taken.append(number)
            yield number
            number += 1

    with pytest.raises(OSError, match="no room for"):
        Runner(("source", endless()), [], ("fan", fan)).run()
    fan.cancel()
    assert len(taken) < 30  # no more than the channels hold


def test_an_error_from_elsewhere_ends_a_sink():
    sinks = [Keep(), Keep()]
    fan = fan_of(sinks)
    fan.errors[1] = OSError("its file is full")
    run(fan, range(3))
    assert sinks[0].items == [0, 1, 2] and sinks[0].finished is False
    assert sinks[1].items == [] and sinks[1].finished is None


def test_the_end_of_a_sink_is_told_once_with_its_error_known():
    sinks, told = [Keep(1), Keep(), Keep("finish")], []
    fan = FanOut([[one] for one in sinks], lambda item: [item] * 3,
                 lambda index: told.append((index, str(fan.errors[index]))))  # fmt: skip
    run(fan, range(5))
    assert sorted(told) == [(0, "no room for 1"), (2, "no room at the end")]


def test_a_cancelled_fan_finishes_nothing():
    sinks = [Keep(), Keep()]
    fan = fan_of(sinks)
    fan(1)
    fan.cancel()
    assert [sink.finished for sink in sinks] == [None, None]
    assert not [one for one in threading.enumerate() if one.name == "makeup-fan-out"]
