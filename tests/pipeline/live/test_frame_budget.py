"""Simulated machines of all speeds, without a real clock."""

import itertools
import math
from collections.abc import Callable, Iterator

import pytest
from hypothesis import given
from hypothesis import strategies as st
from makeup_video.pipeline.engine.quality import QualityLevel
from makeup_video.pipeline.live import frame_budget
from makeup_video.pipeline.live.frame_budget import Budget

TICK = 1 / 30
COSTS = (1.0, 0.85, 0.65, 0.55)  # work per frame at each level, relative to level 0


def live(
    work_of: Callable[[float, int], float], seconds: float, budget: Budget, tick: float = TICK
) -> Iterator[tuple[float, int, float]]:
    """Simulate a camera, a slot for the newest frame, and a worker: (start, level, delay).

    work_of: (start time, level) -> seconds of work for a frame.
    """
    free_at, last, level = 0.0, 0, 0
    while free_at < seconds:
        # the worker takes the newest frame that has arrived, or waits for the next
        number = max(math.floor(free_at / tick + 1e-9), last + 1)
        arrival = number * tick
        start = max(free_at, arrival)
        work = work_of(start, level)
        free_at = start + work
        level = budget(work, (number - last) * tick, number - last - 1)
        last = number
        yield start, level, free_at - arrival


def steady(level_0_seconds: float) -> Callable[[float, int], float]:
    return lambda _, level: level_0_seconds * COSTS[level]


def changes(levels: list[int]) -> list[int]:
    return [b - a for a, b in zip([0, *levels], levels, strict=False) if a != b]


def test_a_fast_machine_stays_at_level_0():
    budget = Budget()
    assert {level for _, level, _ in live(steady(0.01), 120, budget)} == {0}
    assert budget.notice == ""


def test_a_hopeless_machine_stays_at_the_highest_level():
    budget = Budget()
    levels = [level for _, level, _ in live(steady(0.5), 300, budget)]
    assert changes(levels) == [1, 1, 1]
    assert levels[-1] == frame_budget.LOWEST and budget.notice == frame_budget.TOO_SLOW


def test_three_slow_seconds_cost_a_level():
    times = [(seconds, level) for seconds, level, _ in live(steady(0.033), 30, Budget())]
    first = next(seconds for seconds, level in times if level == 1)
    assert 2.9 < first < 3.2


@given(st.floats(0.001, 0.9), st.integers(0, 20))
def test_one_hiccup_costs_no_level(hiccup_seconds, at_seconds):
    def work_of(now, level):
        nonlocal is_due
        if is_due and now >= at_seconds:
            is_due = False
            return hiccup_seconds
        return 0.015

    is_due = True
    assert {level for _, level, _ in live(work_of, 30, Budget())} == {0}


def test_a_detector_too_slow_for_its_frames_costs_a_level():
    budget, frames = Budget(), 0

    def work_of(now, level):
        nonlocal frames
        frames += 1
        return 0.03 if frames % (7 if level == 0 else 30) == 0 else 0.015

    levels = [level for _, level, _ in live(work_of, 60, budget)]
    assert changes(levels) == [1]
    assert budget.notice == frame_budget.NOTICES[1]


@given(st.floats(0.001, 0.3), st.floats(0.001, 0.3), st.sampled_from([1 / 15, TICK, 1 / 60]))
def test_levels_change_by_one_and_ever_more_seldom(before, after, tick):
    """In ten minutes at a constant speed, no machine tries any level more than seven times."""

    def work_of(now, level):
        return (before if now < 60 else after) * COSTS[level]

    budget = Budget()
    run = [(seconds, level) for seconds, level, _ in live(work_of, 660, budget, tick)]
    assert set(changes([level for _, level in run])) <= {1, -1}
    later = [level for seconds, level in run if seconds >= 60]
    assert len(changes(later)) <= 3 + 2 * 7


