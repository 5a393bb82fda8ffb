"""Upright views with square pixels of pictures stored in any way: what the nets read."""

from collections.abc import Sequence
from fractions import Fraction
from functools import lru_cache
from typing import Protocol

import cv2
import numpy as np
from makeup_video.kernels.colour import Coding, matrices
from makeup_video.pipeline.errors import UsageError
from makeup_video.pipeline.frames.affine import AS_STORED, Affine, AffineArray, compose
from makeup_video.pipeline.frames.colour_tags import FULL_RANGE, ColourTags, resolve
from makeup_video.pipeline.frames.frame import Frame
from makeup_video.pipeline.frames.sampling import (
    eight_bits,
    halved,
    part_around,
    pixel_places,
    reach_of,
    remap,
    sample,
    shrink_factor,
    shrunk,
    step_of,
    warp,
)

# FFmpeg makes no frame of this many px, counted with a margin to the right and below.
_MOST_PX, _MARGIN_PX = (2**31 - 1) // 8, 128

Crop = tuple[AffineArray, tuple[int, int]]  # crop px -> upright px, and (width, height)
Crops = tuple[np.ndarray, tuple[int, int]]  # crops of one size: maps (K, 2, 3), (width, height)


class Picture(Protocol):
    """An upright view with square pixels of a stored picture."""

    width_px: float
    height_px: float
    to_stored: AffineArray  # upright px -> stored px; AS_STORED where these are the same

    def crop(self, to_px: AffineArray, size_wh: tuple[int, int]) -> np.ndarray:
        """(H, W, 3) uint8, encoded R'G'B'. to_px: (2, 3), crop px -> upright px."""
        ...

    def crops(self, groups: Sequence[Crops]) -> list[np.ndarray]:
        """(K, H, W, 3) uint8 for each group of crops.

        Less work than one by one, if the crops have about the same scale and lie close together.
        """
        ...

    def whole(self, size_wh: tuple[int, int]) -> np.ndarray:
        """The whole picture, (H, W, 3), at a size of about its aspect ratio."""
        ...


def check_rgb8(rgb8: np.ndarray) -> None:
    """Raises ValueError unless rgb8 is an (H, W, 3) uint8 picture."""
    if not hasattr(rgb8, "shape") or not hasattr(rgb8, "dtype"):
        raise ValueError(
            f"a picture must be an array, (H, W, 3) uint8, got {type(rgb8).__name__}: "
            "np.asarray(PIL.Image.open(name)) reads one from a file"
        )
    shape, dtype = rgb8.shape, rgb8.dtype
    if len(shape) != 3 or shape[2] != 3 or dtype != np.uint8:
        raise ValueError(
            f"a picture must be (H, W, 3) uint8, got {shape} {dtype}: convert it to 8-bit RGB first"
        )
    if 0 in shape:
        raise ValueError(
            f"a picture must be (H, W, 3) uint8, got {shape}, no pixel: give 8-bit RGB with some"
        )


def check_paintable(rgb8: np.ndarray) -> None:
    """Raises ValueError unless rgb8 is an (H, W, 3) uint8 picture that a frame can hold."""
    check_rgb8(rgb8)
    height, width = rgb8.shape[:2]
    if (width + _MARGIN_PX) * (height + _MARGIN_PX) >= _MOST_PX:
        raise ValueError(
            f"a picture to paint must have less than {_MOST_PX / 1e6:.0f} million px, with "
            f"{_MARGIN_PX} px more each way, got {width} x {height}: make it smaller first"
        )


class RgbPicture:
    """A picture stored upright, as (H, W, 3) uint8 R'G'B'."""

    def __init__(self, rgb8: np.ndarray) -> None:
        check_rgb8(rgb8)
        self.rgb8 = np.ascontiguousarray(rgb8)  # once here, or OpenCV copies it for every crop
        self.height_px, self.width_px = rgb8.shape[:2]
        self.to_stored = AS_STORED

    def crop(self, to_px: AffineArray, size_wh: tuple[int, int]) -> np.ndarray:
        return sample(self.rgb8, to_px, size_wh)

    def crops(self, groups: Sequence[Crops]) -> list[np.ndarray]:
        return [
            np.stack([sample(self.rgb8, to_px, size) for to_px in maps]) for maps, size in groups
        ]

    def whole(self, size_wh: tuple[int, int]) -> np.ndarray:
        return _squeezed(self.rgb8, size_wh)


