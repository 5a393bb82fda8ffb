"""Is this frame the first of another scene?"""

import math

import cv2
import numpy as np
from makeup_video.pipeline.crop import halved

_GRID_WH = (32, 18)
# Read of each cell, and averaged with all their columns, so that grain does not look like another
# scene: whole rows, because memory is read by 64 px at least.
_ROWS = 4
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
        rows = luma[:: max(len(luma) // (_ROWS * _GRID_WH[1]), 1)]
        coarse = cv2.resize(halved(halved(rows)), _GRID_WH, interpolation=cv2.INTER_AREA)
        grid = coarse.astype(np.float64).ravel()
        grid -= grid.sum() / grid.size
        norm = math.sqrt(grid @ grid)
        if norm < _FLAT * 2 ** (bit_depth - 8) * math.sqrt(grid.size):
            return False
        grid /= norm
        last, self._last = self._last, grid
        return last is not None and float(grid @ last) < _ALIKE
