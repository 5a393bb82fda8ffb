"""The lips' surface in numpy: the twin that kernels/surface.cl is tested against."""

from itertools import pairwise

import cv2
import numpy as np
from makeup_video.kernels.surface import (
    BETWEEN,
    CONTOUR_MOST,
    CONTOUR_SHARE,
    CORNER_FROM,
    CORNER_MORE,
    CORNER_TO,
    FULLER,
    FULLER_CHANGE,
    FURROW,
    FURROW_PER_PX,
    LEAST_SQUARE,
    LIMIT_STEEPNESS,
    LIPS_SIGMA_PX,
    LOWER_LESS,
    ONTO_LIP,
    OPENED,
    OPENING_REACH,
    OVER_SEAM,
    REACH,
    RIM_START,
    RING_POINTS,
    SEAM_SIGMA_PX,
    STEEPEST,
    WIDER,
)
from makeup_video.pipeline.faces.face import Face
from makeup_video.pipeline.faces.topology import LIPS
from makeup_video.pipeline.frames.affine import invert
from makeup_video.pipeline.frames.sampling import step_px
from makeup_video.pipeline.render.grid import Grid, slopes_along
from makeup_video.pipeline.render.luminance_twin import broad
from makeup_video.pipeline.render.surfaces.lips import (
    COARSE,
    LOWER,
    UPPER,
    LipsSurface,
    lip_place,
)


def lips_surface(face: Face) -> LipsSurface | None:
    """The lips of a face as a surface, in numpy: the twin of kernels/surface.cl. None when the
    mouth is hidden."""
    place = lip_place(face)
    if place is None:
        return None
    patch = face.lips
    height, width = patch.logits.shape
    to_patch = invert(patch.to_px)
    points = face.points_px[LIPS].astype(np.float64)
    px_per_patch = step_px(patch.to_px)
    xy = points[:, :2] @ to_patch[:, :2].T + to_patch[:, 2]
    xyz = np.column_stack([xy, points[:, 2] / px_per_patch])
    columns = np.arange(width)
    rows = np.arange(height, dtype=np.float32)[:, None]
    left, right = xyz[UPPER[0, [0, -1]], 0].tolist()
    y = _curves(xyz, columns)[:, ::3, 0]  # of the border and of the opening
    inside, within, limit, opening = _contours(y, rows, _border(xy, columns, rows), right - left)
    normals, upper = _normals(_curves(xyz, columns[::COARSE] + 0.5), rows[::COARSE] + 0.5)
    odds = np.float32(1 - CONTOUR_SHARE) * patch.logits
    odds += np.float32(CONTOUR_SHARE) * np.clip(inside, -CONTOUR_MOST, CONTOUR_MOST)
    odds += np.float32(WIDER) * (opening <= 0)
    odds += _more(xyz, y, rows) * np.clip(1 - within, 0, 1)  # not in the opening itself
    np.minimum(odds, LIMIT_STEEPNESS * limit, out=odds)
    rim = np.where(opening > 0, ONTO_LIP, OVER_SEAM).astype(np.float32) * opening
    grid = Grid.at(place.to_px, upper.shape)
    return LipsSurface(face, grid, odds, rim, normals, upper)


def light_on_lips(surface: LipsSurface, luminance: np.ndarray) -> tuple[np.ndarray, float]:
    """Luminance on the grid -> the broad light on the grid, and its mean over the lips.

    Each lip is blurred alone: the upper lip is mostly in the shade, and beside it all of the lower
    lip would count as a highlight.
    """
    odds = cv2.resize(surface.odds, luminance.shape[::-1], interpolation=cv2.INTER_AREA)
    upper = (odds > 0) * surface.upper
    lower = (odds > 0) - upper
    (above, below), mean = broad(luminance, (upper, lower), LIPS_SIGMA_PX)
    return below + surface.upper * (above - below), mean


def _curves(xyz: np.ndarray, columns: np.ndarray) -> np.ndarray:
    """(2, 4, 2, C) float32: for upper and lower lip, each ring's y and z at every column."""
    points = xyz[np.concatenate([UPPER, LOWER])]
    x = np.maximum.accumulate(points[..., 0], axis=1)  # a face seen from the side folds its rings
    yz = points[..., 1] + 1j * points[..., 2]  # np.interp takes both at once
    curves = np.stack([np.interp(columns, *ring) for ring in zip(x, yz, strict=True)])
    return np.stack([curves.real, curves.imag], 1, dtype=np.float32).reshape(2, 4, 2, -1)


