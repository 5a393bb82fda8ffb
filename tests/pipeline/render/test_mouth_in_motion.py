"""How much of the lips, and of what lies between them, is painted while a mouth opens and closes.

The sample's points are known, so those of videos made from it are, too.
"""

from collections.abc import Callable
from functools import cache

import cv2
import numpy as np
import pytest
from laws import sample_frames, true_px
from makeup import inside
from makeup_video.pipeline.faces.face import Face
from makeup_video.pipeline.faces.topology import EYE_CORNERS, LIPS_INNER, LIPS_OUTER
from makeup_video.pipeline.faces.tracker import FindFaces
from makeup_video.pipeline.render.surfaces.lips_twin import lips_surface
from makeup_video.pipeline.render.surfaces.surface import Edge
from makeup_video.pipeline.smoothing.lookahead import SmoothAhead
from people import frame_of

FIRST, LAST = 165, 205  # the mouth opens wide and closes again
Made = tuple[np.ndarray, np.ndarray]  # a picture and its true points, px


def plain(rgb8: np.ndarray, points: np.ndarray) -> Made:
    return rgb8, points


def dim(rgb8: np.ndarray, points: np.ndarray) -> Made:
    """Light from the right, a tenth to six tenths of it."""
    light = np.linspace(0.1, 0.6, rgb8.shape[1])[None, :, None]
    return (255 * ((rgb8 / 255) ** 2.2 * light) ** (1 / 2.2)).astype(np.uint8), points


def small(rgb8: np.ndarray, points: np.ndarray) -> Made:
    """A head that tilts by 20 degrees, at half the size."""
    to_new = cv2.getRotationMatrix2D((640, 360), 20, 0.5)
    to_new[:, 2] -= 320, 180
    soft = cv2.GaussianBlur(rgb8, (0, 0), 0.7)
    return cv2.warpAffine(soft, to_new, (640, 360)), points @ to_new[:, :2].T + to_new[:, 2]


def noisy(rgb8: np.ndarray, points: np.ndarray) -> Made:
    """Warm light, and noise of sigma 5."""
    noise = np.random.default_rng(int(points.sum())).normal(0, 5, rgb8.shape)
    return (rgb8 * (1.1, 1.0, 0.8) + noise).clip(0, 255).astype(np.uint8), points


def weight_of(face: Face, hw: tuple[int, int]) -> np.ndarray:
    weight = np.zeros(hw, np.float32)
    surface = lips_surface(face)
    if surface is not None:
        surface.weigh(weight, (0, 0), Edge(0.0), None)
    return weight


@cache
def painted(make: Callable[[np.ndarray, np.ndarray], Made]) -> np.ndarray:
    """(frames, 2): the painted share of the lips and of what shows between them."""
    find, smooth, points, items = FindFaces(), SmoothAhead(), {}, []
    for frame in sample_frames(FIRST, LAST):
        rgb8, points[frame.pts] = make(frame.picture.to_ndarray(format="rgb24"), true_px(frame.pts))
        items.append(smooth(find(frame_of(rgb8, frame.pts))))
    shares = []
    for item in (*items, *smooth.drain()):
        if item is None:
            continue
        (face,), true = item.faces, points[item.frame.pts]
        weight = weight_of(face, (item.frame.picture.height, item.frame.picture.width))
        iod = float(np.linalg.norm(np.subtract(*true[list(EYE_CORNERS)])))
        within = inside(true[LIPS_INNER], weight.shape, 0.01 * iod)
        lips = inside(true[LIPS_OUTER], weight.shape, 1) & ~inside(
            true[LIPS_INNER], weight.shape, -1
        )
        between = (weight[within] > 0.5).mean() if within.sum() > 30 else 0
        shares.append((weight[lips].mean(), between))
    return np.array(shares)


# Painted shares: of the lips at least on average; of what lies between them at most on average, and
# at most in a frame. The mouth gapes, and the skin below the lower lip is as red as the lip.
BOUNDS = {
    plain: (0.69, 0.03, 0.09),
    dim: (0.62, 0.09, 0.2),
    small: (0.69, 0.05, 0.16),
    noisy: (0.63, 0.07, 0.18),
}


@pytest.mark.parametrize("make", BOUNDS)
def test_lips_are_painted_and_teeth_are_not_in_motion(make):
    lips, between = painted(make).T
    least, usual, most = BOUNDS[make]
    assert len(lips) == LAST - FIRST + 1
    assert lips.mean() > least
    assert between.mean() < usual
    assert between.max() < most


@pytest.mark.parametrize("make", BOUNDS)
def test_lips_are_painted_alike_from_frame_to_frame(make):
    lips = painted(make)[:, 0]
    assert np.abs(np.diff(lips)).max() < 0.2
