"""The weight of lipstick at every pixel of a picture."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from makeup_video.pipeline import find_faces, lip_mask
from makeup_video.pipeline.faces.lip_mask import lip_mask_part
from makeup_video.pipeline.faces.topology import LIPS, LIPS_INNER, LIPS_OUTER
from people import clip, clip_points, portrait


def polygon(points: np.ndarray, contour: np.ndarray, shape: tuple[int, int]) -> np.ndarray:
    inside = np.zeros(shape, np.uint8)
    cv2.fillPoly(inside, [np.rint(points[contour] * 16).astype(np.int32)], 1, shift=4)
    return inside.astype(bool)


def open_mouth() -> int:
    points = clip_points(300)
    gap = np.linalg.norm(points[:, 13] - points[:, 14], axis=1)
    return int(gap[:40].argmax())


@pytest.mark.parametrize("index", [0, open_mouth()])
def test_the_mask_covers_the_lips_and_little_else(index):
    picture, true = clip()[index], clip_points()[index]
    mask = lip_mask(picture, find_faces(picture)[0])
    assert mask.shape == picture.shape[:2]
    assert mask.dtype == np.float32
    assert mask.min() >= 0
    assert mask.max() <= 1
    lips = polygon(true, LIPS_OUTER, mask.shape) & ~polygon(true, LIPS_INNER, mask.shape)
    painted = mask > 0.5
    assert (painted & lips).sum() / (painted | lips).sum() > 0.6
    away = np.abs(np.mgrid[0:360, 0:640] - true[LIPS].mean(0)[::-1, None, None]).max(0) > 70
    assert mask[away].max() == 0


def test_a_part_of_the_mask_is_that_part_of_the_whole():
    (face,) = find_faces(portrait())
    whole = lip_mask(portrait(), face)
    x, y = face.points_px[LIPS, :2].mean(0).astype(int) - 40
    part = lip_mask_part(face, (int(x), int(y)), (90, 70))
    assert part == pytest.approx(whole[y : y + 70, x : x + 90], abs=2e-3)


@pytest.mark.parametrize("odds", [-3.0, -8.0, 5.0])
def test_the_border_of_the_patch_has_no_line(odds):
    (face,) = find_faces(portrait())
    even = replace(face, lips=replace(face.lips, logits=np.full((80, 112), odds, np.float32)))
    assert lip_mask(portrait(), even).max() <= 1 / (1 + np.exp(-odds)) + 1e-6


def test_the_mask_fades_with_a_mouth_that_is_hidden():
    (face,) = find_faces(portrait())
    full = lip_mask(portrait(), face)
    assert lip_mask(portrait(), replace(face, mouth_visible=0.1)).max() == 0
    half = lip_mask(portrait(), replace(face, mouth_visible=0.6))
    assert half.max() == pytest.approx(full.max() / 2, rel=0.01)


def test_a_mouth_behind_a_medical_mask_is_hidden():
    picture = portrait().copy()
    (face,) = find_faces(picture)
    nose, chin = face.points_px[1, :2], face.points_px[152, :2]
    left, right = face.points_px[234, :2], face.points_px[454, :2]
    cloth = np.array([[left[0] + 8, nose[1]], nose - [0, 12], [right[0] - 8, nose[1]],
                      [right[0] - 25, chin[1]], np.add(chin, (0, 8)), [left[0] + 25, chin[1]]])  # fmt: skip
    cv2.fillPoly(picture, [np.rint(cloth).astype(np.int32)], (150, 190, 215))
    (face,) = find_faces(picture)
    assert face.mouth_weight == 0


def test_lips_outside_the_picture_have_no_mask():
    (face,) = find_faces(portrait())
    assert lip_mask(portrait()[:120], face).max() == 0


@pytest.mark.filterwarnings("error")
def test_a_face_of_odd_numbers_has_no_mask():
    (face,) = find_faces(portrait())
    lips = replace(face.lips, to_px=np.full_like(face.lips.to_px, np.nan))
    assert lip_mask(portrait(), replace(face, lips=lips)).max() == 0
