from fractions import Fraction
from itertools import pairwise

import pytest
from heads import frame
from hypothesis import given
from hypothesis import strategies as st
from makeup_video.pipeline.face_tracks import Clock


@given(st.lists(st.integers(-(10**6), 10**6), max_size=40))
def test_time_always_goes_on(all_pts):
    clock = Clock()
    seconds = [clock.tick(frame(pts, Fraction(1, 600))) for pts in all_pts]
    assert all(a < b for a, b in pairwise(seconds))


def test_the_first_pts_may_be_0_and_its_interval_counts():
    clock = Clock()
    assert [clock.tick(frame(pts)) for pts in (0, 3)] == pytest.approx([0, 0.1])


def test_a_repeated_or_earlier_stamp_counts_as_one_usual_step():
    clock = Clock()
    seconds = [clock.tick(frame(pts, Fraction(1, 100))) for pts in (0, 4, 4, 2, 6)]
    assert seconds == pytest.approx([0, 0.04, 0.08, 0.12, 0.16])
