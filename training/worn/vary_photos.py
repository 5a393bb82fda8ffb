"""Varies close crops as other photos would show them, for the nets that read a form of makeup."""

import math

import cv2
import numpy as np
from makeup_video.training.faces.augment import jpeg


def moved(rgb8: np.ndarray, about: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """The picture turned, scaled and shifted about a place, (2,) px, as errors of landmarks would.

    rgb8: (H, W, 3) uint8, R'G'B'.
    """
    turn, scale = rng.normal(0, 0.07), math.exp(rng.normal(0, 0.05))
    linear = scale * np.array([[math.cos(turn), math.sin(turn)], [-math.sin(turn), math.cos(turn)]])
    shift = about - linear @ about + rng.normal(0, 1.6, 2)
    to_px = np.column_stack([linear, shift])
    return cv2.warpAffine(rgb8, to_px, rgb8.shape[1::-1], borderMode=cv2.BORDER_REPLICATE)


def photographed(
    rgb8: np.ndarray,
    rng: np.random.Generator,
    coarsest: float = 0.3,
    contrast: tuple[float, float] = (0.7, 1.4),
) -> np.ndarray:
    """The picture blurred, compressed, in other light, and noisy.

    rgb8: (H, W, 3) uint8, R'G'B'.  coarsest: the share of its width to which the picture may be
    scaled down.  contrast: the range of factors by which contrast changes.
    """
    if rng.random() < 0.5:
        factor = rng.uniform(coarsest, 0.9)
        small = cv2.resize(rgb8, None, fx=factor, fy=factor, interpolation=cv2.INTER_AREA)
        rgb8 = cv2.resize(small, rgb8.shape[1::-1], interpolation=cv2.INTER_LINEAR)
    if rng.random() < 0.4:
        rgb8 = jpeg(rgb8, int(rng.integers(25, 90)))
    x = (rgb8.astype(np.float32) / 255) ** math.exp(rng.normal(0, 0.3))
    x *= np.exp(rng.normal(0, 0.12, 3) + rng.normal(0, 0.15))
    x = x.mean() + (x - x.mean()) * rng.uniform(*contrast)
    x += rng.normal(0, rng.uniform(0, 0.03), x.shape)
    coded: np.ndarray = np.rint(255 * x.clip(0, 1)).astype(np.uint8)
    return coded


def heights(line: np.ndarray, x: np.ndarray | float) -> np.ndarray:
    """y of a line through points, (N, 2) px, at each x."""
    points = line[np.argsort(line[:, 0])]
    return np.asarray(np.interp(x, points[:, 0], points[:, 1]))
