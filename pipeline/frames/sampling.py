"""Reads samples from planes: crops under any affine map, and single points.

Only the pixels under a crop are read. A crop may be turned, and may reach beyond the plane, where
the border is repeated.
"""

from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

import cv2
import numpy as np
from makeup_video.pipeline.frames.affine import Affine, AffineArray
from makeup_video.pipeline.frames.frame import Frame


@lru_cache
def pixel_places(size_wh: tuple[int, int]) -> np.ndarray:
    """(3, H*W) float32: x, y, 1 of every pixel of a crop, row by row."""
    w, h = size_wh
    y, x = np.divmod(np.arange(w * h, dtype=np.float32), w)
    return np.stack([x, y, np.ones_like(x)])


def sample(plane: np.ndarray, to_px: AffineArray, size_wh: tuple[int, int]) -> np.ndarray:
    """A crop of a plane (H, W) or (H, W, C), by bilinear samples.

    Where the crop shrinks the plane, averages of 2x2, 4x4, ... px are sampled.
    to_px: (2, 3), crop px -> plane px. Beyond the plane the border is repeated.
    """
    factor = shrink_factor(step_px(to_px))
    if factor > 1:
        box = part_around(reach_of([to_px.tolist()], [size_wh]), plane, factor)
        plane, to_part = shrunk(plane, box, factor)
        to_px = to_part.after(Affine.from_array(to_px)).array()
    return warp(plane, to_px, size_wh)


def warp(plane: np.ndarray, to_px: AffineArray, size_wh: tuple[int, int]) -> np.ndarray:
    """Bilinear samples of a plane under a map crop px -> plane px; the border is repeated."""
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    return cv2.warpAffine(plane, to_px, size_wh, flags=flags, borderMode=cv2.BORDER_REPLICATE)


def remap(plane: np.ndarray, places: np.ndarray) -> np.ndarray:
    """Bilinear samples of a plane at points (2, N) float32, x and y; the border is repeated."""
    return cv2.remap(
        plane, places[:1], places[1:], cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE
    )


def reach_of(
    maps: list[list[list[float]]], sizes: Sequence[tuple[int, int]]
) -> list[tuple[float, float]]:
    """What all pixels of these crops cover of the plane: (lowest, highest) of x, and of y.

    maps: one map per crop, crop px -> plane px, as nested lists (2, 3).
    """
    reach = []
    for axis in (0, 1):
        lows, highs = [], []
        for to_px, (w, h) in zip(maps, sizes, strict=True):
            across, down, start = to_px[axis]
            right, below = across * (w - 1), down * (h - 1)
            lows.append(start + min(right, 0.0) + min(below, 0.0))
            highs.append(start + max(right, 0.0) + max(below, 0.0))
        reach.append((min(lows), max(highs)))
    return reach


def step_px(to_px: AffineArray) -> float:
    """How many px of the plane lie between neighbouring pixels of a crop."""
    return step_of(to_px.tolist())


def step_of(to_px: list[list[float]]) -> float:
    """The same as `step_px`, for a map as nested lists (2, 3)."""
    (a, b, _), (c, d, _) = to_px
    return float(abs(a * d - b * c) ** 0.5)


def shrink_factor(step: float) -> int:
    """The least power of two by which to shrink a plane, to leave at most 2 px between samples."""
    factor = 1
    while step > 2 * factor:
        factor *= 2
    return factor


class _Box(NamedTuple):
    """A part of a plane in px: low is inside, high is not."""

    low_x: int
    low_y: int
    high_x: int
    high_y: int

    def for_chroma(self, across: int, down: int) -> "_Box":
        """The same part of a chroma plane; low must be a multiple of both factors."""
        low_x, low_y, high_x, high_y = self
        return _Box(low_x // across, low_y // down, -(-high_x // across), -(-high_y // down))


def part_around(reach: list[tuple[float, float]], plane: np.ndarray, multiple: int) -> _Box:
    """The part of a plane within `reach`, see reach_of, and a little around it.

    Its edges lie at multiples of `multiple`, so that averages do not change when a crop moves.
    """
    low, high = [], []
    for (first, last), length in zip(reach, plane.shape[1::-1], strict=True):
        low.append(min(max(int(first) - 2 * multiple, 0), length - 1) // multiple * multiple)
        needed = max(int(last) + 2 * multiple + 2, low[-1] + 1) - low[-1]
        available = max((length - low[-1]) // multiple * multiple, 1)
        high.append(low[-1] + min(-(-needed // multiple) * multiple, available))
    return _Box(*low, *high)


def shrunk(plane: np.ndarray, box: _Box, factor: int) -> tuple[np.ndarray, Affine]:
    """A part of a plane, averaged `factor` to 1, and the map plane px -> part px.

    For a factor above 2 only every second row is read, because memory is slow.
    """
    left, top, right, bottom = box
    wide, tall, skip = right - left, bottom - top, 2 if factor > 2 else 1
    size = max(1, wide // factor), max(1, tall // factor)
    part = halved(plane[top:bottom:skip, left:right], factor // skip)
    if part.shape[1::-1] != size:
        part = cv2.resize(part, size)
    x_scale, y_scale = size[0] / wide, size[1] / tall
    first = top + (1 - skip) / 2  # the rows that are read lie above the skipped ones
    shift_x, shift_y = (0.5 - left) * x_scale - 0.5, (0.5 - first) * y_scale - 0.5
    return part, Affine(x_scale, 0.0, shift_x, 0.0, y_scale, shift_y)


def halved(plane: np.ndarray, factor: int = 2) -> np.ndarray:
    """A plane (H, W) or (H, W, C), averaged 2x2 until it is smaller by `factor`, a power of two.

    The last row or column of an odd number is left out. OpenCV is quick at exactly 2x2: averaging
    4x4 at once takes six times as long as 2x2 twice.
    """
    while factor > 1:
        h, w = plane.shape[:2]
        if (h | w) & 1:
            plane = plane[: max(1, h & ~1), : max(1, w & ~1)]
        size = w // 2 or 1, h // 2 or 1
        plane, factor = cv2.resize(plane, size, interpolation=cv2.INTER_AREA), factor // 2
    return plane


def eight_bits(plane: np.ndarray, frame: Frame) -> np.ndarray:
    """Codes of a frame, scaled to 8 bits."""
    if plane.dtype == np.uint8:
        return plane
    return cv2.convertScaleAbs(plane, alpha=2.0 ** (8 - frame.bit_depth))
