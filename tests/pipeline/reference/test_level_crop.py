"""Crops in which a line of a face lies level."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from makeup_video.pipeline.reference.level_crop import level_place

SIZE_WH, APART_PX = (112, 80), 50.0
PLACES = st.tuples(st.floats(-300, 900), st.floats(-300, 900))


def place(left, right, below_px=0.0, **how):
    """The map of a crop in which these points, (x, y) px, lie level."""
    left, right = np.array(left), np.array(right)
    centre = (SIZE_WH[0] - 1) / 2, (SIZE_WH[1] - 1) / 2 - below_px
    return level_place(right - left, APART_PX, (left + right) / 2, centre, **how)


def in_crop(to_px, at):
    return np.linalg.solve(to_px[:, :2], np.array(at) - to_px[:, 2])


@given(left=PLACES, right=PLACES, below_px=st.floats(-30, 30))
def test_the_points_lie_level_and_as_far_apart_as_asked(left, right, below_px):
    assume(np.hypot(*np.subtract(left, right)) > 1)
    to_px = place(left, right, below_px)
    middle = (np.array(SIZE_WH) - 1) / 2 - [0, below_px]
    for point, side in ((left, -1), (right, 1)):
        level = middle[0] + side * APART_PX / 2, middle[1]
        assert in_crop(to_px, point) == pytest.approx(level, abs=0.05)
    assert np.linalg.det(to_px[:, :2]) > 0  # no mirror image
    mirrored = place(left, right, below_px, is_mirrored=True)
    assert in_crop(mirrored, left) == pytest.approx(in_crop(to_px, left), abs=0.05)
    assert np.linalg.det(mirrored[:, :2]) < 0


@given(at=PLACES)
def test_points_in_one_place_still_have_a_crop(at):
    to_px = place(at, at)
    assert np.isfinite(to_px).all() and abs(np.linalg.det(to_px[:, :2])) > 0
