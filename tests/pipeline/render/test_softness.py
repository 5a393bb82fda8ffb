"""How soft a picture is at a face, and makeup that is as soft as the picture."""

import cv2
import numpy as np
import pytest
from heads import HEAD_PX, face
from hypothesis import given, settings
from hypothesis import strategies as st
from layers import densities, shadow
from makeup import close_up, scene_of, true_face
from makeup_video.pipeline.faces.face import FrameFaces, iod_px
from makeup_video.pipeline.faces.topology import LIPS_OUTER
from makeup_video.pipeline.render.build_scene import BuildScene
from makeup_video.pipeline.render.surfaces.eyes_twin import lid_surfaces
from makeup_video.pipeline.render.surfaces.lips_twin import lips_surface
from makeup_video.pipeline.render.surfaces.surface import Edge
from people import clip, clip_points, frame_of

RGB8, POINTS = clip(1)[0], clip_points(1)[0]
IOD = iod_px(true_face(POINTS))
LAYOUTS = "yuv420p", "yuv444p", "nv12", "yuv420p10le", "gray"


def blurred(rgb8, share):
    """A picture with a blur whose sigma is a share of the distance of the eyes."""
    return cv2.GaussianBlur(rgb8, (0, 0), share * IOD) if share else rgb8


def softness(rgb8, points=POINTS, pix_fmt="yuv420p"):
    """Of lips and eyes, as shares of the distance of the eyes."""
    (seen,) = scene_of(frame_of(rgb8, pix_fmt=pix_fmt), (true_face(points),)).faces
    unit = iod_px(seen.face)
    return seen.blur_px["lips"] / unit, seen.blur_px["eyes"] / unit


def test_a_sharp_picture_is_not_soft():
    assert softness(RGB8) == (0, 0)
    assert softness(*close_up()) == (0, 0)


@settings(max_examples=25, deadline=None)
@given(st.floats(0.018, 0.03), st.floats(0.6, 1), st.sampled_from(LAYOUTS))
def test_softness_is_about_the_blur_of_the_picture(share, gain, pix_fmt):
    """In any light, layout and depth; a little less, since sharp pictures are a little soft too."""
    lips, eyes = softness((blurred(RGB8, share) * gain).astype(np.uint8), pix_fmt=pix_fmt)
    assert 0.8 * share < lips < 1.02 * share
    assert 0.8 * share < eyes <= lips


@pytest.mark.parametrize("size", [0.5, 2.0, 3.0])
def test_softness_goes_with_the_size_of_the_picture(size):
    soft = blurred(RGB8, 0.03)
    large = cv2.resize(soft, None, fx=size, fy=size, interpolation=cv2.INTER_AREA)
    assert softness(large, POINTS * np.float32(size)) == pytest.approx(softness(soft), rel=0.15)


def test_a_mouth_that_moves_is_soft_alone():
    (_, y), high = POINTS[LIPS_OUTER, :2].mean(0).astype(int), int(0.3 * IOD)
    rgb8 = RGB8.copy()
    rgb8[y - high : y + high] = blurred(RGB8, 0.03)[y - high : y + high]
    lips, eyes = softness(rgb8)
    assert lips > 0.02 and eyes == 0


def test_without_edges_or_a_face_nothing_is_soft():
    assert softness(np.full_like(RGB8, 128)) == softness(np.zeros_like(RGB8)) == (0, 0)
    item = FrameFaces(frame_of(RGB8), (true_face(POINTS + 5000), true_face(POINTS - 5000, 1)))
    for seen in BuildScene()(item).faces:
        assert not any(seen.blur_px.values())


def sides(head):
    """The sides of all surfaces, each with the density of a product."""
    yield lips_surface(head), None
    for lid in lid_surfaces(head):
        (side, density), *_ = densities(lid, shadow("lid"))
        yield side, density


@settings(max_examples=20, deadline=None)
@given(st.integers(0, len(HEAD_PX) - 1), st.floats(0.005, 0.02), st.floats(0, 0.5))
def test_a_soft_edge_lies_where_the_sharp_one_lay(index, share, softness):
    """It is about the sharp edge, blurred: most where the edge of the product is sharp."""
    head = face(HEAD_PX[index])
    blur_px = share * iod_px(head)
    for side, density in sides(head):
        sharp, soft = (np.zeros((720, 1280), np.float32) for _ in range(2))
        side.weigh(sharp, (0, 0), Edge(softness), density)
        side.weigh(soft, (0, 0), Edge(softness, 0.0, blur_px), density)
        low, high = np.array(side.reach(Edge(softness, 0.0, blur_px), density))
        y, x = np.nonzero(soft)
        assert np.floor(low[0]) <= x.min() and x.max() <= np.ceil(high[0])
        assert np.floor(low[1]) <= y.min() and y.max() <= np.ceil(high[1])
        wanted = cv2.GaussianBlur(sharp, (0, 0), blur_px)
        assert soft.sum() == pytest.approx(sharp.sum(), rel=0.05)
        assert np.abs(soft - wanted).mean() < 0.6 * np.abs(sharp - wanted).mean()
