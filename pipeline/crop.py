"""Small upright RGB crops straight from a frame's planes: what the face nets look at.

Only the window's own pixels are read. It may be turned, and may reach beyond the picture, where
the border is repeated.
"""

from collections.abc import Sequence
from fractions import Fraction
from functools import lru_cache
from typing import Protocol

import cv2
import numpy as np
from makeup_video.pipeline.frame import Frame

Affine = np.ndarray  # (2, 3) float64: (x, y, 1) -> (x, y)
Window = tuple[Affine, tuple[int, int]]  # crop px -> upright px, and the crop's width and height


class Picture(Protocol):
    """An upright picture with square pixels, however it is stored."""

    width_px: float
    height_px: float
    to_stored: Affine  # upright px -> stored px

    def crop(self, to_px: Affine, size_wh: tuple[int, int]) -> np.ndarray:
        """(H, W, 3) uint8 RGB, encoded; to_px maps the crop's pixels to upright pixels."""
        ...

    def crops(self, windows: Sequence[Window]) -> list[np.ndarray]:
        """Several crops of about the same scale that lie close together, for less work."""
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

    def crops(self, windows: Sequence[Window]) -> list[np.ndarray]:
        return [sample(self.rgb8, *window) for window in windows]


class FramePicture:
    """A frame's planes, seen upright.

    pixel_aspect: width of a stored pixel by its height (the sample aspect ratio).
    """

    def __init__(self, frame: Frame, pixel_aspect: Fraction | float = 1) -> None:
        self.frame = frame
        key = frame.width_px, frame.height_px, float(pixel_aspect) or 1.0, frame.rotation_degrees
        self.to_stored, self.width_px, self.height_px = _upright(*key)
        self._to_chroma = _to_chroma(*frame.chroma)
        self._to_rgb = to_rgb_matrix(frame.tags.matrix, frame.tags.range)

    def crop(self, to_px: Affine, size_wh: tuple[int, int]) -> np.ndarray:
        frame, planes = self.frame, self.frame.planes
        at = compose(self.to_stored, to_px)
        luma = _eight_bits(sample(planes[0], at, size_wh), frame.bit_depth)
        if len(planes) < 2:
            return cv2.merge([luma, luma, luma])
        at = compose(self._to_chroma, at)
        wanted = size_wh
        if frame.chroma != (1, 1) and step_px(at) < 1:  # chroma has no more detail than this
            wanted = (size_wh[0] + 1) // 2, (size_wh[1] + 1) // 2
            at = compose(at, _TWICE)
        chroma = [sample(plane, at, wanted) for plane in planes[1:3]]
        if chroma[0].ndim == 3:  # NV12 keeps both in one plane
            chroma = list(cv2.split(chroma[0]))
        chroma = [_eight_bits(plane, frame.bit_depth) for plane in chroma[:2]]
        if wanted != size_wh:
            twice = wanted[0] * 2, wanted[1] * 2
            chroma = [cv2.resize(plane, twice)[: size_wh[1], : size_wh[0]] for plane in chroma]
        return cv2.transform(cv2.merge([luma, *chroma]), self._to_rgb)

    def crops(self, windows: Sequence[Window]) -> list[np.ndarray]:
        # Every call into OpenCV costs as much as a thousand pixels: so all crops are one list of
        # places, sampled at once.
        maps = [compose(self.to_stored, to_px) for to_px, _ in windows]
        sizes = [size_wh for _, size_wh in windows]
        places = [
            at.astype(np.float32) @ pixel_places(size) for at, size in zip(maps, sizes, strict=True)
        ]
        at, step = np.concatenate(places, axis=1), max(map(step_px, maps))
        rows = [_eight_bits(row, self.frame.bit_depth) for row in samples_at(self.frame, at, step)]
        if len(rows) > 1:
            rgb8 = cv2.transform(cv2.merge(rows[:3]), self._to_rgb)
        else:
            rgb8 = cv2.merge(rows * 3)
        parts = np.split(rgb8[0], np.cumsum([w * h for w, h in sizes])[:-1])
        return [part.reshape(h, w, 3) for part, (w, h) in zip(parts, sizes, strict=True)]


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


