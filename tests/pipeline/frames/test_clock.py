import math
from fractions import Fraction
from itertools import pairwise

import pytest
from heads import frame
from hypothesis import example, given
from hypothesis import strategies as st
from makeup_video.pipeline.frames.clock import GAP_SECONDS, EvenTimes, MediaClock, is_new_slot


@given(st.lists(st.integers(-(10**6), 10**6), max_size=40))
def test_time_always_increases(all_pts):
    clock = MediaClock()
    seconds = [clock.tick(frame(pts, Fraction(1, 600))) for pts in all_pts]
    assert all(a < b for a, b in pairwise(seconds))


def test_the_first_pts_may_be_0_and_its_interval_counts():
    clock = MediaClock()
    assert [clock.tick(frame(pts)) for pts in (0, 3)] == pytest.approx([0, 0.1])


def test_a_repeated_or_earlier_stamp_counts_as_one_usual_step():
    clock = MediaClock()
    seconds = [clock.tick(frame(pts, Fraction(1, 100))) for pts in (0, 4, 4, 2, 6)]
    assert seconds == pytest.approx([0, 0.04, 0.08, 0.12, 0.16])


def test_a_pause_is_no_usual_step():
    clock = MediaClock()
    seconds = [clock.tick(frame(pts, Fraction(1, 100))) for pts in (0, 500, 500)]
    assert seconds == pytest.approx([0, 5, 5 + GAP_SECONDS])


def test_what_is_due_once_in_a_slot_is_due_in_its_first_frame():
    last, due = -math.inf, []
    for number in (0, 1, 2, 3, 4, 7, 8, 1, 2):  # tenths of a second; the clock jumps back once
        if is_new_slot(number / 10, last, 0.3):
            due.append(number)
            last = number / 10
    assert due == [0, 3, 7, 1]


def test_times_are_evened_only_where_frames_come_too_close():
    even = EvenTimes()
    steady = [even(index / 30) for index in range(30)]
    assert steady == [index / 30 for index in range(30)]
    pair = [even(31 / 30 - 0.001), even(31 / 30)]
    assert pair[0] == 31 / 30 - 0.001
    assert 0.7 / 30 < pair[1] - pair[0] < 1 / 30


STEADY, BURST, PAUSE = st.floats(0.01, 0.14), st.floats(1e-6, 0.005), st.floats(0.15, 3)


@given(
    st.lists(st.tuples(STEADY | BURST | PAUSE, st.integers(1, 40)), min_size=1, max_size=8),
    st.sampled_from([0.0, 2e7]),  # a clock that has run for months
)
@example([(0.125, 40), (0.003, 3), (0.16, 1)], 0.0)
def test_even_times_increase_and_never_run_far_ahead(steps, now):
    even, times = EvenTimes(), [-1.0]
    for step, count in steps:
        for _ in range(count):
            now += step
            times.append(even(now))
            assert times[-1] > times[-2]
            assert now <= times[-1] < now + 10 * GAP_SECONDS
