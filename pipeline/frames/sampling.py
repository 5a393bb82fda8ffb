"""Small upright RGB crops straight from a frame's planes: what the face nets look at.

Only the window's own pixels are read. It may be turned, and may reach beyond the picture, where
the border is repeated.
"""

from collections.abc import Sequence
from fractions import Fraction
from functools import lru_cache
from typing import NamedTuple, Protocol

import cv2
import numpy as np
from makeup_video.pipeline.frame import Frame

Affine = np.ndarray  # (2, 3) float64: (x, y, 1) -> (x, y)
Window = tuple[Affine, tuple[int, int]]  # crop px -> upright px, and the crop's width and height
Windows = tuple[np.ndarray, tuple[int, int]]  # several of one size: (K, 2, 3), and that size


class Picture(Protocol):
    """An upright picture with square pixels, however it is stored."""

    width_px: float
    height_px: float
    to_stored: Affine  # upright px -> stored px

    def crop(self, to_px: Affine, size_wh: tuple[int, int]) -> np.ndarray:
        """(H, W, 3) uint8 RGB, encoded; to_px maps the crop's pixels to upright pixels."""
        ...

    def crops(self, windows: Sequence[Windows]) -> list[np.ndarray]:
        """Several crops of about the same scale that lie close together, for less work: (K, H, W, 3)
        for each size."""
        ...

    def whole(self, size_wh: tuple[int, int]) -> np.ndarray:
        """All of it, (H, W, 3), at a size of about its shape."""
        ...


def check_rgb8(rgb8: np.ndarray) -> None:
    """Raises ValueError for what is no (H, W, 3) uint8 picture."""
    shape: tuple[int, ...] = getattr(rgb8, "shape", ())
    dtype = getattr(rgb8, "dtype", type(rgb8).__name__)
    if len(shape) != 3 or shape[2] != 3 or dtype != np.uint8 or 0 in shape:
        raise ValueError(
            f"a picture must be (H, W, 3) uint8, got {shape} {dtype}: convert it to 8-bit RGB first"
        )


class RgbPicture:
    """A picture that is stored as (H, W, 3) uint8 RGB and is upright already."""

    def __init__(self, rgb8: np.ndarray) -> None:
        check_rgb8(rgb8)
        self.rgb8 = np.ascontiguousarray(rgb8)  # once, or OpenCV copies it for every crop
        self.height_px, self.width_px = rgb8.shape[:2]
        self.to_stored = np.eye(2, 3)

    def crop(self, to_px: Affine, size_wh: tuple[int, int]) -> np.ndarray:
        return sample(self.rgb8, to_px, size_wh)

    def crops(self, windows: Sequence[Windows]) -> list[np.ndarray]:
        return [
            np.stack([sample(self.rgb8, to_px, size) for to_px in maps]) for maps, size in windows
        ]

    def whole(self, size_wh: tuple[int, int]) -> np.ndarray:
        return _squeezed(self.rgb8, size_wh)


