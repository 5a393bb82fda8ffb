"""Eyeshadow ends at the outline of the face, also where the head is turned away."""

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from layers import product, surface_weight
from makeup import close_up, true_face
from makeup_video.pipeline.faces.topology import RIGHT_EYE
from makeup_video.pipeline.look.look import Layer
from makeup_video.pipeline.render.grid import Grid
from makeup_video.pipeline.render.surfaces.eyes_twin import lid_surfaces
from makeup_video.pipeline.render.surfaces.face import OUTLINE
from makeup_video.pipeline.render.surfaces.face_outline import outline_of, within_outline

HW = (220, 200)
GRID = Grid(np.array(((2.0, 0, 40), (0, 2.0, 50))), (48, 32))
SQUARE = np.array(((0, 0), (1, 0), (1, 1), (0, 1)), np.float32)


def inside(points, more_px=0):
    """(H, W) bool: px within the outline, or up to `more_px` outside."""
    mask = np.zeros(HW, np.uint8)
    cv2.fillConvexPoly(
        mask, np.rint(cv2.convexHull(points[OUTLINE, :2].astype(np.float32))).astype(np.int32), 1
    )
    side = 2 * more_px + 1
    return cv2.dilate(mask, np.ones((side, side), np.uint8)) > 0


@settings(max_examples=30, deadline=None)
@given(
    left=st.floats(-200, 200), top=st.floats(-200, 200),
    wide=st.floats(1, 400), high=st.floats(1, 400),
)  # fmt: skip
def test_nothing_lies_beyond_the_outline(left, top, wide, high):
    outline = SQUARE * (wide, high) + (left, top)
    share = within_outline(outline.astype(np.float32), GRID)
    x, y = GRID.places().reshape(2, 32, 48)
    deep = np.minimum.reduce([x - left, left + wide - x, y - top, top + high - y]) / GRID.step_px()
    if share is None:
        assert deep.min() > 0
    else:
        assert share.min() >= 0 and share.max() <= 1
        assert share[deep < -1].max(initial=0) == 0 and share[deep > 4].min(initial=1) > 0.99


@pytest.mark.parametrize("squeeze", [1.0, 0.5, 0.25])
def test_eyeshadow_stays_on_a_turned_face(squeeze):
    """There the outline lies close to the far eye."""
    _, points = close_up()
    points = points.copy()
    corner = points[RIGHT_EYE[0], 0]
    far = points[:, 0] > corner
    points[far, 0] = corner + squeeze * (points[far, 0] - corner)
    layer = Layer("eyeshadow", product(edge_softness=1.0), {"slot": "full", "outer": 1.6})
    weights = [surface_weight(lid, layer, HW) for lid in lid_surfaces(true_face(points))]
    assert max(weight.max() for weight in weights) > 0.8
    for weight in weights:
        assert weight[~inside(points, 1)].max() < 0.05


def test_a_close_eye_needs_no_outline():
    _, points = close_up()
    middle = points[OUTLINE, :2].mean(0)
    small = Grid(np.array(((0.1, 0, middle[0]), (0, 0.1, middle[1]))), (48, 32))
    assert within_outline(outline_of(true_face(points)), small) is None
