"""The surface around the eye: heights at lashes, crease and brow; what is skin and what eyeball."""

import cv2
import heads
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from makeup import close_up, inside, true_face
from makeup_video.kernels.surface import LID_BROW_BELOW, LID_FOLD_UP, LID_LEAST, LID_STEP
from makeup_video.pipeline.faces.topology import (
    BROW,
    EYE,
    EYE_CONTOUR,
    RIGHT_BROW,
    RIGHT_EYE,
)
from makeup_video.pipeline.look.finishes import product
from makeup_video.pipeline.look.kinds.eyeshadow import KIND
from makeup_video.pipeline.render.surfaces.eyes import OUTWARDS
from makeup_video.pipeline.render.surfaces.eyes_twin import lid_surfaces
from makeup_video.pipeline.render.surfaces.surface import Edge

HW = (220, 200)
OPEN, SHUT = 60, 75  # frames of the sample
EYES = ((EYE, BROW, EYE_CONTOUR), (RIGHT_EYE, RIGHT_BROW, RIGHT_EYE[:16]))


def surfaces(number=OPEN, scale=1.0):
    """Yield both lids of a frame, scaled, each with its points, brow and contour in px."""
    points = close_up(number)[1][:, :2] * scale
    for region, (eye, brow, contour) in zip(lid_surfaces(true_face(points)), EYES, strict=True):
        yield region, points[eye], points[brow], points[contour]


def on_grid(region, field, points_px):
    """Return a field's values at px of the frame, interpolated."""
    back = cv2.invertAffineTransform(region.grid.to_px)
    x, y = (points_px @ back[:, :2].T + back[:, 2]).T.astype(np.float32)
    return cv2.remap(field, x[None], y[None], cv2.INTER_LINEAR)[0]


def skin_of(region, hw=HW):
    """Return the coverage (h, w) where all is painted above and below the eye; 1 beyond the grid
    and beyond the face."""
    on_face = np.ones(region.up.shape, np.float32) if region.on_face is None else region.on_face
    bare = (region.grid.warped(on_face, (0, 0), hw, 0.0) >= 1).astype(np.float32)
    for side in region.sides():
        out = np.full(hw, np.nan, np.float32)
        side.weigh(out, (0, 0), Edge(0.5), None)
        bare *= 1 - out
    return 1 - bare


@pytest.mark.parametrize("number", [OPEN, SHUT])
def test_heights_are_those_of_the_points(number):
    """Points near the middle of the eye; curves are straight between columns."""
    for region, eye, brow, _ in surfaces(number, 3.0):
        down = region.grid.to_px[:, 1] * LID_BROW_BELOW
        for points, height in (
            (eye[[11, 12, 13]], 0),
            (eye[[27, 28, 29]], 1),
            (eye[[43, 44, 45]], LID_FOLD_UP),
            (brow[1:4] + down, 2),
        ):
            np.testing.assert_allclose(on_grid(region, region.up, points), height, atol=0.12)


@pytest.mark.parametrize("number", [OPEN, SHUT])
def test_below_px_counts_from_the_lower_lashes(number):
    for region, eye, _, _ in surfaces(number, 3.0):
        lashes, down = eye[[3, 4, 5]], region.grid.to_px[:, 1] / region.grid.step_px()
        for further_px in (0, 10):
            below = on_grid(region, region.below_px, lashes + further_px * down)
            # less where the line is steep, and the grid's columns cut its bends
            np.testing.assert_allclose(below, further_px, atol=0.08 * further_px + 1.2)


def test_width_px_is_the_distance_of_the_corners():
    for region, eye, _, _ in surfaces():
        assert region.width_px == pytest.approx(np.hypot(*(eye[0] - eye[8])))


@settings(max_examples=30, deadline=None)
@given(st.integers(0, len(heads.HEAD_PX) - 1))
def test_heights_stay_apart_in_every_column(index):
    """At the corners the mesh's rings meet; the height there rises no faster than the least gap
    allows."""
    for region in lid_surfaces(heads.face(heads.HEAD_PX[index])):
        rise = -np.diff(region.up, axis=0)
        assert rise.min() > 0
        assert rise.max() < 1 / LID_LEAST + 1e-3


