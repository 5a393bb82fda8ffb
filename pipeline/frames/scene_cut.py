"""Is this frame the first of another scene?"""

import math

import cv2
import numpy as np
from makeup_video.pipeline.frames.sampling import halved

_GRID_WH = (32, 18)
# So many samples of each cell are averaged at least, so that grain does not look like another scene:
# of few whole rows, because memory is read by 64 px at a time.
_SAMPLES = 128
_ALIKE = 0.5  # correlation of neighbours: pans and waving stay above 0.8, unlike scenes below 0.4
_FLAT = 3.0  # codes of 8 bits: a grid this even (black, white, a fade's end) tells nothing


class CutDetector:
    """Compares each frame's luma, on a coarse grid, with the last frame that showed something.

    The correlation does not change with brightness and contrast, and even frames are passed over:
    so flashes and fades are no cuts, unless another scene follows.
    """

    def __init__(self) -> None:
        self._last: np.ndarray | None = None

    def __call__(self, luma: np.ndarray, bit_depth: int = 8) -> bool:
        """luma: (H, W) uint8 or uint16 plane. False for the first frame."""
        coarse = cv2.resize(_few_rows(luma), _GRID_WH, interpolation=cv2.INTER_AREA)
        grid = coarse.astype(np.float64).ravel()
        grid -= grid.sum() / grid.size
        norm = math.sqrt(grid @ grid)
        if norm < _FLAT * 2 ** (bit_depth - 8) * math.sqrt(grid.size):
            return False
        grid /= norm
        last, self._last = self._last, grid
        return last is not None and float(grid @ last) < _ALIKE


def _few_rows(luma: np.ndarray) -> np.ndarray:
    """What the grid is averaged from: as few rows a cell, a power of two, as hold enough samples."""
    rows, (h, w) = 1, luma.shape
    while rows * w < _SAMPLES * _GRID_WH[0] and rows * _GRID_WH[1] * 2 <= h:
        rows *= 2
    return halved(luma[:: max(h // (rows * _GRID_WH[1]), 1)], rows)
