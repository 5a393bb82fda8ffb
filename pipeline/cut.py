"""Is this frame the first of another scene?"""

import cv2
import numpy as np

# Samples of each cell are averaged, so that grain does not look like another scene.
_COARSE_WH, _GRID_WH = (320, 180), (32, 18)
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
        coarse = cv2.resize(luma, _COARSE_WH, interpolation=cv2.INTER_NEAREST)
        grid = cv2.resize(coarse, _GRID_WH, interpolation=cv2.INTER_AREA).astype(np.float32)
        grid -= grid.mean()
        deviation = float(np.sqrt((grid * grid).mean()))
        if deviation < _FLAT * 2 ** (bit_depth - 8):
            return False
        grid /= deviation
        last, self._last = self._last, grid
        return last is not None and float((grid * last).mean()) < _ALIKE
