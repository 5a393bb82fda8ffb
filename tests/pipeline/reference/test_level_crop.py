"""Crops in which two points of a face lie level."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from makeup_video.pipeline.faces.topology import EYE_CORNERS
from makeup_video.pipeline.reference.level_crop import level_place
from reference_photos import face

SIZE_WH, APART_PX = (112, 80), 50.0
PLACES = st.tuples(st.floats(-300, 900), st.floats(-300, 900))


def place(left, right, below_px=0.0):
    """The map of a crop of a face whose eyes' corners lie there, (x, y) px."""
    points = face().points_px.copy()
    points[list(EYE_CORNERS), :2] = left, right
    moved = replace(face(), points_px=points)
    return level_place(moved, EYE_CORNERS, APART_PX, SIZE_WH, below_px)


def in_crop(to_px, at):
    return np.linalg.solve(to_px[:, :2], np.float32(at) - to_px[:, 2])


@given(left=PLACES, right=PLACES, below_px=st.floats(-30, 30))
def test_the_points_lie_level_and_as_far_apart_as_asked(left, right, below_px):
    assume(np.hypot(*np.subtract(left, right)) > 1)
    to_px = place(left, right, below_px)
    middle = (np.array(SIZE_WH) - 1) / 2 - [0, below_px]
    for point, side in ((left, -1), (right, 1)):
        level = middle[0] + side * APART_PX / 2, middle[1]
        assert in_crop(to_px, point) == pytest.approx(level, abs=0.05)  # float32
    assert np.linalg.det(to_px[:, :2]) > 0  # no mirror image


@given(at=PLACES)
def test_points_in_one_place_still_have_a_crop(at):
    to_px = place(at, at)
    assert np.isfinite(to_px).all() and abs(np.linalg.det(to_px[:, :2])) > 0
