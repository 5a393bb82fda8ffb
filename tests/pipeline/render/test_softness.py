"""How soft a picture is at a face, and makeup that is as soft as the picture."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from heads import HEAD_PX, face
from hypothesis import given, settings
from hypothesis import strategies as st
from layers import densities, job_weight, jobs, layer_weight, lipstick, shadow
from makeup import close_up, product, scene_of, true_face
from makeup_video.pipeline.faces.face import FrameFaces, iod_px, moved
from makeup_video.pipeline.faces.topology import EYE, LIPS_OUTER, RIGHT_EYE
from makeup_video.pipeline.look.look import Layer
from makeup_video.pipeline.render.build_scene import BuildScene
from makeup_video.pipeline.render.coats import scaled
from makeup_video.pipeline.render.strokes_twin import _covered
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
    """The softness of lips and of eyes, as shares of the distance of the eyes."""
    return softness_of(rgb8, true_face(points), pix_fmt)


def softness_of(rgb8, head, pix_fmt="yuv420p"):
    (seen,) = scene_of(frame_of(rgb8, pix_fmt=pix_fmt), (head,)).faces
    return seen.sigma_px["lips"] / iod_px(head), seen.sigma_px["eyes"] / iod_px(head)


def test_a_sharp_picture_is_not_soft():
    assert softness(RGB8) == (0, 0)
    assert softness(*close_up()) == (0, 0)


@settings(max_examples=25, deadline=None)
@given(st.floats(0.022, 0.03), st.floats(0.6, 1), st.sampled_from(LAYOUTS))
def test_softness_is_about_the_blur_of_the_picture(share, gain, pix_fmt):
    """In any light, layout and depth; the blur of sharp pictures is left out."""
    lips, eyes = softness((blurred(RGB8, share) * gain).astype(np.uint8), pix_fmt=pix_fmt)
    more = (share**2 - 0.016**2) ** 0.5
    assert 0.8 * more < lips < 1.2 * more
    assert 0.8 * more < eyes <= lips


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
        assert not any(seen.sigma_px.values())


@pytest.mark.parametrize("size", [0.25, 0.35, 0.5, 0.7])
def test_a_small_sharp_picture_is_hardly_soft(size):
    small = cv2.resize(RGB8, None, fx=size, fy=size, interpolation=cv2.INTER_AREA)
    assert max(softness(small, POINTS * np.float32(size))) < 0.2 / (size * IOD)


@settings(max_examples=60, deadline=None)
@given(st.integers(-60, 60), st.integers(-60, 60), st.integers(1, 40), st.booleans())
def test_any_bar_over_the_mouth_may_be_all_that_is_seen(x, y, high, is_flat):
    """Censored mouths, letterboxes: an edge may lie where the measure reads nothing but its blur."""
    rgb8 = np.full_like(RGB8, 90) if is_flat else RGB8.copy()
    left, top = POINTS[LIPS_OUTER, :2].mean(0).astype(int) + np.array([x, y])
    rgb8[max(top, 0) : top + high, max(left, 0) :] = 0
    assert np.isfinite(softness(rgb8)).all()


def test_eyes_have_their_own_softness_where_no_mouth_is_seen():
    soft = blurred(RGB8, 0.03)
    top = round(POINTS[LIPS_OUTER, 1].min() - 0.2 * IOD)
    soft[top:] = 90
    assert softness(soft)[1] == pytest.approx(softness(blurred(RGB8, 0.03))[1], rel=0.3)
    above = frame_of(blurred(RGB8, 0.03)[: (top - 2) // 2 * 2])
    (seen,) = scene_of(above, (true_face(POINTS),)).faces
    assert seen.sigma_px["eyes"] > 0.02 * IOD


@pytest.mark.parametrize("degrees", [-90, -30, -10, 15, 45, 90, 180])
def test_a_turned_head_is_as_soft(degrees):
    """The mouth alone is blurred, so what is read must turn with the face."""
    y, high = round(POINTS[LIPS_OUTER, 1].mean()), int(0.3 * IOD)
    rgb8 = RGB8.copy()
    rgb8[y - high : y + high] = blurred(RGB8, 0.03)[y - high : y + high]
    h, w = rgb8.shape[:2]
    turn = cv2.getRotationMatrix2D((w / 2, h / 2), degrees, 1)
    turn[:, 2] += (max(h, w) - np.array([w, h])) / 2
    turned = cv2.warpAffine(rgb8, turn, (max(h, w),) * 2, flags=cv2.INTER_CUBIC)
    lips, eyes = softness_of(turned, moved(true_face(POINTS), turn))
    assert lips == pytest.approx(softness(rgb8)[0], rel=0.15) and eyes == 0


def test_a_face_that_turns_away_is_as_sharp():
    """It gets narrower, but as deep as it was wide before."""
    narrow = cv2.resize(RGB8, None, fx=0.5, fy=1, interpolation=cv2.INTER_AREA)
    points = true_face(POINTS).points_px * np.float32([0.5, 1, 0])
    points[:, 2] = (points[:, 0] - points[:, 0].mean()) * 3**0.5
    head = true_face(POINTS * np.float32([0.5, 1]))
    assert softness_of(narrow, replace(head, points_px=points)) == (0, 0)


@pytest.mark.parametrize("far", [1e3, 1e6])
def test_a_face_whose_depth_is_nonsense_costs_no_memory(far):
    head = true_face(POINTS)
    points = head.points_px * np.float32([1, 1, 0])
    points[33, 2] = far
    assert np.isfinite(softness_of(RGB8, replace(head, points_px=points))).all()


@pytest.mark.parametrize("share", [0.04, 0.06, 0.08, 0.1, 0.15])
def test_what_is_far_from_sharp_is_soft(share):
    assert min(softness(blurred(RGB8, share))) > 0.012


@pytest.mark.parametrize("contrast", [1.0, 0.5, 0.3, 0.2])
def test_a_soft_face_in_haze_is_soft(contrast):
    rgb8 = 200 + contrast * (blurred(RGB8, 0.03).astype(np.float32) - 200)
    assert min(softness(np.rint(rgb8).astype(np.uint8))) > 0.012


def test_motion_up_and_down_counts_and_sideways_does_not():
    """Most borders of lips and lids run sideways, and stay sharp then."""
    long = round(0.14 * IOD) | 1
    assert softness(cv2.blur(RGB8, (1, long)))[0] > 0.005
    assert softness(cv2.blur(RGB8, (long, 1)))[0] == 0


def test_softness_sets_in_gradually():
    found = [softness(blurred(RGB8, share))[0] for share in np.linspace(0.005, 0.03, 26)]
    assert found[0] == 0 and found[-1] > 0.02
    assert np.abs(np.diff(found)).max() < 0.004


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


@pytest.mark.parametrize("size", [0.5, 1.0, 2.0, 4.0])
def test_a_hint_of_softness_changes_lips_by_a_hint(size):
    head = true_face(POINTS * np.float32(size))
    surface = lips_surface(head)
    hw = int(RGB8.shape[0] * size), int(RGB8.shape[1] * size)
    sharp, soft = (np.zeros(hw, np.float32) for _ in range(2))
    surface.weigh(sharp, (0, 0), Edge(0.0), None)
    surface.weigh(soft, (0, 0), Edge(0.0, 0.0, 0.05), None)
    assert np.abs(sharp - soft).max() < 0.01
    for least, more in (1.99, 2.01), (3.0, 3.05):  # px: there is no step further on either
        surface.weigh(sharp, (0, 0), Edge(0.0, 0.0, least), None)
        surface.weigh(soft, (0, 0), Edge(0.0, 0.0, more), None)
        assert np.abs(sharp - soft).max() < 0.08


def test_shut_eyes_have_no_bare_line_along_the_lashes():
    """Shadow above and below the lashes, on both sides at once."""
    points = HEAD_PX[0].copy()
    for eye in (EYE, RIGHT_EYE):
        points[eye[15:8:-1]] = points[eye[1:8]]  # the lids meet
    head = face(points)
    blur_px = 0.015 * iod_px(head)
    for lid, eye in zip(lid_surfaces(head), (EYE, RIGHT_EYE), strict=True):
        joined = replace(lid, is_upper=True, is_lower=True)
        weight = np.zeros((720, 1280), np.float32)
        joined.weigh(weight, (0, 0), Edge(0.5, 0.0, blur_px), None)
        x, y = points[eye[1:8], :2].round().astype(int).T
        assert weight[y, x].min() > 0.97


LINE = Layer("eyeliner", product(red=0, blue=0), {"thickness": 0.3})


@pytest.mark.parametrize("layer", [lipstick(0.0), LINE, shadow("lid")], ids=lambda one: one.kind)
def test_makeup_on_a_soft_frame_is_soft(layer):
    """If the same frame counts as sharp, the weights have steeper edges."""
    scene = scene_of(frame_of(blurred(RGB8, 0.03)), (true_face(POINTS),))
    sharp = replace(scene, faces=tuple(replace(one, sigma_px={}) for one in scene.faces))
    soft, hard = (layer_weight(one, layer) for one in (scene, sharp))
    steepest = [max(np.abs(np.diff(one, axis=0)).max(), 1e-9) for one in (soft, hard)]
    assert steepest[0] < 0.6 * steepest[1]
    assert soft.sum() == pytest.approx(hard.sum(), rel=0.15)


def test_a_soft_line_lies_within_the_painted_rectangle():
    scene = scene_of(frame_of(blurred(RGB8, 0.03)), (true_face(POINTS),))
    hw = scene.frame.height_px, scene.frame.width_px
    for job in jobs(scene, [LINE]):
        weight, rect = job_weight(job, hw), job.rect(hw[::-1], (2, 2))
        weight[rect.y : rect.y + rect.height, rect.x : rect.x + rect.width] = 0
        assert weight.max() < 1 / 512


def test_a_line_on_a_smaller_picture_is_soft_by_its_share():
    scene = scene_of(frame_of(blurred(RGB8, 0.03)), (true_face(POINTS),))
    for job in jobs(scene, [LINE]):
        half = scaled(job, np.array([[0.5, 0, 0], [0, 0.5, 0]]), 0.5)
        assert job.line().soft_px > 4
        assert half.line().soft_px == pytest.approx(0.5 * job.line().soft_px)


@given(st.floats(1, 8), st.floats(-6, 6), st.floats(0.5, 9))
def test_smudged_lines_change_smoothly_with_the_picture(soft_px, above, high):
    at = [np.float32([[one]]) for one in (above, high - above)]
    covered = [_covered(*at, soft_px * share, soft_px).item() for share in (1, 1.001, 1.999, 2.001)]
    assert abs(covered[0] - covered[1]) < 2e-3 and abs(covered[2] - covered[3]) < 2e-3
