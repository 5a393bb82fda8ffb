"""Affine maps of the plane: (x, y) -> (a x + b y + shift_x, c x + d y + shift_y).

`Affine` is one map as six plain numbers, which are quicker than numpy for a single map.
`AffineArray` is what OpenCV takes.
"""

from typing import NamedTuple

import numpy as np

AffineArray = np.ndarray  # (2, 3) float64: (x, y, 1) -> (x, y)


class Affine(NamedTuple):
    """One map as plain numbers, row by row."""

    a: float
    b: float
    shift_x: float
    c: float
    d: float
    shift_y: float

    @classmethod
    def from_array(cls, array: AffineArray) -> "Affine":
        """The map of a (2, 3) array."""
        (a, b, shift_x), (c, d, shift_y) = array.tolist()
        return cls(a, b, shift_x, c, d, shift_y)

    def array(self) -> AffineArray:
        """(2, 3) float64, for OpenCV."""
        return np.array((self[:3], self[3:]))

    @property
    def area(self) -> float:
        """The signed area of the unit square after the map; 0 when the map has no inverse."""
        return self.a * self.d - self.b * self.c

    def after(self, first: "Affine") -> "Affine":
        """The map that does `first`, then this one."""
        a, b, x, c, d, y = self
        e, f, u, g, h, v = first
        return Affine(
            a * e + b * g, a * f + b * h, a * u + b * v + x,
            c * e + d * g, c * f + d * h, c * u + d * v + y,
        )  # fmt: skip

    def inverse(self) -> "Affine":
        """The map back. For a map without an inverse, the map of every point to the origin."""
        area = self.area
        if area == 0:
            return Affine(0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
        a, b, x, c, d, y = self
        return Affine(
            d / area, -b / area, (b * y - d * x) / area,
            -c / area, a / area, (c * x - a * y) / area,
        )  # fmt: skip

    def solve(self, x: float, y: float) -> tuple[float, float]:
        """The point that the map leads to (x, y); the map must have an inverse."""
        area, x, y = self.area, x - self.shift_x, y - self.shift_y
        return (self.d * x - self.b * y) / area, (self.a * y - self.c * x) / area


AS_STORED: AffineArray = np.eye(2, 3)  # for a picture stored upright: always this object


def compose(second: AffineArray, first: AffineArray) -> AffineArray:
    """The map that does `first`, then `second`; `first` may be several maps, (..., 2, 3)."""
    both: AffineArray = second[:, :2] @ first
    both[..., 2] += second[:, 2]
    return both


def invert(array: AffineArray) -> AffineArray:
    """(2, 3) float64, the map back. For a map without an inverse, all zeros."""
    import cv2  # late: runs that only copy a video load this module, and not OpenCV

    back: AffineArray = cv2.invertAffineTransform(array)
    return back