def _border(xy: np.ndarray, columns: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """(H, C): how far within the lips' border each px lies, negative outside.

    That is the distance to the nearest straight part of the border; the winding number tells the
    side. Beside a round mouth the border is upright, and no column shows how far away it is.

    xy: (N, 2), the points of the lips.
    """
    nearest = np.full((len(rows), len(columns)), 1e9, np.float32)
    winding = np.zeros(nearest.shape, np.int32)
    x, y = columns.astype(np.float32), rows
    for ring, turn in ((UPPER[0], 1), (LOWER[0], -1)):  # both run from left to right
        for (ax, ay), (bx, by) in pairwise(xy[ring].astype(np.float32).tolist()):
            right, down = bx - ax, by - ay
            beside, below = x - np.float32(ax), y - np.float32(ay)
            square = max(right * right + down * down, LEAST_SQUARE)
            along = np.clip((beside * right + below * down) / square, 0, 1)
            dx, dy = beside - right * along, below - down * along
            np.minimum(nearest, dx * dx + dy * dy, out=nearest)
            crosses = (below >= 0).astype(np.int32) - (below >= down)
            if down:
                winding += turn * crosses * (beside < below * (right / down))
    distance = np.sqrt(nearest)
    return np.where(winding != 0, distance, -distance)


def _contours(
    y: np.ndarray, rows: np.ndarray, border: np.ndarray, width: float
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """How far each px lies within the lips; within the opening; within the area that may be
    painted, which is larger than the lips since contours may be wrong; and `opening`.

    `opening` is the rim before it is scaled: 1 at an open mouth, -1 where shut lips meet, 0 at the
    outer border.
    y: (2, 2, C), of upper and lower lip, of border and opening.  border: the result of `_border`.
    width: of the mouth.
    """
    (top, upper), (bottom, lower) = y
    # at right angles to a contour, not down its column: otherwise a steep contour would be a stair
    slope = slopes_along(y[:, 1], 1)
    at_upper, at_lower = 1 / np.sqrt(1 + slope * slope)
    width = max(width, 1.0)
    within = np.minimum((rows - upper) * at_upper, (lower - rows) * at_lower)  # of the opening
    limit = np.minimum(border + REACH * width, OPENING_REACH * width - within)
    gap = np.clip((lower - upper) / (REACH * width), 0, 1)
    near = np.where(
        rows < 0.5 * (upper + lower),
        (rows - top) / np.maximum(upper - top, 1),
        (bottom - rows) / np.maximum(bottom - lower, 1),
    )
    opening = (2 * gap - 1) * np.clip(2 * near - RIM_START, 0, 1)
    return np.minimum(border, -within), within, limit, opening


def _more(xyz: np.ndarray, y: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Log-odds (H, C) that are added where the net is known to be wrong.

    The corners of an open mouth get more, and the lower lip of a shut one less: for the constants
    see kernels/surface.py. y: as for `_contours`.
    """
    left, right = xyz[UPPER[0, [0, -1]], 0]
    width = max(right - left, 1.0)
    gap = xyz[LOWER[3, RING_POINTS // 2], 1] - xyz[UPPER[3, RING_POINTS // 2], 1]
    opened = np.clip(gap / (OPENED * width), 0, 1)
    out_of_middle = np.abs(2 * np.arange(y.shape[-1]) - left - right) / width
    at_corner = np.clip((out_of_middle - CORNER_FROM) / (CORNER_TO - CORNER_FROM), 0, 1)
    corner = CORNER_MORE * at_corner * opened
    lower = corner - LOWER_LESS * (1 - at_corner) * (1 - opened)
    more: np.ndarray = np.where(rows < 0.5 * (y[0, 1] + y[1, 1]), corner, lower)
    return more.astype(np.float32)


def _normals(curves: np.ndarray, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(3, rows, columns) float32: x and y of the unit normal towards the viewer, and `exposed`; and
    `upper`, see LipsSurface."""
    y, z = curves[:, :, 0], curves[:, :, 1]  # (2, 4, C)
    down = _at_least_half(y[:, 1:] - y[:, :-1])
    slopes = np.clip((z[:, 1:] - z[:, :-1]) / down, -STEEPEST, STEEPEST)
    middle = 0.5 * (curves[:, 1] + curves[:, 2])  # (2, 2, C), y and z
    bends = np.concatenate([slopes, slopes_along(middle, COARSE)], axis=1)
    bends = cv2.blur(bends.reshape(10, -1), (7, 1)).reshape(2, 5, 1, -1)
    first, last = y[:, 0, None], y[:, 3, None]
    across = np.clip((rows - first) / _at_least_half(last - first), 0, 1)
    # in parts of a px: otherwise the line would be a stair whose steps jump as the mouth moves
    upper = np.clip((0.5 * (y[0, 3] + y[1, 3]) - rows) * (1 / COARSE) + 0.5, 0, 1)
    gx, gy = np.where(upper > 0.5, *_slopes(across, bends).swapaxes(0, 1))
    # blurred: otherwise the slope would jump where the lips meet, which would be seen as steps
    gx, gy = (cv2.GaussianBlur(slope, (0, 0), SEAM_SIGMA_PX) for slope in (gx, gy))
    length = np.sqrt(1 + gx * gx + gy * gy)
    apart = np.abs(0.5 * (y[0, 3] + y[1, 3]) - rows)
    exposed = np.clip(FURROW_PER_PX * apart - FURROW, 0, 1)
    return np.stack([gx / length, gy / length, exposed]), upper


def _at_least_half(length: np.ndarray) -> np.ndarray:
    """Each length with its sign, at least 0.5 away from 0."""
    far: np.ndarray = np.copysign(np.maximum(np.abs(length), np.float32(0.5)), length)
    return far


def _slopes(across: np.ndarray, bends: np.ndarray) -> np.ndarray:
    """(2, 2, rows, columns): dz/dx and dz/dy of both lips, from the slopes between the rings and
    along them."""
    first, middle, last = BETWEEN
    outer, inner = bends[:, 1] - bends[:, 0], bends[:, 2] - bends[:, 1]
    down = np.where(
        across < middle,
        bends[:, 0] + outer * ((across - first) / (middle - first)),
        bends[:, 1] + inner * ((across - middle) / (last - middle)),
    )
    border, change = np.array([FULLER, FULLER_CHANGE], np.float32)[..., None, None]
    down += border + change * across
    down = np.clip(down, -STEEPEST, STEEPEST)
    along, tilt = bends[:, 4], bends[:, 3]
    return np.stack([np.clip(along - 0.5 * down * tilt, -STEEPEST, STEEPEST), down])
