"""Large regions painted at half size, on a machine that is too slow.

The product is laid on the picture averaged 2x2, and what it changes there is enlarged and added to
the picture itself, which so keeps its detail. A pixel that is more than two away from any that has
weight at half size keeps its byte.
"""

from collections.abc import Callable, Sequence

import cv2
import numpy as np
from makeup_video.kernels.planes import Rect
from makeup_video.pipeline.frames.affine import AffineArray

# Luma px of all rects of a frame. Below, less than a sixth of painting is saved, and it is seen
# more.
LARGE_PX = 30_000
TO_HALF: AffineArray = np.array([[0.5, 0, -0.25], [0, 0.5, -0.25]])  # px centres at whole numbers


class HalfSize:
    """The planes at half size, as far as they are asked for; kept from frame to frame."""

    def __init__(self) -> None:
        self._planes: tuple[np.ndarray, ...] = ()

    def paint(
        self,
        planes: tuple[np.ndarray, ...],
        rects: Sequence[Rect],
        block: tuple[int, int],
        max_code: int,
        paint: Callable[[tuple[np.ndarray, ...]], None],
    ) -> None:
        """Change `planes`, luma first, as `paint` changes what it is given: the same at half size.

        rects: of the planes at half size, where there is something to be painted.
        """
        self._make_room(planes)
        ours = [part for rect in rects for part in _parts(self._planes, rect, block)]
        theirs = [part for rect in rects for part in _parts(planes, _doubled(rect, planes), block)]
        for small, large in zip(ours, theirs, strict=True):
            small[:] = _halved(large)
        before = [small.astype(np.int16) for small in ours]
        paint(self._planes)
        for small, bare, large in zip(ours, before, theirs, strict=True):
            _add(large, np.subtract(small, bare, dtype=np.int16, casting="unsafe"), max_code)

    def _make_room(self, planes: tuple[np.ndarray, ...]) -> None:
        shapes = [(-(-p.shape[0] // 2), -(-p.shape[1] // 2), *p.shape[2:]) for p in planes]
        if [p.shape for p in self._planes] != shapes or self._planes[0].dtype != planes[0].dtype:
            self._planes = tuple(np.zeros(shape, planes[0].dtype) for shape in shapes)


def half_size(size_wh: tuple[int, int]) -> tuple[int, int]:
    """Of a picture; what is odd is rounded up."""
    return -(-size_wh[0] // 2), -(-size_wh[1] // 2)


def _doubled(rect: Rect, planes: tuple[np.ndarray, ...]) -> Rect:
    """The same in the picture itself, without what an odd size lacks."""
    high, wide = planes[0].shape
    x, y = 2 * rect.x, 2 * rect.y
    return Rect(x, y, min(2 * rect.width, wide - x), min(2 * rect.height, high - y))


def _parts(planes: tuple[np.ndarray, ...], rect: Rect, block: tuple[int, int]) -> list[np.ndarray]:
    """Views of a rect on every plane; NV12 keeps both colours in one."""
    across, down = block
    at = np.s_[
        rect.y // down : -(-(rect.y + rect.height) // down),
        rect.x // across : -(-(rect.x + rect.width) // across),
    ]
    return [rect.luma(planes), *(plane[at] for plane in planes[1:3])]


def _halved(part: np.ndarray) -> np.ndarray:
    """(H, W) or (H, W, 2) averaged 2x2; an odd last row or column is repeated."""
    high, wide = part.shape[:2]
    if high % 2 or wide % 2:
        part = cv2.copyMakeBorder(part, 0, high % 2, 0, wide % 2, cv2.BORDER_REPLICATE)
    return cv2.resize(part, half_size((wide, high)), interpolation=cv2.INTER_AREA)


def _add(part: np.ndarray, change: np.ndarray, max_code: int) -> None:
    """Enlarge a change, (h, w) int16, and add it to a part of a plane, in place."""
    high, wide = part.shape[:2]
    size = 2 * change.shape[1], 2 * change.shape[0]
    large = cv2.resize(change, size, interpolation=cv2.INTER_LINEAR)[:high, :wide]
    added = cv2.add(part, large, dtype=cv2.CV_8U if part.dtype == np.uint8 else cv2.CV_16U)
    part[:] = np.minimum(added, max_code) if part.dtype != np.uint8 else added
