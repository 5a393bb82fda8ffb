"""The surface of a face: its places stick to the face, and it is bare skin only."""

import math

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from lit_faces import face_at, points, surface_made
from makeup import LAYOUTS
from makeup_video.kernels.face import SIDE
from makeup_video.pipeline.faces.net import read_array
from makeup_video.pipeline.faces.topology import EYE_CONTOUR, LIPS_OUTER
from makeup_video.pipeline.render.surfaces.face import face_on_grid
from makeup_video.pipeline.render.surfaces.face_twin import light_on_face
from makeup_video.pipeline.render.surfaces.surface import Edge
from people import frame_of, portrait

MEAN = read_array("mean_face.npy").astype(np.float64)
MIRROR = read_array("mirror.npy")
CHEEKS = [50, 280, 205, 425, 117, 346, 187, 411, 101, 330]
NOSE_AND_BOW = [1, 4, 5, 195, 197, 0, 37, 267, 164]
GREY = frame_of(np.full((500, 500, 3), 120, np.uint8))
ALL = np.ones((SIDE, SIDE), np.float32)
EDGE = Edge(0.5)


def surface_of(points_px, frame=GREY):
    surface, _, _ = surface_made(face_at(points_px), frame)
    return surface


def turned(yaw=0.0, roll=0.0, iod_px=200.0):
    """(478, 3) px: the mean face, turned to the picture's right and clockwise by degrees."""
    a, b = math.radians(yaw), math.radians(roll)
    about_y = np.array([[math.cos(a), 0, -math.sin(a)], [0, 1, 0], [math.sin(a), 0, math.cos(a)]])
    about_z = np.array([[math.cos(b), -math.sin(b), 0], [math.sin(b), math.cos(b), 0], [0, 0, 1]])
    head = MEAN - [0, 0.35, 0]
    return head @ (about_z @ about_y).T * iod_px + [250, 250, 0]


def read(surface, field, xy_px):
    """A field of the surface at places (N, 2) of the frame."""
    to_grid = cv2.invertAffineTransform(surface.grid.to_px)
    at = (xy_px @ to_grid[:, :2].T + to_grid[:, 2]).astype(np.float32)
    return cv2.remap(field, at[None, :, 0], at[None, :, 1], cv2.INTER_LINEAR)[0]


def off_percent(points_px, chosen):
    """How far off the surface puts points of the face, in % of the IOD of the mean face."""
    surface = surface_of(points_px)
    xy = points_px[chosen, :2]
    got = np.column_stack([read(surface, field, xy) for field in (surface.across, surface.down)])
    return 100 * np.linalg.norm(got - MEAN[chosen, :2], axis=1)


def test_a_real_face_has_the_places_of_the_mean_face():
    off = off_percent(points(), CHEEKS + NOSE_AND_BOW)
    assert np.median(off) < 1 and off.max() < 3


@pytest.mark.parametrize("yaw", [-40, -20, 20, 40])
def test_a_turned_face_keeps_the_places_that_are_seen(yaw):
    seen = [i for i in CHEEKS if MEAN[i, 0] * yaw < 0]  # on the side towards the viewer
    assert off_percent(turned(yaw), seen).max() < 2
    assert off_percent(turned(yaw), NOSE_AND_BOW).max() < 4  # beside what the nose hides


@pytest.mark.parametrize("roll", [-120, -35, 60, 180])
def test_a_tilted_face_keeps_its_places_and_normals(roll):
    upright, tilted = surface_of(turned(20)), surface_of(turned(20, roll))
    np.testing.assert_allclose(tilted.across, upright.across, atol=2e-3)  # float32
    np.testing.assert_allclose(tilted.down, upright.down, atol=2e-3)
    np.testing.assert_allclose(tilted.normals, upright.normals, atol=5e-3)


def test_a_mirrored_face_has_mirrored_places():
    mirrored = turned(15)[MIRROR] * [-1, 1, 1] + [500, 0, 0]
    one, other = surface_of(turned(15)), surface_of(mirrored)
    np.testing.assert_allclose(other.across[:, ::-1], -one.across, atol=2e-3)
    np.testing.assert_allclose(other.visible[:, ::-1], one.visible, atol=0.1)  # whole px of masks


def test_normals_point_out_of_the_face():
    surface = surface_of(turned())
    left, right = read(surface, surface.normals[0], turned()[[117, 346], :2])
    assert left < -0.2 and right > 0.2
    assert read(surface, surface.facing, turned()[[5], :2])[0] > 0.8


def test_jitter_of_the_points_moves_places_less():
    rng = np.random.default_rng(5)
    head, iod_px = turned(10), 200
    at = head[[*CHEEKS, 5, 164], :2]
    moved = []
    for _ in range(12):
        shaken = head + rng.normal(0, 0.001 * iod_px, head.shape)
        surface = surface_of(shaken)
        moved.append([read(surface, surface.across, at), read(surface, surface.down, at)])
    assert np.std(moved, axis=0).mean() < 0.001


@pytest.mark.parametrize("yaw", [0, 40])
def test_nothing_is_visible_beyond_the_outline(yaw):
    head = turned(yaw)
    surface = surface_of(head)
    outline = cv2.convexHull(head[:, :2].astype(np.float32))
    at = surface.grid.places().T.tolist()
    off = np.array([cv2.pointPolygonTest(outline, xy, True) for xy in at])
    assert surface.visible.ravel()[off < -1].max() == 0
    assert (surface.visible.ravel()[off > 20] > 0.5).mean() > 0.5


