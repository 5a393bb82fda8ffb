"""Stages, their threads and channels: order, errors, stops, memory."""

import _thread
import threading
import time
import traceback
import weakref

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from makeup_video.pipeline.engine.runner import Runner
from makeup_video.pipeline.errors import StoppedError


class List:
    """A sink that keeps every item."""

    def __init__(self, fail_at=None, slow_seconds=0.0):
        self.items, self.finished = [], None
        self.fail_at, self.slow_seconds = fail_at, slow_seconds

    def __call__(self, item):
        if item == self.fail_at:
            raise RuntimeError("sink broke")
        time.sleep(self.slow_seconds)
        self.items.append(item)

    def finish(self, stopped):
        self.finished = "stopped" if stopped else "done"


def numbers(count, fail_at=None):
    for item in range(count):
        if item == fail_at:
            raise RuntimeError("source broke")
        yield item


def forever():
    item = 0
    while True:
        yield item
        item += 1


def add_one(item):
    return item + 1


def our_threads():
    return [t for t in threading.enumerate() if t.name.startswith("makeup-")]


@given(
    count=st.integers(0, 40),
    stages=st.integers(0, 4),
    capacity=st.integers(1, 5),
    threads=st.none() | st.integers(1, 6),
)
@settings(deadline=None, max_examples=30)
def test_items_pass_every_stage_in_order(count, stages, capacity, threads):
    sink = List()
    steps = [(f"s{i}", add_one) for i in range(stages)]
    runner = Runner(("source", numbers(count)), steps, ("sink", sink), capacity, threads=threads)
    runner.run()
    assert sink.items == [n + stages for n in range(count)]
    assert sink.finished == "done"
    assert our_threads() == []
    assert all(times.items == count for times in runner.times.values())


class Delay:
    """A stage that looks two items ahead."""

    def __init__(self):
        self.kept = []

    def __call__(self, item):
        self.kept.append(item)
        return self.kept.pop(0) if len(self.kept) > 2 else None

    def drain(self):
        return self.kept


@given(
    count=st.integers(0, 20),
    looks_ahead=st.lists(st.booleans(), max_size=5),
    threads=st.integers(1, 5),
)
@settings(deadline=None, max_examples=30)
def test_stages_that_look_ahead_lose_nothing(count, looks_ahead, threads):
    sink = List()
    steps = [(f"s{i}", Delay() if ahead else add_one) for i, ahead in enumerate(looks_ahead)]
    Runner(("source", numbers(count)), steps, ("sink", sink), threads=threads).run()
    plain = looks_ahead.count(False)
    assert sink.items == [n + plain for n in range(count)]


@pytest.mark.parametrize(
    ("threads", "expected"),
    [
        (1, [["a", "b", "c", "d"]]),
        (2, [["a", "b"], ["c", "d"]]),
        (3, [["a"], ["b"], ["c", "d"]]),
        (4, [["a"], ["b"], ["c"], ["d"]]),
        (9, [["a"], ["b"], ["c"], ["d"]]),
    ],
)
def test_threads_share_neighbouring_stages_evenly(threads, expected):
    on_thread = {}

    def stage(name):
        def record_thread(item):
            on_thread[name] = threading.current_thread().name
            return item

        return record_thread

    stages = [(name, stage(name)) for name in "abcd"]
    Runner(("source", numbers(3)), stages, ("sink", List()), threads=threads).run()
    assert on_thread == {name: f"makeup-{group[0]}" for group in expected for name in group}


class Item:
    pass


def test_a_waiting_actor_keeps_no_item_alive():
    references, alive = [], []

    def source():
        for _ in range(3):
            item = Item()
            references.append(weakref.ref(item))
            yield item
            del item
            while any(ref() is not None for ref in references) and time.monotonic() < limit:
                time.sleep(0.001)
            alive.append(sum(ref() is not None for ref in references))

    class Sink(List):
        def __call__(self, item):
            pass

    limit = time.monotonic() + 5
    stages = [("a", lambda item: item), ("b", lambda item: item)]
    Runner(("source", source()), stages, ("sink", Sink()), threads=2).run()
    assert alive == [0, 0, 0]


@pytest.mark.parametrize("count", [0, 1, 2, 3, 10])
def test_a_stage_may_look_ahead_without_losing_items(count):
    sink = List()
    Runner(("source", numbers(count)), [("delay", Delay())], ("sink", sink)).run()
    assert sink.items == list(range(count))


def test_an_observer_gets_every_item_and_times_are_sums():
    timings = {}

    def observe(name, wall, cpu):
        timings.setdefault(name, []).append((wall, cpu))

    stages = [("delay", Delay())]
    runner = Runner(("source", numbers(9)), stages, ("sink", List()), observe=observe)
    runner.run()
    # the source is called once more to find its end, and the sink once more to finish
    assert {name: len(items) for name, items in timings.items()} == {
        "source": 10, "delay": 9, "sink": 10,
    }  # fmt: skip
    for name, items in timings.items():
        wall, cpu = (sum(part) for part in zip(*items, strict=True))
        times = runner.times[name]
        assert (times.busy_seconds, times.cpu_seconds) == pytest.approx((wall, cpu))


