"""Rectangles of planes; in numpy, chroma copied to luma pixels, and its change brought back."""

import math
from typing import NamedTuple

import numpy as np


class Rect(NamedTuple):
    """A rectangle of luma pixels that begins and ends on whole blocks, or at the plane's edge.

    A block is a chroma sample and the luma pixels that it covers: `chroma` across and down.
    """

    x: int
    y: int
    width: int
    height: int

    @classmethod
    def around(
        cls,
        low_xy: tuple[float, float],
        high_xy: tuple[float, float],
        size_wh: tuple[int, int],
        chroma: tuple[int, int],
    ) -> "Rect | None":
        """Return the smallest rectangle that holds low_xy..high_xy (px); None outside the plane."""
        (width, height), (across, down) = size_wh, chroma
        (left, top), (right, bottom) = low_xy, high_xy
        x0 = max(math.floor(left), 0) // across * across
        y0 = max(math.floor(top), 0) // down * down
        x1 = min(-(-(math.ceil(right) + 1) // across) * across, width)
        y1 = min(-(-(math.ceil(bottom) + 1) // down) * down, height)
        return cls(x0, y0, x1 - x0, y1 - y0) if x1 > x0 and y1 > y0 else None

    def overlaps(self, other: "Rect") -> bool:
        return (
            self.x < other.x + other.width
            and other.x < self.x + self.width
            and self.y < other.y + other.height
            and other.y < self.y + self.height
        )

    def joined(self, other: "Rect") -> "Rect":
        """The smallest rectangle that holds both."""
        x, y = min(self.x, other.x), min(self.y, other.y)
        right = max(self.x + self.width, other.x + other.width)
        bottom = max(self.y + self.height, other.y + other.height)
        return Rect(x, y, right - x, bottom - y)

    def part(self, of: np.ndarray, rect: "Rect") -> np.ndarray:
        """View of the part that `rect` covers of this rectangle's own array.  of: (h, w)."""
        if rect is self:
            return of
        x, y = rect.x - self.x, rect.y - self.y
        return of[y : y + rect.height, x : x + rect.width]

    def luma(self, planes: tuple[np.ndarray, ...]) -> np.ndarray:
        """View of the rectangle's luma."""
        return planes[0][self.y : self.y + self.height, self.x : self.x + self.width]

    def chroma(self, planes: tuple[np.ndarray, ...], chroma: tuple[int, int]) -> list[np.ndarray]:
        """Views of the rectangle's Cb and Cr."""
        block = self.chroma_slices(chroma)
        if len(planes) == 2:  # NV12: Cb and Cr alternate
            return [planes[1][block][..., 0], planes[1][block][..., 1]]
        return [planes[1][block], planes[2][block]]

    def chroma_slices(self, chroma: tuple[int, int]) -> tuple[slice, slice]:
        """Rows and columns of the rectangle on planes of chroma."""
        across, down = chroma
        return np.s_[
            self.y // down : -(-(self.y + self.height) // down),
            self.x // across : -(-(self.x + self.width) // across),
        ]


def spread(parts: list[np.ndarray], block: tuple[int, int], hw: tuple[int, ...]) -> np.ndarray:
    """Copy Cb and Cr to the luma pixels of their blocks: (2, h, w)."""
    across, down = block
    return np.stack([part.repeat(down, 0).repeat(across, 1)[: hw[0], : hw[1]] for part in parts])


def fold(
    parts: list[np.ndarray], change: np.ndarray, block: tuple[int, int], max_code: int
) -> None:
    """Add the mean change of each block to its Cb and Cr, in place; halves go up.

    change: (2, h, w). The last block of an odd size has fewer pixels, and the mean is over these.
    """
    across, down = block
    for part, plane in zip(parts, change, strict=True):
        high, wide = part.shape
        more = high * down - plane.shape[0], wide * across - plane.shape[1]
        total, count = (
            np.pad(values, ((0, more[0]), (0, more[1])))
            .reshape(high, down, wide, across)
            .sum((1, 3))
            for values in (plane, np.ones_like(plane))
        )
        part[:] = np.clip(np.floor(part + (total / count + 0.5)), 0, max_code)