def test_the_crease_goes_on_beyond_the_outer_corner():
    for region, *_ in surfaces():
        rows = [np.interp(-1, -region.up[:, x], np.arange(len(region.up))) for x in (29, 33, 47)]
        lashes = [np.interp(0, -region.up[:, x], np.arange(len(region.up))) for x in (29, 33, 47)]
        just_inside, beyond, far = np.subtract(lashes, rows)
        assert just_inside * 0.4 < beyond < just_inside * 1.1
        assert LID_LEAST - 0.01 < far <= beyond


@pytest.mark.parametrize("scale", [1.0, 3.0])
def test_all_is_skin_but_the_eyeball(scale):
    hw = tuple(int(side * scale) for side in HW)
    for region, eye, _, contour in surfaces(OPEN, scale):
        skin = skin_of(region, hw)
        feather_px = max(0.025 * region.width_px, 1.2)
        assert skin.min() == 0 and skin.max() == 1
        assert skin[inside(contour, hw, 0.9 * scale)].max() < 0.05
        # the lash lines are curves through the contour's points, which bulge between them
        far = 1 - inside(contour, hw, -(feather_px + 0.04 * region.width_px + 1))
        across = (np.stack(np.mgrid[: hw[0], : hw[1]][::-1], -1) - eye[8]) @ (eye[0] - eye[8])
        between = (across > 0) & (across < region.width_px**2)
        assert skin[(far > 0) & between].min() == 1


def test_beyond_the_corners_all_is_skin_but_a_line():
    for number in (OPEN, SHUT):
        for region, eye, _, _ in surfaces(number, 3.0):
            skin = skin_of(region, (660, 600))
            outwards = eye[0] - eye[8]
            for corner, way in ((eye[0], outwards), (eye[8], -outwards)):
                x, y = np.rint(corner + 0.06 * way).astype(int)
                # both sides are feathered away from their lash lines, which meet there
                assert (1 - skin[y - 6 : y + 7, x]).sum() < 1.3 * 0.025 * region.width_px
            x, y = np.rint(eye[8] + 0.03 * outwards).astype(int)
            assert number == SHUT or skin[y, x] < 0.5  # the tear duct


def test_lash_lines_cross_at_the_outer_corner():
    """Both go on in their directions, so beyond the corner nothing lies between them."""
    for region, *_ in surfaces():
        for column in np.flatnonzero(OUTWARDS > 0.52):
            below_at_lashes = np.interp(0, -region.lash_px[:, column], region.below_px[:, column])
            assert below_at_lashes > 0.05


def test_shut_eyes_are_skin_but_for_the_line_of_lashes():
    for region, _, _, contour in surfaces(SHUT, 3.0):
        skin = skin_of(region, (660, 600))
        covered = cv2.contourArea(contour.astype(np.float32))
        assert (1 - skin).sum() < covered + 0.06 * region.width_px**2


def test_a_scaled_surface_has_scaled_distances():
    to_new = np.array([[2.0, 0, 0.5], [0, 2.0, 0.5]])
    for region, *_ in surfaces():
        larger = region.scaled(to_new)
        np.testing.assert_allclose(larger.below_px, 2 * region.below_px, rtol=1e-6)
        assert larger.width_px == pytest.approx(2 * region.width_px)
        assert larger.grid.step_px() / LID_STEP == pytest.approx(larger.width_px)


@settings(max_examples=20, deadline=None)
@given(st.floats(0.45, 1.0), st.floats(1.0, 1.3), st.sampled_from([OPEN, SHUT]))
def test_shadow_up_to_the_brow_ends_within_the_grid(narrow, high, number):
    """Even on an eye that is turned away, and below a raised brow."""
    points = close_up(number)[1][:, :2] * (narrow, high)
    for lid in lid_surfaces(true_face(points)):
        at, shape = lid.fields(), KIND.whole_shape({"slot": "full", "high": 2.0})
        (coat,) = KIND.coats(at, product((0, 0, 0), "matte", "eyes"), shape)
        assert coat.density.max() > 0.9
        assert coat.density[:, 0].max() < 0.08
