"""Converts HDR planes for a JPEG: brightness is kept, highlights are rolled off, hues are close.

Exact colours would need linear light for every pixel. Instead luma follows the tone curve of grey,
and chroma is multiplied by the slope of that curve. The result is exact for grey, close for skin,
and a little pale for deep reds.
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

_KNEE = 0.5  # light up to half of HDR's reference white stays unchanged; white itself becomes 0.75
JFIF = Coding(6, True)


def standard(luma: np.ndarray, chroma: list[np.ndarray], coding: Coding) -> list[np.ndarray]:
    """Convert planes of PQ or HLG codes to a JPEG's: 8 bits, full-range BT.601, sRGB."""
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
    """Compress light (1 is HDR's reference white) so that it stays below 1."""
    over = np.maximum(light - _KNEE, 0) / (1 - _KNEE)
    return np.where(light < _KNEE, light, _KNEE + (1 - _KNEE) * over / (1 + over))


@lru_cache(maxsize=4)
def _curve(coding: Coding) -> tuple[np.ndarray, np.ndarray]:
    """For each code of grey: 8-bit luma, uint8, and the curve's slope over R'G'B', float32."""
    to_rgb, _ = matrices(coding)
    neutral = (coding.max_code + 1) // 2
    codes = np.arange(coding.max_code + 1)
    grey = np.maximum(
        codes[:, None] * to_rgb[:, 0] + to_rgb[:, 1:3].sum(1) * neutral + to_rgb[:, 3], 0
    )
    shown = to_encoded(rolled_off(to_linear(grey, coding.transfer)), SRGB)[:, 0]
    step = to_rgb[0, 0]
    return (shown * 255 + 0.5).astype(np.uint8), np.gradient(shown, step).astype(np.float32)


@lru_cache(maxsize=4)
def _of_chroma(coding: Coding) -> list[list[float]]:
    """How chroma changes luma, Cb and Cr at slope 1: three rows (factor of Cb, of Cr, constant)."""
    to_rgb, _ = matrices(coding)
    _, to_codes = matrices(JFIF)
    srgb = np.linalg.inv(from_srgb_primaries(coding.primaries))
    mix = to_codes[:, :3] @ srgb @ to_rgb[:, 1:3]
    neutral = (coding.max_code + 1) // 2
    rows: list[list[float]] = np.column_stack([mix, -mix.sum(1) * neutral]).tolist()
    return rows
