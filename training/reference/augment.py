"""Varies pictures as photos differ: in the light on the face, and in the camera."""

import cv2
import numpy as np
from makeup_video.training.faces.augment import grain, jpeg, light, motion_blur

_DISPLAY = 1 / 2.2  # encoded values are about this power of light


def lighting(rng: np.random.Generator, size_wh: tuple[int, int]) -> np.ndarray:
    """(H, W, 3) float32 gain of encoded values: exposure, white balance, light from a side."""
    exposure = 2 ** (rng.normal(-0.25, 0.5) * _DISPLAY)  # portraits are bright already
    warm, green = rng.normal(0, 0.3) * _DISPLAY, rng.normal(0, 0.06) * _DISPLAY
    balance = np.exp([warm / 2, green, -warm / 2]) * exposure
    gain = np.empty((*size_wh[::-1], 3), np.float32)
    gain[:] = balance
    if rng.random() < 0.5:
        gain *= light(rng, *size_wh) ** np.float32(rng.uniform(0.1, 0.6) * _DISPLAY)
    return gain


def camera(rgb8: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """The picture as some camera, phone or web page would give it. (H, W, 3) uint8 in and out.

    Colours hardly change: the product reads a camera's tint from the skin as light, and divides it
    out.
    """
    h, w = rgb8.shape[:2]
    kind = rng.random()
    if kind < 0.3:  # a smaller original
        part = rng.uniform(0.45, 0.9)
        small = cv2.resize(rgb8, (round(w * part), round(h * part)), interpolation=cv2.INTER_AREA)
        rgb8 = cv2.resize(small, (w, h), interpolation=cv2.INTER_LINEAR)
    elif kind < 0.42:
        rgb8 = cv2.GaussianBlur(rgb8, (0, 0), rng.uniform(0.4, 1.3))
    elif kind < 0.46:
        rgb8 = motion_blur(rgb8, rng)
    elif kind < 0.62:  # sharpened
        gain = rng.uniform(0.2, 0.9)
        rgb8 = cv2.addWeighted(rgb8, 1 + gain, cv2.GaussianBlur(rgb8, (0, 0), 1.2), -gain, 0)
    if rng.random() < 0.5:
        picture = rgb8 + grain(rgb8.shape, rng, rng.random() < 0.4) * np.float32(
            abs(rng.normal(0, 4))
        )
        rgb8 = picture.clip(0, 255).astype(np.uint8)
    if rng.random() < 0.6:
        rgb8 = cv2.LUT(rgb8, _tone(rng))
    return jpeg(rgb8, int(rng.uniform(55, 98))) if rng.random() < 0.8 else rgb8


def _tone(rng: np.random.Generator) -> np.ndarray:
    """(1, 256, 3) uint8 table: slightly more or less contrast, and a tint."""
    x = np.linspace(0, 1, 256)
    x = x + rng.normal(0, 0.08) * (x * x * (3 - 2 * x) - x)
    curve = 255 * x[:, None] * np.exp(rng.normal(0, 0.015, 3))
    return np.rint(curve.clip(0, 255)).astype(np.uint8)[None]