_TWICE = np.array([[2.0, 0, 0.5], [0, 2.0, 0.5]])  # px of a crop of half the size -> its px


def sample(plane: np.ndarray, to_px: Affine, size_wh: tuple[int, int]) -> np.ndarray:
    """Bilinear samples of (H, W) or (H, W, C); where the crop shrinks, averages of 2x2, 4x4, ...

    to_px maps the crop's pixels to the plane's; the border is repeated beyond it.
    """
    factor = _shrink_factor(step_px(to_px))
    if factor > 1:
        reach = []
        for across, down, start in to_px.tolist():
            ends = sorted((0.0, across * (size_wh[0] - 1))), sorted((0.0, down * (size_wh[1] - 1)))
            reach.append((start + ends[0][0] + ends[1][0], start + ends[0][1] + ends[1][1]))
        plane, to_part = _shrunk(plane, reach, factor)
        to_px = compose(to_part, to_px)
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    return cv2.warpAffine(plane, to_px, size_wh, flags=flags, borderMode=cv2.BORDER_REPLICATE)


def sample_at(plane: np.ndarray, places: np.ndarray, step: float) -> np.ndarray:
    """The same at any places (2, N) float32, x and y, of which neighbours are `step` px apart.

    Returns (1, N) or (1, N, C).
    """
    factor = _shrink_factor(step)
    if factor > 1:
        reach = list(zip(places.min(1).tolist(), places.max(1).tolist(), strict=True))
        plane, to_part = _shrunk(plane, reach, factor)
        scale = to_part.diagonal().astype(np.float32)[:, None]
        places = places * scale + to_part[:, 2:].astype(np.float32)
    return cv2.remap(
        plane, places[:1], places[1:], cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE
    )


def step_px(to_px: Affine) -> float:
    """How many px of the plane lie between two of the crop."""
    (a, b, _), (c, d, _) = to_px.tolist()
    return float(abs(a * d - b * c) ** 0.5)


def _shrink_factor(step: float) -> int:
    """A power of two that leaves at most 2 px between samples."""
    factor = 1
    while step > 2 * factor:
        factor *= 2
    return factor


def _shrunk(
    plane: np.ndarray, reach: list[tuple[float, float]], factor: int
) -> tuple[np.ndarray, Affine]:
    """The part of the plane within reach (of x, of y), averaged by `factor`, and the map to it."""
    low, high = [], []
    for (first, last), length in zip(reach, plane.shape[1::-1], strict=True):
        # From multiple to multiple of the factor: so the average does not swim with the window,
        # and OpenCV takes its fast way.
        low.append(min(max(int(first) - 2 * factor, 0), length - 1) // factor * factor)
        needed = max(int(last) + 2 * factor + 2, low[-1] + 1) - low[-1]
        there = max((length - low[-1]) // factor * factor, 1)
        high.append(low[-1] + min(-(-needed // factor) * factor, there))
    # of a very large picture every second, fourth ... px is enough for an average of many
    skip = max(1, factor // 8)
    part = plane[low[1] : high[1] : skip, low[0] : high[0] : skip]
    if skip > 1:
        part = np.ascontiguousarray(part)
    wide, tall = high[0] - low[0], high[1] - low[1]
    size = max(1, wide // factor), max(1, tall // factor)
    part = cv2.resize(part, size, interpolation=cv2.INTER_AREA)
    x_scale, y_scale = size[0] / wide, size[1] / tall
    to_part = np.array([
        [x_scale, 0, (0.5 - low[0]) * x_scale - 0.5],
        [0, y_scale, (0.5 - low[1]) * y_scale - 0.5],
    ])  # fmt: skip
    return part, to_part


def compose(second: Affine, first: Affine) -> Affine:
    """The map that does `first`, then `second`."""
    both: Affine = second[:, :2] @ first
    both[:, 2] += second[:, 2]
    return both


def _eight_bits(plane: np.ndarray, bit_depth: int) -> np.ndarray:
    if plane.dtype == np.uint8:
        return plane
    return cv2.convertScaleAbs(plane, alpha=2.0 ** (8 - bit_depth))


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
