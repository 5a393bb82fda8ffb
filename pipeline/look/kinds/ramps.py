"""Smooth borders of a kind's shape.

numpy is imported where it is used: help pages read the kinds, too, and need not wait for it.
"""

from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import numpy as np

_THINNEST = 1e-3  # width of a border, so that none is a division by zero


def smooth(share: "np.ndarray") -> "np.ndarray":
    """0 below 0, 1 above 1, and a smooth rise between (3t^2 - 2t^3); float32."""
    import numpy as np

    t: np.ndarray = np.clip(share, 0, 1, dtype=np.float32)
    return t * t * (3 - 2 * t)


def rise(at: "np.ndarray", middle: float, width: float) -> "np.ndarray":
    """A smooth rise from 0 to 1 around a place, over a width."""
    import numpy as np

    width = max(width, _THINNEST)
    return smooth((at - (middle - width / 2)) * np.float32(1 / width))


def fall(at: "np.ndarray", middle: float, width: float) -> "np.ndarray":
    """A smooth fall from 1 to 0 around a place, over a width."""
    return rise(-at, -middle, width)


def from_segment(
    x: "np.ndarray", y: "np.ndarray", a: tuple[float, float], b: tuple[float, float]
) -> "np.ndarray":
    """Distance of places from the line between two points."""
    import numpy as np

    right, down = b[0] - a[0], b[1] - a[1]
    length2 = max(right * right + down * down, 1e-12)
    along = np.clip(((x - a[0]) * right + (y - a[1]) * down) * (1 / length2), 0, 1)
    return np.hypot(x - a[0] - along * right, y - a[1] - along * down)
