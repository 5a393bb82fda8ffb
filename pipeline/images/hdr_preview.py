"""HDR planes -> what a browser's JPEG shows of them: brightness as it is, highlights rolled off, hues close.

Exact colours would take every pixel to linear light and back. This takes the curve of grey for luma, and chroma as many times
as strong as that curve is steep there: exact for grey, close for skin, a little pale for a deep red.
"""

from functools import lru_cache

import cv2
import numpy as np
from makeup_video.kernels.colour import (
    SRGB,
    Coding,
    from_srgb_primaries,
    matrices,
    to_encoded,
    to_linear,
)

_KNEE = 0.5  # up to half of HDR's reference white light stays as it is; white itself becomes 0.75
_JFIF = Coding(6, True)


def standard(luma: np.ndarray, chroma: list[np.ndarray], coding: Coding) -> list[np.ndarray]:
    """Planes of PQ or HLG codes -> planes of 8 bits as a JPEG has them: full-range BT.601 in sRGB."""
    bright, slope = _curve(coding)
    shown = np.take(bright, luma, mode="clip")
    if not chroma:
        return [shown]
    size = chroma[0].shape[::-1]
    steep = np.take(
        slope, np.asarray(cv2.resize(luma, size, interpolation=cv2.INTER_AREA)), mode="clip"
    )
    lift, blue, red = (
        cv2.multiply(
            cv2.addWeighted(chroma[0], of_cb, chroma[1], of_cr, added, dtype=cv2.CV_32F), steep
        )
        for of_cb, of_cr, added in _of_chroma(coding)
    )
    shown = cv2.add(shown, cv2.resize(lift, luma.shape[::-1]), dtype=cv2.CV_8U)
    colours = (cv2.addWeighted(p, 1, p, 0, 128, dtype=cv2.CV_8U) for p in (blue, red))
    return [np.asarray(plane) for plane in (shown, *colours)]


def rolled_off(light: np.ndarray) -> np.ndarray:
    """Light, 1 for HDR's reference white -> light that ends at 1, however much comes."""
    over = np.maximum(light - _KNEE, 0) / (1 - _KNEE)
    return np.where(light < _KNEE, light, _KNEE + (1 - _KNEE) * over / (1 + over))


@lru_cache(maxsize=4)
def _curve(coding: Coding) -> tuple[np.ndarray, np.ndarray]:
    """For every code of grey: its 8-bit luma, uint8; and by how much that grows with R'G'B', float32."""
    to_rgb, _ = matrices(coding)
    still = (coding.max_code + 1) // 2
    codes = np.arange(coding.max_code + 1)
    grey = np.maximum(
        codes[:, None] * to_rgb[:, 0] + to_rgb[:, 1:3].sum(1) * still + to_rgb[:, 3], 0
    )
    shown = to_encoded(rolled_off(to_linear(grey, coding.transfer)), SRGB)[:, 0]
    step = to_rgb[0, 0]
    return (shown * 255 + 0.5).astype(np.uint8), np.gradient(shown, step).astype(np.float32)


@lru_cache(maxsize=4)
def _of_chroma(coding: Coding) -> list[list[float]]:
    """What chroma adds to luma, Cb and Cr where the curve's slope is 1: of Cb, of Cr, and the rest."""
    to_rgb, _ = matrices(coding)
    _, to_codes = matrices(_JFIF)
    srgb = np.linalg.inv(from_srgb_primaries(coding.primaries))
    mix = to_codes[:, :3] @ srgb @ to_rgb[:, 1:3]
    still = (coding.max_code + 1) // 2
    rows: list[list[float]] = np.column_stack([mix, -mix.sum(1) * still]).tolist()
    return rows
