"""Detects scene cuts."""

import math

import cv2
import numpy as np
from makeup_video.pipeline.frames.sampling import halved

_GRID_WH = (32, 18)
# At least this many samples are averaged for each cell, so that grain does not look like another
# scene. They come from a few whole rows, because memory is read 64 px at a time.
_SAMPLES = 128
# Correlation of neighbouring frames. Pans and waving hands stay above 0.8, and only a face that
# leaves a plain wall comes near this limit. One in ten cuts to another scene stays above it and is
# missed.
_SAME_SCENE = 0.5
# 8-bit codes: a grid with less contrast (black, white, the end of a fade) is not compared.
_FLAT = 3.0


class CutDetector:
    """Compares each frame's luma, on a coarse grid, with the last frame that was not flat.

    The correlation does not depend on brightness and contrast, and flat frames are skipped. So
    flashes and fades are no cuts, unless another scene follows.

    begins: True when the last frame was the first one that is not flat, in the video or after flat
    frames.
    """

    def __init__(self) -> None:
        self._last: np.ndarray | None = None
        self._was_flat = True
        self.begins = False

    def __call__(self, luma: np.ndarray, bit_depth: int = 8) -> bool:
        """True when this frame begins another scene; False for the first frame.

        luma: (H, W) uint8 or uint16 plane.
        """
        coarse = cv2.resize(_few_rows(luma), _GRID_WH, interpolation=cv2.INTER_AREA)
        grid = coarse.astype(np.float64).ravel()
        grid -= grid.sum() / grid.size
        norm = math.sqrt(grid @ grid)
        is_flat = norm < _FLAT * 2 ** (bit_depth - 8) * math.sqrt(grid.size)
        self.begins, self._was_flat = self._was_flat and not is_flat, is_flat
        if is_flat:
            return False
        grid /= norm
        last, self._last = self._last, grid
        return last is not None and float(grid @ last) < _SAME_SCENE


def _few_rows(luma: np.ndarray) -> np.ndarray:
    """The rows to average: for each cell, the least power of two that gives enough samples."""
    rows, (h, w) = 1, luma.shape
    while rows * w < _SAMPLES * _GRID_WH[0] and rows * _GRID_WH[1] * 2 <= h:
        rows *= 2
    return halved(luma[:: max(h // (rows * _GRID_WH[1]), 1)], rows)
