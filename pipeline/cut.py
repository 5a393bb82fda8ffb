"""Is this frame the first of another scene?"""

import cv2
import numpy as np

_COARSE_WH, _GRID_WH = (96, 54), (32, 18)
_ALIKE = 0.5  # correlation of neighbours: pans and waving stay above 0.8, unlike scenes below 0.4
_FLAT = 3.0  # code values of 8 bits: a grid this even (black, white, a fade's end) tells nothing


class CutDetector:
    """Compares each frame's luma, on a coarse grid, with the frame's before.

    The correlation does not change with brightness and contrast, so that flashes and fades are no
    cuts.
    """

    def __init__(self) -> None:
        self._last: np.ndarray | None = None

    def __call__(self, luma: np.ndarray) -> bool:
        """luma: (H, W) uint8 or uint16 plane. False for the first frame."""
        coarse = cv2.resize(luma, _COARSE_WH, interpolation=cv2.INTER_NEAREST)
        grid = cv2.resize(coarse, _GRID_WH, interpolation=cv2.INTER_AREA).astype(np.float32)
        last, self._last = self._last, grid
        if last is None:
            return False
        flat = _FLAT if luma.dtype == np.uint8 else _FLAT * 4
        a, b = grid - grid.mean(), last - last.mean()
        spread_a, spread_b = a.std(), b.std()
        if spread_a < flat or spread_b < flat:
            # into or out of an even picture: a cut only if the other one is not even
            return bool(max(spread_a, spread_b) > 4 * flat)
        return bool((a * b).mean() / (spread_a * spread_b) < _ALIKE)