def test_nothing_is_visible_on_eyes_and_lips():
    surface = surface_of(turned())
    for contour in (EYE_CONTOUR, LIPS_OUTER):
        middle = turned()[contour, :2].mean(0, keepdims=True)
        assert read(surface, surface.visible, middle)[0] == 0
    assert read(surface, surface.visible, turned()[CHEEKS, :2]).min() > 0.9


def test_the_far_cheek_of_a_turned_face_is_hidden():
    head = turned(40)
    surface = surface_of(head)
    near, far = read(surface, surface.visible, head[[187, 411], :2])
    assert near > 0.9 and far < 0.3


def test_weight_lies_within_the_reach_and_is_the_density():
    surface = surface_of(turned())
    density = (np.hypot(surface.across - 0.45, surface.down - 0.3) < 0.2).astype(np.float32)
    weight = np.full((500, 500), 7, np.float32)
    surface.weigh(weight, (0, 0), EDGE, density)
    low, high = np.array(surface.reach(EDGE, density))
    y, x = np.nonzero(weight)
    assert x.min() >= low[0] and y.min() >= low[1] and x.max() <= high[0] and y.max() <= high[1]
    cheek = turned()[280, :2].round().astype(int)
    assert weight[cheek[1], cheek[0]] > 0.95
    assert weight[weight > 0].min() >= 1 / 512
    part = np.empty((60, 80), np.float32)
    surface.weigh(part, (320, 230), EDGE, density)
    np.testing.assert_allclose(part, weight[230:290, 320:400], atol=0.02)  # 1/32 px in OpenCV


def test_no_density_has_no_reach():
    low, high = np.array(surface_of(turned()).reach(EDGE, 0 * ALL))
    assert (high < low).all()


def test_a_scaled_surface_lies_on_the_scaled_picture():
    surface = surface_of(turned())
    half = surface.scaled(np.array([[0.5, 0, -0.25], [0, 0.5, -0.25]]))
    xy = turned()[CHEEKS, :2]
    want = read(surface, surface.across, xy)
    np.testing.assert_allclose(read(half, half.across, xy / 2 - 0.25), want, atol=1e-3)


def test_the_mean_light_is_that_of_the_cheeks():
    surface = surface_of(turned())
    light = np.where(np.abs(surface.across) < 0.15, 0.9, 0.2).astype(np.float32)  # a shining nose
    shading, mean = light_on_face(surface, light)
    assert mean == pytest.approx(0.2, abs=1e-3)
    assert shading.shape == light.shape and shading.min() > 0.19 and shading.max() < 0.91


@pytest.mark.parametrize("pix_fmt", [*LAYOUTS, "gray"])
def test_every_layout_gives_nearly_the_same_surface(pix_fmt):
    frame = frame_of(portrait(), pix_fmt=pix_fmt)
    surface, shading, mean = surface_made(face_at(points()), frame)
    reference = frame_of(portrait(), pix_fmt="yuv444p")
    want, want_shading, want_mean = surface_made(face_at(points()), reference)
    assert mean == pytest.approx(want_mean, rel=0.1)
    cheek = (np.abs(want.across) < 0.5) & (want.visible > 0.9)
    rtol = 0.3 if pix_fmt == "gray" else 0.25  # the lightness of red skin is lower in luma alone
    np.testing.assert_allclose(shading[cheek], want_shading[cheek], rtol=rtol)
    assert surface.likeness[cheek].mean() > 0.85  # folds and shine are not


@pytest.mark.parametrize(
    "broken",
    [
        np.full((478, 3), np.nan),
        np.full((478, 3), 100.0),
        turned(iod_px=5),
        np.where(np.arange(478)[:, None] == 300, np.inf, turned()),
    ],
    ids=["nan", "one place", "small", "one point at infinity"],
)
def test_a_face_without_a_surface_has_none(broken):
    assert face_on_grid(face_at(broken)) is None
    assert surface_made(face_at(broken), GREY) is None


@settings(max_examples=40, deadline=None)
@given(st.integers(0, 2**32 - 1), st.sampled_from([0.05, 1.0, 30.0, 1e4]), st.booleans())
def test_any_points_give_a_finite_surface(seed, spread_px, is_flat):
    rng = np.random.default_rng(seed)
    anything = turned(rng.uniform(-80, 80)) + rng.normal(0, spread_px, (478, 3))
    if is_flat:
        anything[:, 1] = 250
    made = surface_made(face_at(anything), GREY)
    if made is None:
        return
    surface, shading, mean = made
    for field in (surface.across, surface.down, surface.normals, shading):
        assert np.isfinite(field).all()
    for share in (surface.facing, surface.visible, surface.likeness):
        assert share.min() >= 0 and share.max() <= 1
    assert math.isfinite(mean)


def test_the_same_frame_gives_the_same_surface():
    frame = frame_of(portrait())
    one, other = surface_of(points(), frame), surface_of(points(), frame)
    for name in ("across", "down", "visible", "likeness"):
        np.testing.assert_array_equal(getattr(one, name), getattr(other, name))
