"""The border of the lips: how far away it is, whatever its shape, and no spikes beside it."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from layers import lipstick, surface_weight
from makeup import close_up, true_face
from makeup_video.pipeline.render.surfaces.lips import LOWER, UPPER
from makeup_video.pipeline.render.surfaces.lips_twin import _border, lips_surface

HW = (60, 84)
ROWS, COLUMNS = np.arange(HW[0], dtype=np.float32)[:, None], np.arange(HW[1])
MIDDLE = np.array([42.0, 30.0])


def ring(radii, squeeze):
    """(80, 2) lip points whose border lies these distances from the middle, corner to corner."""
    turns = np.linspace(0, 2 * np.pi, 20, endpoint=False)
    places = MIDDLE + np.stack([-np.cos(turns), -squeeze * np.sin(turns)], 1) * radii[:, None]
    xy = np.zeros((80, 2), np.float32)
    xy[UPPER[0]] = places[:11]
    xy[LOWER[0]] = places[[0, *range(19, 9, -1)]]
    return xy, places.astype(np.float32)


@settings(max_examples=25, deadline=None)
@given(
    radii=st.lists(st.floats(8, 26), min_size=20, max_size=20),
    squeeze=st.floats(0.3, 1.4),
    turn=st.floats(-0.5, 0.5),
)
def test_the_border_is_as_far_as_the_polygon(radii, squeeze, turn):
    xy, places = ring(np.array(radii), squeeze)
    spin = np.array(((np.cos(turn), -np.sin(turn)), (np.sin(turn), np.cos(turn))))
    xy, places = ((one - MIDDLE) @ spin.T + MIDDLE for one in (xy, places))
    within = _border(xy, COLUMNS, ROWS)
    polygon = places.astype(np.float32)[:, None]
    for y in range(0, HW[0], 7):
        for x in range(0, HW[1], 7):
            far = cv2.pointPolygonTest(polygon, (float(x), float(y)), True)
            assert within[y, x] == pytest.approx(far, abs=2e-3)


def test_lips_that_bulge_beyond_their_corners_are_whole():
    """Distances down columns cut a round mouth off at its corners."""
    radii = np.full(20, 20.0)
    radii[[0, 10]] = 14  # both corners
    xy, places = ring(radii, 1.0)
    beyond = np.abs(places[:, 0] - MIDDLE[0]) > 15
    assert beyond.sum() >= 4
    within = _border(xy, COLUMNS, ROWS)
    x, y = np.rint(MIDDLE + 0.9 * (places[beyond] - MIDDLE)).astype(int).T
    assert within[y, x].min() > 0


@pytest.mark.parametrize("scale", [2, 3.3, 6])
def test_a_steep_fall_of_the_odds_leaves_no_spike(scale):
    _, points = close_up()
    surface = lips_surface(true_face(points * scale))
    odds = np.full_like(surface.odds, -60)
    odds[:, 50:] = -2.4  # still no lips
    cliff = replace(surface, odds=odds, boxes={})
    flat = np.zeros_like(surface.rim)
    cliff, surface = (replace(one, rim=flat, boxes={}) for one in (cliff, surface))
    whole = replace(surface, odds=np.full_like(odds, 4), boxes={})
    high, wide = (round(scale * side) for side in (220, 200))
    assert surface_weight(whole, lipstick(), (high, wide)).max() == 1
    assert surface_weight(cliff, lipstick(), (high, wide)).max() < 0.05
