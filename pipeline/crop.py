"""Small upright RGB crops straight from a frame's planes: what the face nets look at.

Only the window's own pixels are read. It may be turned, and may reach beyond the picture, where
the border is repeated.
"""

from fractions import Fraction
from functools import cache
from typing import Protocol

import cv2
import numpy as np
from makeup_video.pipeline.frame import Frame

Affine = np.ndarray  # (2, 3) float64: (x, y, 1) -> (x, y)


class Picture(Protocol):
    """An upright picture with square pixels, however it is stored."""

    width_px: float
    height_px: float
    to_stored: Affine  # upright px -> stored px

    def crop(self, to_px: Affine, size_wh: tuple[int, int]) -> np.ndarray:
        """(H, W, 3) uint8 RGB, encoded; to_px maps the crop's pixels to upright pixels."""
        ...


class RgbPicture:
    """A picture that is stored as (H, W, 3) uint8 RGB and is upright already."""

    def __init__(self, rgb8: np.ndarray) -> None:
        if rgb8.ndim != 3 or rgb8.shape[2] != 3 or rgb8.dtype != np.uint8 or 0 in rgb8.shape:
            raise ValueError(
                f"a picture must be (H, W, 3) uint8, got {rgb8.shape} {rgb8.dtype}: "
                "convert it to 8-bit RGB first"
            )
        self.rgb8 = rgb8
        self.height_px, self.width_px = rgb8.shape[:2]
        self.to_stored = np.eye(2, 3)

    def crop(self, to_px: Affine, size_wh: tuple[int, int]) -> np.ndarray:
        return sample(self.rgb8, to_px, size_wh)


class FramePicture:
    """A frame's planes, seen upright.

    pixel_aspect: width of a stored pixel by its height (the sample aspect ratio).
    """

    def __init__(self, frame: Frame, pixel_aspect: Fraction | float = 1) -> None:
        self.frame = frame
        aspect = float(pixel_aspect) or 1.0
        wide, high = frame.width_px * aspect, float(frame.height_px)
        # where upright pixels lie in the picture with square pixels, not yet turned
        turned = {
            0: [[1, 0, 0], [0, 1, 0]],
            90: [[0, -1, wide - 1], [1, 0, 0]],
            180: [[-1, 0, wide - 1], [0, -1, high - 1]],
            270: [[0, 1, 0], [-1, 0, high - 1]],
        }[frame.rotation_degrees]
        upright = np.array(turned, np.float64)
        squeeze = np.array([[1 / aspect, 0, 0.5 / aspect - 0.5], [0, 1, 0]])
        self.to_stored = compose(squeeze, upright)
        across, down = frame.chroma
        self._to_chroma = np.array([
            [1 / across, 0, 0.5 / across - 0.5],
            [0, 1 / down, 0.5 / down - 0.5],
        ])  # fmt: skip
        self._to_rgb = to_rgb_matrix(frame.tags.matrix, frame.tags.range)
        sideways = frame.rotation_degrees % 180 == 90
        self.width_px, self.height_px = (high, wide) if sideways else (wide, high)

    def crop(self, to_px: Affine, size_wh: tuple[int, int]) -> np.ndarray:
        frame, planes = self.frame, self.frame.planes
        at = compose(self.to_stored, to_px)
        luma = _eight_bits(sample(planes[0], at, size_wh), frame.bit_depth)
        if len(planes) < 2:
            return cv2.merge([luma, luma, luma])
        at = compose(self._to_chroma, at)
        wanted = size_wh
        if frame.chroma != (1, 1) and _step(at) < 1:  # chroma has no more detail than this
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


_TWICE = np.array([[2.0, 0, 0.5], [0, 2.0, 0.5]])  # px of a crop of half the size -> its px


def sample(plane: np.ndarray, to_px: Affine, size_wh: tuple[int, int]) -> np.ndarray:
    """Bilinear samples of (H, W) or (H, W, C); where the crop shrinks, averages of 2x2, 4x4, ...

    to_px maps the crop's pixels to the plane's; the border is repeated beyond it.
    """
    step, factor = _step(to_px), 1
    while step > 2 * factor:
        factor *= 2
    if factor > 1:
        plane, to_px = _shrunk(plane, to_px, size_wh, factor)
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    return cv2.warpAffine(plane, to_px, size_wh, flags=flags, borderMode=cv2.BORDER_REPLICATE)


def _step(to_px: Affine) -> float:
    """How many px of the plane lie between two of the crop."""
    (a, b, _), (c, d, _) = to_px.tolist()
    return float(abs(a * d - b * c) ** 0.5)


def _shrunk(
    plane: np.ndarray, to_px: Affine, size_wh: tuple[int, int], factor: int
) -> tuple[np.ndarray, Affine]:
    """The part of the plane that the crop needs, averaged by `factor`, and the map to it."""
    low, high = [], []
    for (across, down, start), length in zip(to_px.tolist(), plane.shape[1::-1], strict=True):
        reach = sorted((0.0, across * (size_wh[0] - 1))), sorted((0.0, down * (size_wh[1] - 1)))
        first = int(start + reach[0][0] + reach[1][0]) - 2 * factor
        last = int(start + reach[0][1] + reach[1][1]) + 2 * factor + 2
        # From multiple to multiple of the factor: so the average does not swim with the window,
        # and OpenCV takes its fast way.
        low.append(min(max(first, 0), length - 1) // factor * factor)
        whole = -(-(max(last, low[-1] + 1) - low[-1]) // factor) * factor
        high.append(low[-1] + min(whole, max((length - low[-1]) // factor * factor, 1)))
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
    return part, compose(to_part, to_px)


def compose(second: Affine, first: Affine) -> Affine:
    """The map that does `first`, then `second`."""
    both: Affine = second[:, :2] @ first
    both[:, 2] += second[:, 2]
    return both


def _eight_bits(plane: np.ndarray, bit_depth: int) -> np.ndarray:
    if plane.dtype == np.uint8:
        return plane
    return cv2.convertScaleAbs(plane, alpha=2.0 ** (8 - bit_depth))


@cache
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