class FramePicture:
    """An upright view of a frame's planes.

    pixel_aspect: width of a stored pixel divided by its height (the sample aspect ratio).
    """

    def __init__(self, frame: Frame, pixel_aspect: Fraction | float = 1) -> None:
        self.frame = frame
        key = frame.width_px, frame.height_px, float(pixel_aspect) or 1.0, frame.rotation_degrees
        self.to_stored, self.width_px, self.height_px = _upright(*key)
        self._to_rgb = _to_rgb_matrix(frame.tags, frame.width_px, frame.height_px)

    def crop(self, to_px: AffineArray, size_wh: tuple[int, int]) -> np.ndarray:
        rgb8, (to_part,) = self._rgb_around([to_px.tolist()], [size_wh])
        return warp(rgb8, to_part.array(), size_wh)

    def crops(self, groups: Sequence[Crops]) -> list[np.ndarray]:
        # A call into OpenCV costs as much as a thousand pixels, so the pixels of all crops are one
        # list of points that is sampled at once.
        sizes = [size for maps, size in groups for _ in maps]
        maps = [to_px for maps, _ in groups for to_px in maps.tolist()]
        rgb8, to_part = self._rgb_around(maps, sizes)
        # remap takes less than half as long for four channels as for three
        rgb8 = cv2.cvtColor(rgb8, cv2.COLOR_RGB2RGBA)
        samples = remap(rgb8, _places(to_part, sizes))
        samples = cv2.cvtColor(samples, cv2.COLOR_RGBA2RGB)[0]
        crops, first = [], 0
        for of_group, (w, h) in groups:
            end = first + len(of_group) * w * h
            crops.append(samples[first:end].reshape(len(of_group), h, w, 3))
            first = end
        return crops

    def whole(self, size_wh: tuple[int, int]) -> np.ndarray:
        turned, planes = self.frame.rotation_degrees, self.frame.planes
        size = size_wh if turned % 180 == 0 else size_wh[::-1]
        luma, *chroma = (_squeezed(plane, size) for plane in planes[:3])
        return np.rot90(self._rgb(luma, chroma), turned // 90)

    def _rgb_around(
        self, maps: list[list[list[float]]], sizes: Sequence[tuple[int, int]]
    ) -> tuple[np.ndarray, list[Affine]]:
        """The part (H, W, 3) of the picture under crops, and the maps crop px -> part px.

        The part is converted to RGB once for all crops: the closer they lie, the smaller it is.
        maps: crop px -> upright px, as nested lists (2, 3), since numpy is slow on so few numbers.
        """
        if self.to_stored is not AS_STORED:
            maps = compose(self.to_stored, np.array(maps)).tolist()
        planes = self.frame.planes
        factor = shrink_factor(max(map(step_of, maps)))
        across, down = self.frame.chroma
        box = part_around(reach_of(maps, sizes), planes[0], max(factor, across, down))
        luma, to_part = shrunk(planes[0], box, factor)
        size, box = luma.shape[1::-1], box.for_chroma(across, down)
        chroma = [shrunk(p, box, max(1, factor // max(across, down)))[0] for p in planes[1:3]]
        chroma = [p if p.shape[1::-1] == size else cv2.resize(p, size) for p in chroma]
        of_crops = [to_part.after(Affine(*row_x, *row_y)) for row_x, row_y in maps]
        return self._rgb(luma, chroma), of_crops

    def _rgb(self, luma: np.ndarray, chroma: list[np.ndarray]) -> np.ndarray:
        """(H, W, 3) uint8 from samples (H, W) of the planes; NV12 has one (H, W, 2) for chroma."""
        if chroma and chroma[0].ndim == 3:
            chroma = list(cv2.split(chroma[0]))
        planes = [eight_bits(plane, self.frame) for plane in (luma, *chroma)]
        if len(planes) < 2:
            return cv2.merge(planes * 3)
        return cv2.transform(cv2.merge(planes), self._to_rgb)


@lru_cache
def _to_rgb_matrix(tags: ColourTags, width_px: int, height_px: int) -> np.ndarray:
    """(3, 4) from 8-bit Y'CbCr codes to R'G'B' codes 0..255.

    Tags that cannot be painted on (ICtCp, YCgCo) count as BT.709: the faces are still found.
    """
    try:
        coding = resolve(tags, width_px, height_px, 8)
    except UsageError:
        coding = Coding(full_range=tags.range == FULL_RANGE)
    return 255 * matrices(coding)[0]


@lru_cache
def _upright(
    width_px: int, height_px: int, pixel_aspect: float, rotation_degrees: int
) -> tuple[AffineArray, float, float]:
    """Upright px -> stored px, and the upright picture's width and height."""
    wide, high = width_px * pixel_aspect, float(height_px)
    # upright px -> px of the picture as stored, but with square pixels
    turned = {
        0: [[1, 0, 0], [0, 1, 0]],
        90: [[0, -1, wide - 1], [1, 0, 0]],
        180: [[-1, 0, wide - 1], [0, -1, high - 1]],
        270: [[0, 1, 0], [-1, 0, high - 1]],
    }[rotation_degrees]
    squeeze = np.array([[1 / pixel_aspect, 0, 0.5 / pixel_aspect - 0.5], [0, 1, 0]])
    size = (high, wide) if rotation_degrees % 180 == 90 else (wide, high)
    to_stored = compose(squeeze, np.array(turned, np.float64))
    return AS_STORED if np.array_equal(to_stored, AS_STORED) else to_stored, *size


def _places(maps: Sequence[Affine], sizes: Sequence[tuple[int, int]]) -> np.ndarray:
    """Where maps lead the pixels of their crops: (2, N) float32, crop after crop."""
    to_places = np.array(maps, np.float32).reshape(-1, 2, 3)
    places = np.empty((2, sum(w * h for w, h in sizes)), np.float32)
    first = 0
    for to_px, (w, h) in zip(to_places, sizes, strict=True):
        np.matmul(to_px, pixel_places((w, h)), out=places[:, first : first + w * h])
        first += w * h
    return places


def _squeezed(plane: np.ndarray, size_wh: tuple[int, int]) -> np.ndarray:
    """All of a plane (H, W) or (H, W, C), resized to a size of about its aspect ratio.

    At most four rows are read for each row of the result. All columns are read: the smallest face
    is hardly larger than one pixel of the result.
    """
    h, w = plane.shape[:2]
    factor = shrink_factor(min(w / size_wh[0], h / size_wh[1]))
    skip = max(1, factor // 4)
    part = halved(plane[skip // 2 :: skip], factor // skip)
    return cv2.resize(part, size_wh, interpolation=cv2.INTER_AREA if skip > 1 else cv2.INTER_LINEAR)