def broken(item):
    if item == 3:
        raise ZeroDivisionError("stage broke")
    return item


@pytest.mark.parametrize("where", ["source", "first stage", "last stage", "sink", "finish"])
@pytest.mark.parametrize("capacity", [1, 4])
def test_any_error_ends_the_run_at_once_and_is_raised(where, capacity):
    sink = List(fail_at=3 if where == "sink" else None)
    if where == "finish":
        sink.finish = lambda stopped: broken(3)
    source = numbers(10**9, 3) if where == "source" else forever()
    if where == "finish":
        source = numbers(5)
    first = broken if where == "first stage" else add_zero
    last = broken if where == "last stage" else add_zero
    runner = Runner(("source", source), [("a", first), ("b", last)], ("sink", sink), capacity)
    began = time.monotonic()
    with pytest.raises((RuntimeError, ZeroDivisionError), match="broke") as caught:
        runner.run()
    assert time.monotonic() - began < 2
    assert our_threads() == []
    names = [frame.name for frame in traceback.extract_tb(caught.value.__traceback__)]
    assert names[-1] in ("broken", "numbers", "__call__")
    if where != "finish":
        assert sink.finished is None


def add_zero(item):
    return item


def test_the_first_error_wins():
    both = threading.Barrier(2)

    def first(item):
        both.wait()
        raise ValueError("first")

    class Late(List):
        def finish(self, stopped):
            raise KeyError("second")

    def source():
        yield 0
        both.wait()
        time.sleep(0.1)
        raise KeyError("second")

    with pytest.raises(ValueError, match="first"):
        Runner(("source", source()), [("a", first)], ("sink", Late())).run()


@pytest.mark.parametrize("slow_seconds", [0.0, 0.01])
def test_ctrl_c_stops_in_two_seconds_and_the_sink_ends(slow_seconds):
    sink = List(slow_seconds=slow_seconds)
    runner = Runner(("source", forever()), [("a", add_one)], ("sink", sink))
    threading.Timer(0.3, _thread.interrupt_main).start()
    began = time.monotonic()
    with pytest.raises(StoppedError):
        runner.run()
    assert time.monotonic() - began < 2.3
    assert sink.finished == "stopped"
    assert sink.items == list(range(1, len(sink.items) + 1))
    assert our_threads() == []


def test_the_source_is_closed_when_the_run_ends_early():
    closed = []

    def source():
        try:
            yield from forever()
        finally:
            closed.append(True)

    with pytest.raises(RuntimeError):
        Runner(("source", source()), [], ("sink", List(fail_at=5))).run()
    assert closed == [True]


def test_a_run_that_is_stopped_drains_no_stage():
    def keep(item):
        return None

    def stop(done):
        raise KeyboardInterrupt

    keep.drain = pytest.fail
    with pytest.raises(StoppedError):
        Runner(("source", forever()), [("keep", keep)], ("sink", List())).run(stop, 0.01)


def test_a_slow_sink_keeps_memory_flat():
    """Back-pressure: the source is at most three capacities of a channel and two items ahead."""
    produced = []

    def source():
        for item in range(60):
            produced.append(item)
            yield item

    ahead = []

    class Slow(List):
        def __call__(self, item):
            time.sleep(0.001)
            ahead.append(len(produced) - item)

    Runner(("source", source()), [("a", add_one)], ("sink", Slow()), capacity=2).run()
    # two full channels, the items that the stage took at once, and one item each in source and sink
    assert max(ahead) <= 2 * 2 + 2 + 2


def test_a_stage_works_on_all_that_waits_before_the_next_does():
    done, has_begun, is_full = [], threading.Event(), threading.Event()

    def source():
        yield 0
        has_begun.wait(5)
        yield from (1, 2, 3)
        is_full.set()

    def stage(name):
        def record(item):
            has_begun.set()
            is_full.wait(5)
            done.append((name, item))
            return item

        return record

    stages = [(name, stage(name)) for name in "ab"]
    Runner(("source", source()), stages, ("sink", List()), capacity=3, threads=1).run()
    in_turn = [("a", 0), ("b", 0), *((name, item) for name in "ab" for item in (1, 2, 3))]
    assert done == in_turn


@pytest.mark.parametrize("fails_at", [1, 2, 3])
def test_threads_that_the_system_refuses_end_the_run(monkeypatch, fails_at):
    start, started = threading.Thread.start, []

    def refuse(thread):
        started.append(thread)
        if len(started) == fails_at:
            raise RuntimeError("can't start new thread")
        start(thread)

    monkeypatch.setattr(threading.Thread, "start", refuse)
    runner = Runner(("source", forever()), [("a", add_one)], ("sink", List()))
    with pytest.raises(RuntimeError, match="can't start new thread"):
        runner.run()
    assert our_threads() == []
