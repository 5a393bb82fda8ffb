"""Pictures seen upright with square pixels, however they are stored: what the nets look at."""

from collections.abc import Sequence
from fractions import Fraction
from functools import lru_cache
from typing import Protocol

import cv2
import numpy as np
from makeup_video.pipeline.frames.frame import Frame
from makeup_video.pipeline.frames.sampling import (
    Affine,
    compose,
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
    to_rgb_matrix,
    warp,
)

Crop = tuple[Affine, tuple[int, int]]  # crop px -> upright px, and the crop's width and height
Crops = tuple[np.ndarray, tuple[int, int]]  # several of one size: (K, 2, 3), and that size


class Picture(Protocol):
    """An upright picture with square pixels, however it is stored."""

    width_px: float
    height_px: float
    to_stored: Affine  # upright px -> stored px

    def crop(self, to_px: Affine, size_wh: tuple[int, int]) -> np.ndarray:
        """(H, W, 3) uint8 RGB, encoded; to_px maps the crop's pixels to upright pixels."""
        ...

    def crops(self, windows: Sequence[Crops]) -> list[np.ndarray]:
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

    def crops(self, windows: Sequence[Crops]) -> list[np.ndarray]:
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
        return warp(rgb8, at, size_wh)

    def crops(self, windows: Sequence[Crops]) -> list[np.ndarray]:
        # Every call into OpenCV costs as much as a thousand pixels: so all crops are one list of
        # places, sampled at once.
        sizes = [size for maps, size in windows for _ in maps]
        rgb8, at = self._near(np.concatenate([maps for maps, _ in windows]), sizes)
        # it takes less than half as long for four channels as for three
        rgb8 = cv2.cvtColor(rgb8, cv2.COLOR_RGB2RGBA)
        found = remap(rgb8, _places(at.astype(np.float32), sizes))
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
        factor = shrink_factor(max(map(step_of, plain)))
        across, down = self.frame.chroma
        box = part_around(reach_of(plain, sizes), planes[0], max(factor, across, down))
        luma, to_part = shrunk(planes[0], box, factor)
        size, box = luma.shape[1::-1], box.for_chroma(across, down)
        chroma = [shrunk(p, box, max(1, factor // max(across, down)))[0] for p in planes[1:3]]
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


def _places(maps: np.ndarray, sizes: Sequence[tuple[int, int]]) -> np.ndarray:
    """Where the maps (K, 2, 3) float32 lead the pixels of windows: (2, N), one after the other."""
    places = np.empty((2, sum(w * h for w, h in sizes)), np.float32)
    first = 0
    for at, (w, h) in zip(maps, sizes, strict=True):
        np.matmul(at, pixel_places((w, h)), out=places[:, first : first + w * h])
        first += w * h
    return places


def _squeezed(plane: np.ndarray, size_wh: tuple[int, int]) -> np.ndarray:
    """All of a plane (H, W) or (H, W, C) at a size of about its shape; at most four rows are read
    for one, but all columns, for the smallest face is hardly larger than one of these."""
    h, w = plane.shape[:2]
    factor = shrink_factor(min(w / size_wh[0], h / size_wh[1]))
    skip = max(1, factor // 4)
    part = halved(plane[skip // 2 :: skip], factor // skip)
    return cv2.resize(part, size_wh, interpolation=cv2.INTER_AREA if skip > 1 else cv2.INTER_LINEAR)