@given(st.floats(0.02, 0.4))
def test_a_machine_that_gets_fast_returns_to_level_0(slow_seconds):
    def work_of(now, level):
        return (slow_seconds if now < 60 else 0.008) * COSTS[level]

    run = [(seconds, level) for seconds, level, _ in live(work_of, 120, Budget())]
    assert run[-1][1] == 0
    back = max((seconds for seconds, level in run if level > 0), default=0)
    assert back < 60 + 4 * (frame_budget.EASY_SECONDS + 2)


@given(st.floats(0.001, 0.5), st.integers(0, 99))
def test_delay_never_grows(level_0_seconds, seed):
    """The newest frame wins, so at any level a frame waits for at most one other frame."""
    jitter = [0.7 + 0.6 * ((seed * 7919 + i * 104729) % 101) / 100 for i in range(97)]

    def work_of(now, level):
        return level_0_seconds * COSTS[level] * jitter[int(now * 1000) % 97]

    run = list(live(work_of, 600, Budget()))
    most = level_0_seconds * 1.3
    assert max(delay for _, _, delay in run) <= 2 * most + 1e-6
    early = [delay for seconds, _, delay in run if 15 < seconds < 60]
    late = [delay for seconds, _, delay in run if seconds > 500]
    assert not late or max(late) <= max(max(early, default=0), 0) + TICK + most


def test_a_camera_that_was_away_does_not_count_as_slow():
    budget = Budget()
    for _ in range(20):
        assert budget(0.01, 5.0) == 0
        for _ in range(40):
            assert budget(0.01, TICK) == 0
    assert budget(0.01, -1.0) == 0


def test_a_level_that_failed_is_tried_again_ever_later():
    """The machine is fast at level 1, and much too slow at level 0."""
    budget = Budget()
    tries = [
        seconds
        for (seconds, level, _), (_, before, _) in _pairs(
            live(lambda _, level: 0.01 if level else 0.033, 300, budget)
        )
        if level < before
    ]
    waits = [b - a for a, b in itertools.pairwise(tries)]
    assert all(b > 1.6 * a for a, b in itertools.pairwise(waits))
    assert len(waits) >= 3


def _pairs(run):
    items = list(run)
    return list(zip(items[1:], items, strict=False))


@pytest.mark.parametrize("work_seconds", [0.005, 0.02])
def test_frames_in_pairs_or_late_do_not_count_as_slow(work_seconds):
    budget = Budget()
    for index in range(3000):
        assert budget(work_seconds, 0.001 if index % 2 else 2 * TICK - 0.001) == 0
    for index in range(3000):
        assert budget(work_seconds, TICK * (1 + 0.6 * math.sin(index * 7.3))) == 0


def test_a_stall_of_five_seconds_costs_no_level():
    """The stalled frame reports the dropped frames, and the next frame reports the interval."""
    budget = Budget()
    for _ in range(10):
        for _ in range(300):
            assert budget(0.01, TICK) == 0
        assert budget(5.0, TICK, 150) == 0
        assert budget(0.01, 5.0) == 0


def test_the_message_about_the_level_does_not_flicker():
    """At the highest level, every sixth second is fast enough."""
    budget, notices = Budget(), []
    for second in range(600):
        for _ in range(30):
            budget(0.02 if second % 6 == 5 else 0.04, TICK)
            notices.append(budget.notice)
    assert sum(a != b for a, b in itertools.pairwise(notices)) <= 4
    assert notices[-1] == frame_budget.TOO_SLOW
    for _ in range(30 * 7):
        budget(0.02, TICK)
    assert budget.notice == frame_budget.NOTICES[frame_budget.LOWEST]


def test_every_level_but_the_first_has_a_notice_of_its_own():
    assert list(frame_budget.NOTICES) == list(QualityLevel)
    assert (
        frame_budget.NOTICES[QualityLevel.FULL] == ""
        and len(set(frame_budget.NOTICES.values())) == 4
    )
