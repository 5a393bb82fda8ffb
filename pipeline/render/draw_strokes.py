"""Lines between two borders, drawn on the pixels of the frame."""

from collections.abc import Sequence

import cv2
import numpy as np
from makeup_video.pipeline.look.kinds.kind import Stroke
from makeup_video.pipeline.render.grid import Grid

_NOWHERE = -1e3  # px from a border, beyond the grid


def draw_strokes(
    out: np.ndarray,
    origin_xy: tuple[int, int],
    grid: Grid,
    strokes: Sequence[Stroke],
    blur_px: float,
    share: float,
) -> None:
    """Fill (h, w) float32 with the coverage of strokes, 0..1, on the pixels from origin_xy on.

    Coverage is the share of a window, blur_px wide around a pixel, that lies between the borders: a
    line that is thinner than a pixel is faint, and does not crawl. A wider window smudges the upper
    border alone, since the lower one may be the lash line.  strokes: (H, W) each.
    blur_px: in px of this picture.  share: px of this picture for one of the frame.
    """
    for number, (first, second) in enumerate(
        zip(strokes[::2], [*strokes[1::2], None], strict=False)
    ):
        two = first if second is None else second
        maps = np.stack([first.above, first.below, two.above, two.below], axis=-1)
        maps *= np.float32(share)
        there = grid.warped(maps, origin_xy, out.shape, _NOWHERE)
        above, below, other_above, other_below = cv2.split(there)
        covered = _covered(above, below, blur_px)
        if second is not None:
            np.maximum(covered, _covered(other_above, other_below, blur_px), out=covered)
        if number:
            np.maximum(out, covered, out=out)
        else:
            out[:] = covered


def _covered(above: np.ndarray, below: np.ndarray, blur_px: float) -> np.ndarray:
    """Coverage of one stroke by the distances from its borders, px."""
    half = 0.5 * blur_px
    covered: np.ndarray = np.minimum(above, half)
    covered += np.minimum(below, half)
    covered *= 1 / blur_px
    _to_share(covered)
    if blur_px > 1:
        covered *= _to_share(above + np.float32(0.5))
    return covered


def _to_share(numbers: np.ndarray) -> np.ndarray:
    """Limit numbers to 0..1, in place."""
    np.minimum(np.maximum(numbers, 0, out=numbers), 1, out=numbers)
    return numbers


def box_of_strokes(strokes: Sequence[Stroke], blur_px: float) -> np.ndarray:
    """(N, H, W) bool: all places of the grids from which a stroke may be seen."""
    there = [np.minimum(one.above, one.below) > -blur_px for one in strokes]
    seen: np.ndarray = there[0]
    for more in there[1:]:
        seen |= more
    return seen
