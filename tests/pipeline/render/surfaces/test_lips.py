"""Where lipstick goes, and how the lips are shaped."""

from dataclasses import replace

import cv2
import heads
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from makeup import close_up, inside, true_face
from makeup_video.pipeline.faces.face import MIN_FACE_PX
from makeup_video.pipeline.faces.topology import LIPS_INNER, LIPS_OUTER
from makeup_video.pipeline.frames.affine import compose, invert
from makeup_video.pipeline.render.surfaces.lips_twin import lips_surface
from makeup_video.pipeline.render.surfaces.surface import Edge

HW = (220, 200)


def weight_of(face, hw=HW, softness=0.5, origin_xy=(0, 0), wider=0.0):
    out = np.full(hw, np.nan, np.float32)
    lips_surface(face).weigh(out, origin_xy, Edge(softness, wider), None)
    return out


def turned(points, degrees, scale=1.0):
    """Turn and scale points about the middle of the picture."""
    angle = np.radians(degrees)
    spin = scale * np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    return (points - (100, 110)) @ spin.T + (100, 110)


@pytest.mark.parametrize("softness", [0.0, 0.5, 1.0])
def test_lips_are_covered_and_skin_is_not(softness):
    _, points = close_up()
    weight = weight_of(true_face(points), softness=softness)
    assert weight.min() == 0 and 0.99 < weight.max() <= 1
    outer, inner = inside(points[LIPS_OUTER], HW, 3), inside(points[LIPS_INNER], HW, -3)
    assert weight[outer & ~inner].mean() > (0.97 if softness < 1 else 0.8)
    assert weight[~inside(points[LIPS_OUTER], HW, -6)].max() == 0


def test_an_open_mouth_stays_free():
    _, points = close_up(100)
    face = true_face(points)
    within = inside(points[LIPS_INNER], HW, 1.5)
    assert within.sum() > 100
    for softness, most in ((0.0, 0.01), (0.5, 0.05), (1.0, 0.3)):
        assert weight_of(face, softness=softness)[within].max() < most


@given(st.sampled_from([40, 100, 150]), st.tuples(*2 * [st.floats(-70, 70)]), st.floats(-180, 180))
@settings(deadline=None, max_examples=30)
def test_how_far_inwards_is_as_on_the_whole_patch(frame, shift_xy, degrees):
    face = true_face(close_up(frame)[1])
    points = face.points_px.copy()
    points[:, :2] = turned(points[:, :2], degrees) + shift_xy  # the patch stays
    face = replace(face, points_px=points)
    to_patch, hw, away = invert(face.lips.to_px), face.lips.logits.shape, []
    for ring, bare in ((LIPS_OUTER, 0), (LIPS_INNER, 1)):
        drawn = np.full(hw, bare, np.uint8)
        on_patch = points[ring, :2] @ to_patch[:, :2].T + to_patch[:, 2]
        fixed = np.rint(on_patch.clip(-99, 999) * 16).astype(np.int32)
        cv2.fillPoly(drawn, [fixed], 1 - bare, shift=4)
        away.append(cv2.distanceTransform(drawn, cv2.DIST_L2, 3))
    share = cv2.GaussianBlur(away[0] / np.maximum(away[0] + away[1], 1), (0, 0), 1.0)
    whole = cv2.resize(share, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA)
    inward = lips_surface(face).fields().inward[0]
    np.testing.assert_allclose(inward, whole, atol=1e-6)  # float32 rounds in another order


def test_a_softer_edge_is_a_wider_one():
    _, points = close_up()
    face = true_face(points)
    widths = [((w > 0.05) & (w < 0.95)).sum() for w in (weight_of(face, softness=s)
              for s in (0.0, 0.5, 1.0))]  # fmt: skip
    assert widths[0] < widths[1] < widths[2]