class FramePicture:
    """A frame's planes, seen upright.

    pixel_aspect: width of a stored pixel by its height (the sample aspect ratio).
    """

    def __init__(self, frame: Frame, pixel_aspect: Fraction | float = 1) -> None:
        self.frame = frame
        key = frame.width_px, frame.height_px, float(pixel_aspect) or 1.0, frame.rotation_degrees
        self.to_stored, self.width_px, self.height_px = _upright(*key)
        self._to_rgb = to_rgb_matrix(frame.tags.matrix, frame.tags.range)

    def crop(self, to_px: Affine, size_wh: tuple[int, int]) -> np.ndarray:
        rgb8, (at,) = self._near(to_px[None], [size_wh])
        return _warp(rgb8, at, size_wh)

    def crops(self, windows: Sequence[Windows]) -> list[np.ndarray]:
        # Every call into OpenCV costs as much as a thousand pixels: so all crops are one list of
        # places, sampled at once.
        sizes = [size for maps, size in windows for _ in maps]
        rgb8, at = self._near(np.concatenate([maps for maps, _ in windows]), sizes)
        # it takes less than half as long for four channels as for three
        rgb8 = cv2.cvtColor(rgb8, cv2.COLOR_RGB2RGBA)
        found = _remap(rgb8, _places(at.astype(np.float32), sizes))
        found = cv2.cvtColor(found, cv2.COLOR_RGBA2RGB)[0]
        parts, first = [], 0
        for maps, (w, h) in windows:
            end = first + len(maps) * w * h
            parts.append(found[first:end].reshape(len(maps), h, w, 3))
            first = end
        return parts

    def whole(self, size_wh: tuple[int, int]) -> np.ndarray:
        turned, planes = self.frame.rotation_degrees, self.frame.planes
        size = size_wh if turned % 180 == 0 else size_wh[::-1]
        luma, *chroma = (_squeezed(plane, size) for plane in planes[:3])
        return np.rot90(self._rgb(luma, chroma), turned // 90)

    def _near(
        self, to_px: np.ndarray, sizes: Sequence[tuple[int, int]]
    ) -> tuple[np.ndarray, np.ndarray]:
        """What windows (K, 2, 3) show and a little more, (H, W, 3), and the maps from them to it.

        Colours are mixed here, once for what all windows show: the nearer they are, the less that is.
        """
        maps, planes = compose(self.to_stored, to_px), self.frame.planes
        plain = maps.tolist()
        factor = _shrink_factor(max(map(_step, plain)))
        across, down = self.frame.chroma
        box = _box(_reach(plain, sizes), planes[0], max(factor, across, down))
        luma, to_part = _shrunk(planes[0], box, factor)
        size, box = luma.shape[1::-1], box.for_chroma(across, down)
        chroma = [_shrunk(p, box, max(1, factor // max(across, down)))[0] for p in planes[1:3]]
        chroma = [p if p.shape[1::-1] == size else cv2.resize(p, size) for p in chroma]
        return self._rgb(luma, chroma), compose(to_part, maps)

    def _rgb(self, luma: np.ndarray, chroma: list[np.ndarray]) -> np.ndarray:
        """(H, W, 3) uint8 of samples (H, W) of the planes; NV12 keeps both of chroma in one."""
        if chroma and chroma[0].ndim == 3:
            chroma = list(cv2.split(chroma[0]))
        planes = [eight_bits(plane, self.frame) for plane in (luma, *chroma)]
        if len(planes) < 2:
            return cv2.merge(planes * 3)
        return cv2.transform(cv2.merge(planes), self._to_rgb)


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
def _upright(
    width_px: int, height_px: int, pixel_aspect: float, rotation_degrees: int
) -> tuple[Affine, float, float]:
    """Upright px -> stored px, and the upright picture's width and height."""
    wide, high = width_px * pixel_aspect, float(height_px)
    # where upright pixels lie in the picture with square pixels, not yet turned
    turned = {
        0: [[1, 0, 0], [0, 1, 0]],
        90: [[0, -1, wide - 1], [1, 0, 0]],
        180: [[-1, 0, wide - 1], [0, -1, high - 1]],
        270: [[0, 1, 0], [-1, 0, high - 1]],
    }[rotation_degrees]
    squeeze = np.array([[1 / pixel_aspect, 0, 0.5 / pixel_aspect - 0.5], [0, 1, 0]])
    size = (high, wide) if rotation_degrees % 180 == 90 else (wide, high)
    return compose(squeeze, np.array(turned, np.float64)), *size


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
    factor = _shrink_factor(step_px(to_px))
    if factor > 1:
        box = _box(_reach([to_px.tolist()], [size_wh]), plane, factor)
        plane, to_part = _shrunk(plane, box, factor)
        to_px = compose(to_part, to_px)
    return _warp(plane, to_px, size_wh)


def sample_at(plane: np.ndarray, places: np.ndarray, step: float) -> np.ndarray:
    """The same at any places (2, N) float32, x and y, of which neighbours are `step` px apart.

    Returns (1, N) or (1, N, C).
    """
    factor = _shrink_factor(step)
    if factor > 1:
        reach = list(zip(places.min(1).tolist(), places.max(1).tolist(), strict=True))
        plane, to_part = _shrunk(plane, _box(reach, plane, factor), factor, every_row=True)
        scale = to_part.diagonal().astype(np.float32)[:, None]
        places = places * scale + to_part[:, 2:].astype(np.float32)
    return _remap(plane, places)


def _places(maps: np.ndarray, sizes: Sequence[tuple[int, int]]) -> np.ndarray:
    """Where the maps (K, 2, 3) float32 lead the pixels of windows: (2, N), one after the other."""
    places = np.empty((2, sum(w * h for w, h in sizes)), np.float32)
    first = 0
    for at, (w, h) in zip(maps, sizes, strict=True):
        np.matmul(at, pixel_places((w, h)), out=places[:, first : first + w * h])
        first += w * h
    return places


def _warp(plane: np.ndarray, to_px: Affine, size_wh: tuple[int, int]) -> np.ndarray:
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    return cv2.warpAffine(plane, to_px, size_wh, flags=flags, borderMode=cv2.BORDER_REPLICATE)


def _remap(plane: np.ndarray, places: np.ndarray) -> np.ndarray:
    return cv2.remap(
        plane, places[:1], places[1:], cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE
    )


def _reach(
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
    return _step(to_px.tolist())


def _step(to_px: list[list[float]]) -> float:
    (a, b, _), (c, d, _) = to_px
    return float(abs(a * d - b * c) ** 0.5)


def _shrink_factor(step: float) -> int:
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


def _box(reach: list[tuple[float, float]], plane: np.ndarray, multiple: int) -> _Box:
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


def _shrunk(
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


def _squeezed(plane: np.ndarray, size_wh: tuple[int, int]) -> np.ndarray:
    """All of a plane (H, W) or (H, W, C) at a size of about its shape; at most four rows are read
    for one, but all columns, for the smallest face is hardly larger than one of these."""
    h, w = plane.shape[:2]
    factor = _shrink_factor(min(w / size_wh[0], h / size_wh[1]))
    skip = max(1, factor // 4)
    part = halved(plane[skip // 2 :: skip], factor // skip)
    return cv2.resize(part, size_wh, interpolation=cv2.INTER_AREA if skip > 1 else cv2.INTER_LINEAR)


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
    full = range_ == 2
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
