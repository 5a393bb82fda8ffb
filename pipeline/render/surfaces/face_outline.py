"""Which places of a grid lie on the face: eyeshadow of a turned head must not reach the wall."""

from collections.abc import Sequence

import cv2
import numpy as np
from makeup_video.pipeline.faces.face import Face
from makeup_video.pipeline.frames.affine import invert
from makeup_video.pipeline.render.grid import Grid
from makeup_video.pipeline.render.surfaces.face import EIGHTH_BITS, OUTLINE

_FEATHER = 2  # px of the grid, inwards
_MARGIN = 2 * _FEATHER + 1  # px drawn beyond the grid, so that its border is not feathered


def parts_on_face(face: Face, grids: Sequence[Grid | None]) -> list[np.ndarray | None]:
    """`within_outline` of each grid; None also where there is no grid."""
    outline = outline_of(face)
    return [None if grid is None else within_outline(outline, grid) for grid in grids]


def outline_of(face: Face) -> np.ndarray:
    """(N, 2) float32, px of the frame: the convex outline of the face as it is seen."""
    hull: np.ndarray = cv2.convexHull(face.points_px[OUTLINE, :2].astype(np.float32))
    return hull[:, 0]


def within_outline(outline: np.ndarray, grid: Grid) -> np.ndarray | None:
    """(H, W) float32: 1 on the face and 0 beyond its outline, with a soft border on the face.

    None where all of the grid lies on the face.
    """
    to_grid, (wide, high) = invert(grid.to_px), grid.size_wh
    xy = outline @ to_grid[:, :2].T + to_grid[:, 2]
    near = np.clip(xy, -4 * wide, 5 * wide) + _MARGIN  # so that OpenCV takes all numbers
    corners = np.rint(near * 2**EIGHTH_BITS).astype(np.int32)
    inside = np.zeros((high + 2 * _MARGIN, wide + 2 * _MARGIN), np.uint8)
    cv2.fillConvexPoly(inside, corners, 255, cv2.LINE_AA, EIGHTH_BITS)
    if inside.min() == 255:
        return None
    side = 2 * _FEATHER + 1
    soft = cv2.blur(inside, (side, side))[_MARGIN:-_MARGIN, _MARGIN:-_MARGIN]
    share: np.ndarray = np.maximum(soft.astype(np.float32) * np.float32(2 / 255) - 1, 0)
    return share