@pytest.mark.parametrize("softness", [0.0, 0.5, 1.0])
@pytest.mark.parametrize("number", [0, 40, 100])
def test_pale_products_go_further_but_not_inwards(number, softness):
    _, points = close_up(number)
    face = true_face(points)
    usual, pale = (weight_of(face, softness=softness, wider=wider) for wider in (0.0, 1.0))
    assert (pale >= usual - 0.02).all()  # cubics swing a little
    opening = inside(points[LIPS_INNER], HW, 0)
    grown = (pale - usual).clip(0)
    assert grown[~inside(points[LIPS_OUTER], HW, 0)].sum() > 20
    if number:
        assert grown[opening].sum() < 0.1 * grown.sum()
    assert pale[~inside(points[LIPS_OUTER], HW, -8)].max() == 0


def test_the_edge_is_never_harder_than_a_pixel():
    _, points = close_up()
    weight = weight_of(true_face(points), softness=0.0)
    assert np.abs(np.diff(weight, axis=0)).max() < 0.95
    large = cv2.resize(weight, None, fx=2, fy=2)
    assert len(np.unique(large)) > 50


def test_the_contours_confine_a_mask_that_is_wrong():
    _, points = close_up()
    face = heads.face(points, logits=np.full((80, 112), 9, np.float32))
    weight = weight_of(face)
    assert weight[~inside(points[LIPS_OUTER], HW, -10)].max() == 0


def test_what_the_mask_leaves_out_is_not_painted():
    _, points = close_up()
    face = true_face(points)
    hand = face.lips.logits.copy()
    hand[:, 50:60] = -8
    weight_with_hand = weight_of(heads.face(points, logits=hand))
    column = round(face.lips.to_px[0] @ (55, 40, 1))
    assert weight_of(face)[:, column].max() == 1 and weight_with_hand[:, column].max() < 0.05


def odds_where_the_net_is_unsure(points):
    """(log-odds, inside of the outer border, that border in patch px) of a net that says 0.5."""
    face = heads.face(points, logits=np.zeros((80, 112), np.float32))
    to_patch = cv2.invertAffineTransform(face.lips.to_px)
    outer = points[LIPS_OUTER] @ to_patch[:, :2].T + to_patch[:, 2]
    return lips_surface(face).odds, inside(outer, (80, 112), 0), outer


def test_corners_are_painted_further_in_open_mouths():
    gains = []
    for number in (0, 100):  # shut, open
        odds, lips, outer = odds_where_the_net_is_unsure(close_up(number)[1])
        left, right = outer[:, 0].min(), outer[:, 0].max()
        at_corner = np.abs(np.arange(112) - (left + right) / 2) > 0.45 * (right - left)
        rim = lips ^ cv2.dilate(lips.astype(np.uint8), np.ones((3, 3))).astype(bool)
        gains.append(odds[rim & at_corner].mean() - odds[rim & ~at_corner].mean())
    assert gains[1] > gains[0] + 0.4


