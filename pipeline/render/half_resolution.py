"""Large regions painted at half or a quarter of the size: veils, and all on a slow machine.

The product is painted on the picture averaged 2x2 or 4x4. The change is then enlarged and added to
the full picture, which keeps its detail. A pixel more than two (or four) px away from every pixel
that has weight at the small size keeps its byte.
"""

from collections.abc import Callable, Sequence
from functools import cache

import cv2
import numpy as np
from makeup_video.kernels.planes import Rect
from makeup_video.pipeline.frames.affine import AffineArray
from makeup_video.pipeline.frames.sampling import halved

# Luma px of all rects of a frame, from which on they are painted at half size. With fewer px, less
# than a sixth of the painting time is saved, and the averaging is more visible.
LARGE_PX = 30_000


class SmallPlanes:
    """Planes at 1/factor of the size, kept from frame to frame; only painted rects are filled."""

    def __init__(self, factor: int) -> None:
        """factor: 2 or 4."""
        self.factor = factor
        self._like: list[tuple[tuple[int, ...], np.dtype]] = []  # shapes and dtypes at full size
        self._planes: tuple[np.ndarray, ...] = ()

    def paint(
        self,
        planes: tuple[np.ndarray, ...],
        rects: Sequence[Rect],
        block: tuple[int, int],
        max_code: int,
        paint: Callable[[tuple[np.ndarray, ...]], None],
    ) -> None:
        """Change `planes`, luma first, as `paint` changes the small planes that it is given.

        rects: where there is something to paint, in px of the small planes.
        """
        self._make_room(planes)
        ours = [part for rect in rects for part in _parts(self._planes, rect, block)]
        enlarged = [_enlarged(rect, planes, self.factor) for rect in rects]
        theirs = [part for rect in enlarged for part in _parts(planes, rect, block)]
        before = [_averaged(large, self.factor) for large in theirs]
        for small, bare in zip(ours, before, strict=True):
            small[:] = bare
        paint(self._planes)
        for small, bare, large in zip(ours, before, theirs, strict=True):
            _add(large, cv2.subtract(small, bare), cv2.subtract(bare, small), self.factor)
        if planes[0].itemsize > 1:  # codes of 10 or 12 bits
            for large in theirs:
                np.minimum(large, max_code, out=large)

    def _make_room(self, planes: tuple[np.ndarray, ...]) -> None:
        like = [(plane.shape, plane.dtype) for plane in planes]
        if like != self._like:
            self._like = like
            self._planes = tuple(
                np.zeros((*small_size(plane.shape[:2], self.factor), *plane.shape[2:]), plane.dtype)
                for plane in planes
            )


def small_size(size: tuple[int, ...], factor: int) -> tuple[int, int]:
    """Return the size of the small picture: width and height in the order given, rounded up."""
    return -(-size[0] // factor), -(-size[1] // factor)


@cache
def to_small(factor: int) -> AffineArray:
    """The map from px of a picture to px of the small one; whole numbers are centres of px."""
    share = 1 / factor
    return np.array([[share, 0, 0.5 * share - 0.5], [0, share, 0.5 * share - 0.5]])


def _enlarged(rect: Rect, planes: tuple[np.ndarray, ...], factor: int) -> Rect:
    """Return the rect in px of the picture itself, cut off at the picture's borders."""
    high, wide = planes[0].shape
    x, y = factor * rect.x, factor * rect.y
    return Rect(x, y, min(factor * rect.width, wide - x), min(factor * rect.height, high - y))


def _parts(planes: tuple[np.ndarray, ...], rect: Rect, block: tuple[int, int]) -> list[np.ndarray]:
    """Views of a rect on every plane; NV12 keeps Cb and Cr in one plane."""
    at = rect.chroma_slices(block)
    return [rect.luma(planes), *(plane[at] for plane in planes[1:3])]


def _averaged(part: np.ndarray, factor: int) -> np.ndarray:
    """(H, W) or (H, W, 2) averaged 2x2 or 4x4; the last row and column are repeated as needed."""
    high, wide = part.shape[:2]
    below, right = -high % factor, -wide % factor
    if below or right:
        part = cv2.copyMakeBorder(part, 0, below, 0, right, cv2.BORDER_REPLICATE)
    return halved(part, factor)


def _add(part: np.ndarray, lighter: np.ndarray, darker: np.ndarray, factor: int) -> None:
    """Enlarge the codes (h, w) to be added and to be subtracted, and change a part of a plane.

    Both have the type of the plane, since no code is negative: OpenCV adds arrays of one type
    several times as quickly as arrays of two types.
    """
    high, wide = part.shape[:2]
    size = factor * lighter.shape[1], factor * lighter.shape[0]
    for change, apply in ((lighter, cv2.add), (darker, cv2.subtract)):
        if cv2.hasNonZero(change.reshape(-1, 1)):
            large = cv2.resize(change, size, interpolation=cv2.INTER_LINEAR)[:high, :wide]
            apply(part, large, dst=part)
