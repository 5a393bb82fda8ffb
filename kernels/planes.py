"""The chroma of a region as every luma pixel sees it, and its change brought back to the planes."""

from dataclasses import dataclass

import cv2
import numpy as np


@dataclass(frozen=True, slots=True)
class Window:
    """A rectangle of luma pixels that begins and, but for the plane's edge, ends on whole blocks.

    A block is a chroma sample and the luma pixels that it covers: `chroma` across and down.
    """

    x: int
    y: int
    width: int
    height: int

    @classmethod
    def around(
        cls,
        low_xy: np.ndarray,
        high_xy: np.ndarray,
        size_wh: tuple[int, int],
        chroma: tuple[int, int],
    ) -> "Window | None":
        """The smallest window of a plane that holds low_xy..high_xy (px); None when all is outside."""
        (width, height), (across, down) = size_wh, chroma
        x0 = max(int(np.floor(low_xy[0])), 0) // across * across
        y0 = max(int(np.floor(low_xy[1])), 0) // down * down
        x1 = min(-(-(int(np.ceil(high_xy[0])) + 1) // across) * across, width)
        y1 = min(-(-(int(np.ceil(high_xy[1])) + 1) // down) * down, height)
        return cls(x0, y0, x1 - x0, y1 - y0) if x1 > x0 and y1 > y0 else None

    def luma(self, planes: tuple[np.ndarray, ...]) -> np.ndarray:
        return planes[0][self.y : self.y + self.height, self.x : self.x + self.width]

    def chroma(self, planes: tuple[np.ndarray, ...], chroma: tuple[int, int]) -> list[np.ndarray]:
        """Views of Cb and Cr."""
        across, down = chroma
        at = np.s_[
            self.y // down : -(-(self.y + self.height) // down),
            self.x // across : -(-(self.x + self.width) // across),
        ]
        if len(planes) == 2:  # NV12: Cb and Cr take turns
            return [planes[1][at][..., 0], planes[1][at][..., 1]]
        return [planes[1][at], planes[2][at]]


def spread(
    parts: list[np.ndarray], chroma: tuple[int, int], size_wh: tuple[int, int]
) -> np.ndarray:
    """Cb and Cr -> (2, h, w) float32, the codes of each luma pixel: those of its block."""
    width, height = size_wh
    out = np.empty((2, height, width), np.float32)
    across, down = chroma
    for plane, part in zip(out, parts, strict=True):
        if chroma == (1, 1):
            plane[:] = part
            continue
        high, wide = part.shape
        # NEAREST by whole factors repeats; an odd size has less of its last block
        whole = cv2.resize(
            part.astype(np.float32), (wide * across, high * down),
            plane if plane.shape == (high * down, wide * across) else None,
            interpolation=cv2.INTER_NEAREST,
        )  # fmt: skip
        if whole.shape != plane.shape:
            plane[:] = whole[:height, :width]
    return out


def fold(
    parts: list[np.ndarray], change: np.ndarray, chroma: tuple[int, int], max_code: int
) -> None:
    """Add the mean change of each block to its Cb and Cr, in place; halves go up."""
    across, down = chroma
    for part, plane in zip(parts, change, strict=True):
        high, wide = part.shape
        if plane.shape != (high * down, wide * across):  # the last block of an odd size
            more = high * down - plane.shape[0], wide * across - plane.shape[1]
            plane = np.pad(plane, ((0, more[0]), (0, more[1])), mode="edge")
        mean = (
            plane
            if chroma == (1, 1)
            else cv2.resize(plane, (wide, high), interpolation=cv2.INTER_AREA)
        )
        part[:] = np.clip(np.floor(part + (mean + 0.5)), 0, max_code)
