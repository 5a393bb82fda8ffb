"""Small upright RGB crops straight from a frame's planes: what the face nets look at.

Only the window's own pixels are read. It may be turned, and may reach beyond the picture, where
the border is repeated.
"""

from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple

import cv2
import numpy as np
from makeup_video.pipeline.frames.colour_tags import FULL_RANGE
from makeup_video.pipeline.frames.frame import Frame

Affine = np.ndarray  # (2, 3) float64: (x, y, 1) -> (x, y)


def samples_at(frame: Frame, places: np.ndarray, step: float) -> list[np.ndarray]:
    """Y', Cb and Cr of a frame as it is stored, each (1, N) codes; of a grey frame Y' alone.

    places, step: as for sample_at, in luma pixels.
    """
    rows = [sample_at(frame.planes[0], places, step)]
    to_chroma = _to_chroma(*frame.chroma)
    scale = to_chroma.diagonal().astype(np.float32)
    places = places * scale[:, None] + to_chroma[:, 2:].astype(np.float32)
    for plane in frame.planes[1:3]:
        sampled = sample_at(plane, places, step * float(scale.prod() ** 0.5))
        rows += [sampled] if sampled.ndim == 2 else cv2.split(sampled)  # NV12: both in one
    return rows


@lru_cache
def _to_chroma(across: int, down: int) -> Affine:
    """Luma px -> chroma px, for chroma sited in the middle of its luma."""
    return np.array([[1 / across, 0, 0.5 / across - 0.5], [0, 1 / down, 0.5 / down - 0.5]])


@lru_cache
def pixel_places(size_wh: tuple[int, int]) -> np.ndarray:
    """(3, H*W) float32: x, y, 1 of every pixel of a crop, row by row."""
    w, h = size_wh
    y, x = np.divmod(np.arange(w * h, dtype=np.float32), w)
    return np.stack([x, y, np.ones_like(x)])


def sample(plane: np.ndarray, to_px: Affine, size_wh: tuple[int, int]) -> np.ndarray:
    """Bilinear samples of (H, W) or (H, W, C); where the crop shrinks, averages of 2x2, 4x4, ...

    to_px maps the crop's pixels to the plane's; the border is repeated beyond it.
    """
    factor = shrink_factor(step_px(to_px))
    if factor > 1:
        box = part_around(reach_of([to_px.tolist()], [size_wh]), plane, factor)
        plane, to_part = shrunk(plane, box, factor)
        to_px = compose(to_part, to_px)
    return warp(plane, to_px, size_wh)


def sample_at(plane: np.ndarray, places: np.ndarray, step: float) -> np.ndarray:
    """The same at any places (2, N) float32, x and y, of which neighbours are `step` px apart.

    Returns (1, N) or (1, N, C).
    """
    factor = shrink_factor(step)
    if factor > 1:
        reach = list(zip(places.min(1).tolist(), places.max(1).tolist(), strict=True))
        plane, to_part = shrunk(plane, part_around(reach, plane, factor), factor, every_row=True)
        scale = to_part.diagonal().astype(np.float32)[:, None]
        places = places * scale + to_part[:, 2:].astype(np.float32)
    return remap(plane, places)


def warp(plane: np.ndarray, to_px: Affine, size_wh: tuple[int, int]) -> np.ndarray:
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    return cv2.warpAffine(plane, to_px, size_wh, flags=flags, borderMode=cv2.BORDER_REPLICATE)


def remap(plane: np.ndarray, places: np.ndarray) -> np.ndarray:
    return cv2.remap(
        plane, places[:1], places[1:], cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE
    )


def reach_of(
    maps: list[list[list[float]]], sizes: Sequence[tuple[int, int]]
) -> list[tuple[float, float]]:
    """The least and the most x, and y, of all pixels of these windows."""
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


def step_px(to_px: Affine) -> float:
    """How many px of the plane lie between two of the crop."""
    return step_of(to_px.tolist())


def step_of(to_px: list[list[float]]) -> float:
    (a, b, _), (c, d, _) = to_px
    return float(abs(a * d - b * c) ** 0.5)


def shrink_factor(step: float) -> int:
    """A power of two that leaves at most 2 px between samples."""
    factor = 1
    while step > 2 * factor:
        factor *= 2
    return factor


