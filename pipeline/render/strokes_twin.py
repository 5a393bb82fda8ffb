"""Lines between two borders, drawn on the pixels of the frame: the twin of kernels/strokes.cl."""

from collections.abc import Sequence

import cv2
import numpy as np
from makeup_video.pipeline.look.kinds.kind import Stroke
from makeup_video.pipeline.render.grid import Grid

_NOWHERE = -1e3  # px: how far places beyond the grid lie within a border, so no stroke lies there


def draw_strokes(
    out: np.ndarray,
    origin_xy: tuple[int, int],
    grid: Grid,
    strokes: Sequence[Stroke],
    blur_px: float,
    soft_px: float,
    share: float,
) -> None:
    """Fill (h, w) float32 with the coverage of strokes, 0..1, on the pixels from origin_xy on.

    Coverage is the share of a window, blur_px wide around a pixel, that lies between the borders.
    So a line thinner than a pixel is faint, and does not crawl. The lower border, which may be the
    lash line, fades over soft_px only.  strokes: (H, W) each.
    blur_px, soft_px: see Line.  share: px of the painted picture for one px of the frame.
    """
    for at in range(0, len(strokes), 2):  # two are warped at once
        first, second = strokes[at], strokes[min(at + 1, len(strokes) - 1)]
        maps = np.stack([first.above, first.below, second.above, second.below], axis=-1)
        if share != 1:
            maps *= np.float32(share)
        there = cv2.split(grid.warped(maps, origin_xy, out.shape, _NOWHERE))
        covered = _covered(there[0], there[1], blur_px, soft_px)
        if second is not first:
            np.maximum(covered, _covered(there[2], there[3], blur_px, soft_px), out=covered)
        np.maximum(out, covered, out=out) if at else np.copyto(out, covered)


def _covered(above: np.ndarray, below: np.ndarray, blur_px: float, soft_px: float) -> np.ndarray:
    """Coverage of one stroke.  above, below: see Stroke, px of the painted picture."""
    blur, soft = np.float32(blur_px), np.float32(soft_px)  # float32, as in the kernel
    half = np.float32(0.5) * blur
    covered: np.ndarray = np.minimum(above, half)
    covered += np.minimum(below, half)
    covered *= np.float32(1) / blur
    _to_share(covered)
    share = min(blur / soft - np.float32(1), np.float32(1))
    if share > 0:
        lower = _to_share(above * (np.float32(1) / soft) + np.float32(0.5))
        covered *= 1 + share * (lower - 1)
    return covered


def _to_share(numbers: np.ndarray) -> np.ndarray:
    """Limit numbers to 0..1, in place."""
    np.minimum(np.maximum(numbers, 0, out=numbers), 1, out=numbers)
    return numbers
