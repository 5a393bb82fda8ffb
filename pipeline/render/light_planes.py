"""The small part of a frame that the light on a surface is read from."""

import math
from collections.abc import Sequence

import cv2
import numpy as np
from makeup_video.kernels.colour import Coding
from makeup_video.kernels.light import LightPlanes, Stretch
from makeup_video.kernels.surface import GridPlace
from makeup_video.pipeline.frames.frame import Frame
from makeup_video.pipeline.frames.sampling import halved

_AROUND = 0.08  # share of the points' extent; light farther away counts for nothing


def light_planes(
    frame: Frame,
    coding: Coding,
    places: Sequence[GridPlace],
    points_px: list[list[float]],
    around: float = _AROUND,
) -> LightPlanes:
    """The part of a frame's planes around some points (x, y, z), from which grids read light.

    Planes more than twice as fine as the grids are averaged, 2x2, 4x4, ...
    around: the margin around the points, as a share of their extent.
    """
    x, y, _ = zip(*points_px, strict=True)
    x0, y0, x1, y1 = min(x), min(y), max(x), max(y)
    more = around * max(x1 - x0, y1 - y0)
    lows, highs = (x0 - more, y0 - more), (x1 + more, y1 + more)
    step = max(abs(a * e - b * d) ** 0.5 for a, b, _, d, e, _ in (p.to_px for p in places))
    planes, chroma = frame.planes, frame.chroma
    (luma,), to_luma = _near(planes[:1], lows, highs, (1, 1), step)
    if len(planes) < 2:
        return LightPlanes((luma, luma, luma), to_luma, to_luma, coding, has_colour=False)
    both, to_chroma = _near(planes[1:3], lows, highs, chroma, step)
    cb, cr = both if len(both) == 2 else cv2.split(both[0])  # NV12 keeps both in one plane
    return LightPlanes((luma, cb, cr), to_luma, to_chroma, coding)


def _near(
    planes: Sequence[np.ndarray],
    low_xy: tuple[float, float],
    high_xy: tuple[float, float],
    chroma: tuple[int, int],
    step: float,
) -> tuple[list[np.ndarray], Stretch]:
    """A part of planes of the same size, and the map from px of the frame to px of that part.

    The part reaches from low_xy to high_xy, px of the frame. It is averaged where the grids' step,
    px of the frame, is large.  chroma: px of the frame for one px of the planes.
    """
    high, wide = planes[0].shape[:2]
    step /= math.sqrt(chroma[0] * chroma[1])
    size = 1
    while step > 2 * size and 4 * size <= min(wide, high):
        size *= 2
    left, right, to_x = _span(low_xy[0], high_xy[0], chroma[0], size, wide)
    top, bottom, to_y = _span(low_xy[1], high_xy[1], chroma[1], size, high)
    parts = [halved(plane[top:bottom, left:right], size) for plane in planes]
    if min(wide, high) < 2:  # LightPlanes are at least 2x2
        parts = [cv2.copyMakeBorder(part, 0, 1, 0, 1, cv2.BORDER_REPLICATE) for part in parts]
    return parts, (*to_x, *to_y)


def _span(
    low: float, high: float, share: int, size: int, length: int
) -> tuple[int, int, tuple[float, float]]:
    """Where the px of a plane around low..high px of a frame begin and end, and the map to boxes.

    The span is made of whole boxes of `size` px, so that averages do not shift with the face. The
    map leads from px of the frame to boxes.  share: px of the frame for one px of the plane.
    """
    scale, last = 1 / (share * size), length // size - 1
    first = min(max(int(low * scale) - 2, 0), max(last - 1, 0))
    end = min(max(int(high * scale) + 3, first + 2), last + 1)
    return first * size, end * size, (scale, 0.5 * scale - 0.5 - first)