class _Box(NamedTuple):
    """A part of a plane: from low to high."""

    low_x: int
    low_y: int
    high_x: int
    high_y: int

    def for_chroma(self, across: int, down: int) -> "_Box":
        """The same part of a chroma plane; low is a multiple of both."""
        low_x, low_y, high_x, high_y = self
        return _Box(low_x // across, low_y // down, -(-high_x // across), -(-high_y // down))


def part_around(reach: list[tuple[float, float]], plane: np.ndarray, multiple: int) -> _Box:
    """What of a plane lies within reach (of x, of y) and a little around it.

    From multiple to multiple: so averages do not swim with the window.
    """
    low, high = [], []
    for (first, last), length in zip(reach, plane.shape[1::-1], strict=True):
        low.append(min(max(int(first) - 2 * multiple, 0), length - 1) // multiple * multiple)
        needed = max(int(last) + 2 * multiple + 2, low[-1] + 1) - low[-1]
        there = max((length - low[-1]) // multiple * multiple, 1)
        high.append(low[-1] + min(-(-needed // multiple) * multiple, there))
    return _Box(*low, *high)


def shrunk(
    plane: np.ndarray, box: _Box, factor: int, every_row: bool = False
) -> tuple[np.ndarray, Affine]:
    """A part of a plane, averaged, and the map to it.

    Of what shrinks by more than 2 every second row is read, but where every_row is: memory is slow.
    """
    left, top, right, bottom = box
    wide, tall, skip = right - left, bottom - top, 2 if factor > 2 and not every_row else 1
    size = max(1, wide // factor), max(1, tall // factor)
    part = halved(plane[top:bottom:skip, left:right], factor // skip)
    if part.shape[1::-1] != size:
        part = cv2.resize(part, size)
    x_scale, y_scale = size[0] / wide, size[1] / tall
    first = top + (1 - skip) / 2  # the rows that are read lie higher than those that are not
    to_part = np.array([
        [x_scale, 0, (0.5 - left) * x_scale - 0.5],
        [0, y_scale, (0.5 - first) * y_scale - 0.5],
    ])  # fmt: skip
    return part, to_part


def halved(plane: np.ndarray, factor: int = 2) -> np.ndarray:
    """(H, W) or (H, W, C) averaged 2x2, without the last row or column of an odd number, until it
    is smaller by `factor`, a power of two.

    OpenCV is quick at exactly this: to average by 4 it takes six times as long as for this twice.
    """
    while factor > 1:
        h, w = plane.shape[:2]
        size = max(1, w // 2), max(1, h // 2)
        even = plane[: max(1, h & ~1), : max(1, w & ~1)]
        plane, factor = cv2.resize(even, size, interpolation=cv2.INTER_AREA), factor // 2
    return plane


def compose(second: Affine, first: Affine) -> Affine:
    """The map that does `first`, then `second`; `first` may be several, (..., 2, 3)."""
    both: Affine = second[:, :2] @ first
    both[..., 2] += second[:, 2]
    return both


def eight_bits(plane: np.ndarray, frame: Frame) -> np.ndarray:
    """Codes of a frame as those of 8 bits."""
    if plane.dtype == np.uint8:
        return plane
    return cv2.convertScaleAbs(plane, alpha=2.0 ** (8 - frame.bit_depth))


@lru_cache
def to_rgb_matrix(matrix: int, range_: int) -> np.ndarray:
    """(3, 4) from 8-bit Y'CbCr codes to R'G'B' codes 0..255 (ITU-T H.273, equations 32 to 43).

    Unspecified matrices count as BT.709 and an unspecified range as limited, which is what a net
    can tell no difference of.
    """
    kr, kb = {5: (0.299, 0.114), 6: (0.299, 0.114), 9: (0.2627, 0.0593), 10: (0.2627, 0.0593)}.get(
        matrix, (0.2126, 0.0722)
    )
    full = range_ == FULL_RANGE
    scale, lift = (1.0, 0.0) if full else (255 / 219, 16.0)
    chroma = 2.0 if full else 2 * 255 / 224
    kg = 1 - kr - kb
    red, blue = chroma * (1 - kr), chroma * (1 - kb)
    weights = np.array([
        [scale, 0, red],
        [scale, -blue * kb / kg, -red * kr / kg],
        [scale, blue, 0],
    ])  # fmt: skip
    return np.column_stack([weights, -weights @ [lift, 128, 128]])