def test_below_shut_lips_less_is_painted_than_above():
    odds, lips, _ = odds_where_the_net_is_unsure(close_up(0)[1])
    columns = np.flatnonzero(lips.any(0))
    middle = columns[len(columns) // 3 : -len(columns) // 3]
    above = [odds[lips[:, x].argmax() - 1, x] for x in middle]
    below = [odds[len(lips) - lips[::-1, x].argmax(), x] for x in middle]
    assert np.mean(below) < np.mean(above) - 0.4


@pytest.mark.parametrize("visible", [0.0, 0.2, 0.4])
def test_a_hidden_mouth_has_no_lips(visible):
    _, points = close_up()
    assert lips_surface(heads.face(points, mouth_visible=visible)) is None
    assert lips_surface(heads.face(points, mouth_visible=0.5)) is not None


def test_a_rect_of_the_weight_is_a_part_of_the_whole():
    _, points = close_up()
    face = true_face(points)
    whole = weight_of(face)
    part = weight_of(face, (80, 90), origin_xy=(61, 103))
    np.testing.assert_allclose(part, whole[103:183, 61:151], atol=0.02)  # OpenCV rounds to 1/32 px


@settings(max_examples=100, deadline=None)
@given(st.floats(-180, 180), st.floats(0.3, 4), st.floats(0, 1), st.sampled_from([0, 75, 100]))
def test_nothing_is_painted_beyond_the_regions_corners(degrees, scale, softness, number):
    _, points = close_up(number)
    face = true_face(points)
    spin = turned(np.array([[0.0, 0], [1, 0], [0, 1]]), degrees, scale)
    spin = np.column_stack([spin[1] - spin[0], spin[2] - spin[0], spin[0]])
    face = heads.face(
        turned(points, degrees, scale),
        logits=face.lips.logits,
        to_px=compose(spin, face.lips.to_px),
    )
    region = lips_surface(face)
    low, high = np.array(region.reach(Edge(softness), None))
    hw = tuple(np.ceil(high - low).astype(int)[::-1] + 40)
    origin = np.floor(low).astype(int) - 20
    weight = weight_of(face, hw, softness, tuple(origin))
    y, x = np.nonzero(weight > 1 / 255)
    assert (x + origin[0] >= low[0] - 1).all() and (x + origin[0] <= high[0] + 1).all()
    assert (y + origin[1] >= low[1] - 1).all() and (y + origin[1] <= high[1] + 1).all()


@settings(max_examples=30, deadline=None)
@given(st.floats(-180, 180), st.floats(-1.5, 1.5), st.floats(-1.5, 1.5))
def test_normals_are_finite_and_face_the_viewer_on_any_face(degrees, lean, depth):
    _, points = close_up(100)
    points = turned(points, degrees)
    leaning = np.column_stack([points, depth * np.abs(points[:, 0] - 90) + lean * points[:, 1]])
    for variant in (leaning, leaning * (0.0, 1.0, 1.0), leaning * 0 + 50):
        region = lips_surface(heads.face(variant, to_px=heads.face(points).lips.to_px))
        if region is not None:
            assert np.isfinite(region.normals).all() and np.isfinite(region.odds).all()
            assert (np.square(region.normals[:2]).sum(0) < 1).all()
            assert (np.abs(region.normals[2] - 0.5) <= 0.5).all()  # a share of the highlights


def test_lips_bulge_towards_the_viewer():
    """The border of the upper lip looks up, that of the lower one down."""
    _, points = close_up()
    region = lips_surface(true_face(points))
    back = cv2.invertAffineTransform(region.grid.to_px)
    top, bottom = (points[index] @ back[:, :2].T + back[:, 2] for index in (0, 17))
    ny = region.normals[1]
    assert ny[round(top[1]) + 1, round(top[0])] < ny[round(bottom[1]) - 1, round(bottom[0])]


def test_faces_as_small_as_any_have_lips():
    _, points = close_up()
    points = turned(points, 0, MIN_FACE_PX / np.ptp(points[:, 0]))
    assert weight_of(true_face(points)).max() > 0.8


@pytest.mark.parametrize("sigma_px", [1.5, 5.0, 6.5, 9.5, 13.0, 25.0])
def test_soft_lips_have_a_gaussian_border_at_any_size(sigma_px):
    """A wide blur is made at a part of the size, in a part of the frame's weights."""
    lips = lips_surface(true_face(close_up()[1]))
    size = close_up()[0].shape[:2]
    sharp = np.zeros(size, np.float32)
    lips.weigh(sharp, (0, 0), Edge(0.5), None)
    around = np.zeros((size[0] + 20, size[1] + 30), np.float32)
    soft = around[10:-10, 15:-15]
    lips.weigh(soft, (0, 0), Edge(0.5, sigma_px=sigma_px), None)
    # the edge of soft lips is as wide as that of sharp ones: only the blur is added
    want = cv2.GaussianBlur(sharp, (0, 0), sigma_px)
    np.testing.assert_allclose(soft, want, atol=0.02)
    soft[:] = 0
    assert not around.any()
