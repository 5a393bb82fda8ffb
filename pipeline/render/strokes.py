"""Lines between two borders, as kernels/strokes.cl draws them on the pixels of the frame."""

from collections.abc import Sequence

import cv2
import numpy as np
from makeup_video.kernels.strokes import Line
from makeup_video.pipeline.look.kinds.kind import Stroke
from makeup_video.pipeline.render.grid import Grid
from makeup_video.pipeline.render.softness import FADE_PER_SIGMA


def fade_px(sigma_px: float) -> float:
    """The width over which a stroke's borders fade in a picture with this blur, px, at least 1."""
    return max(FADE_PER_SIGMA * sigma_px, 1.0)


def line_of(
    grid: Grid, strokes: Sequence[Stroke], blur_px: float, soft_px: float, share: float
) -> Line:
    """Strokes on a grid, (H, W) each, as the kernel takes them.

    blur_px, soft_px: see Line.  share: px of the painted picture for one px of the frame.
    """
    borders = [border for one in strokes for border in (one.above, one.below)]
    if len(strokes) % 2:  # the kernel takes strokes in pairs: an odd one stands twice
        borders += borders[-2:]
    merged = [cv2.merge(borders[at : at + 4]) for at in range(0, len(borders), 4)]
    maps: np.ndarray = merged[0][None] if len(merged) == 1 else np.stack(merged)
    if share != 1:
        maps *= np.float32(share)
    return Line(grid.to_px.ravel().tolist(), maps, blur_px, soft_px)


def box_of_strokes(strokes: Sequence[Stroke], blur_px: float) -> np.ndarray:
    """(N, H, W) bool: where on the grids a stroke or its blurred border may be seen."""
    there = [np.minimum(one.above, one.below) > -blur_px for one in strokes]
    seen: np.ndarray = there[0]
    for more in there[1:]:
        seen |= more
    return seen
