"""The lips of a face as a surface: where lipstick goes, the shape, the broad light.

All of it lives on the grid of the face's lip patch, which is turned with the face. The lips are
cut into columns; each has four contour points and the depths of the mesh's four rings.
"""

from dataclasses import dataclass
from typing import ClassVar

import cv2
import numpy as np
from makeup_video.pipeline.crop import compose
from makeup_video.pipeline.face import Face
from makeup_video.pipeline.shading import Grid
from makeup_video.pipeline.topology import LIPS

COARSE = 2  # px of the patch to one of the grid of shape and light
SHADING_SIGMA = 2.5  # of that grid: what is finer is texture
# The mesh's rings from border to opening, each from corner to corner, as places in LIPS.
_RINGS = (0, 40, 60, 20)
_LOWER = np.array([[ring + i for i in range(11)] for ring in _RINGS])
_UPPER = np.array([[ring, *range(ring + 11, ring + 20), ring + 10] for ring in _RINGS])
# Between the rings, from border (0) to opening (1), where their slopes hold.
_BETWEEN = (0.19, 0.57, 0.88)
# Lips are fuller than the mesh: added to the slope at the border, and on the way to the opening.
_FULLER_UPPER = (-0.30, 0.75)
_FULLER_LOWER = (0.45, -1.0)
_STEEPEST = 2.5
_REACH = 0.06  # of the mouth's width: the mask is trusted so far beyond the contours
_ODDS_PER_PX = 1.1  # the mask's steepness at the border: median over photos
_LIMIT_STEEPNESS = 3.0  # odds for a px beyond the contours' reach
# Half the width of the edge: px of the patch at softness 0 and what 1 adds; least px of the frame.
_FEATHER_PX, _FEATHER_MORE_PX, _FEATHER_LEAST_PX = 0.6, 4.0, 0.7
_INWARD = 0.5  # of that half: how far the edge is drawn back at an open mouth


@dataclass(frozen=True, slots=True, eq=False)
class LipRegion:
    """Lips, ready to be painted; (H, W) float32 on the patch, (H/2, W/2) on the coarse grid.

    odds: (H, W) log-odds of lipstick, limited to the contours' neighbourhood.  opening: (H, W),
    1 at the rim of an open mouth, 0 at the outer border.  normals: (2, H/2, W/2), x and y.
    shading, mean: see `light_up`.  corners_xy: (2, 2) lowest and highest px it may reach.
    """

    face: Face
    odds: np.ndarray
    opening: np.ndarray
    normals: np.ndarray
    corners_xy: np.ndarray
    spares_dark: ClassVar[bool] = False

    @property
    def grid(self) -> Grid:
        """Where `shading` and `normals` lie on the frame."""
        height, width = self.normals.shape[1:]
        return Grid(compose(self.face.lips.to_px, _COARSE_TO_PATCH), (width, height))

    def reach(self, softness: float, zone: str) -> tuple[np.ndarray, np.ndarray]:
        """Lowest and highest px (x, y) of the frame with weight, and some more."""
        return self.corners_xy[0], self.corners_xy[1]

    def weigh(
        self, out: np.ndarray, origin_xy: tuple[int, int], softness: float, zone: str
    ) -> None:
        """Fill (h, w) float32 with the weight of lipstick on the frame's pixels from origin_xy on.

        1 on the lips, 0 beyond their edge. At an open mouth the edge is drawn back onto the lips.
        """
        to_px = self.face.lips.to_px.copy()
        scale = abs(np.linalg.det(to_px[:, :2])) ** 0.5
        to_px[:, 2] -= origin_xy
        feather = max(_FEATHER_PX + _FEATHER_MORE_PX * softness**2, _FEATHER_LEAST_PX / scale)
        half = np.float32(feather * _ODDS_PER_PX)
        cv2.warpAffine(
            self.odds - _INWARD * half * self.opening, to_px, out.shape[::-1], out,
            flags=cv2.INTER_CUBIC if scale > 1.5 else cv2.INTER_LINEAR,
            borderMode=cv2.BORDER_CONSTANT, borderValue=-30,
        )  # fmt: skip
        out *= 0.5 / half
        out += 0.5
        np.clip(out, 0, 1, out)
        out *= out * (3 - 2 * out)

    def shading_weight(self) -> np.ndarray:
        """(H/2, W/2) float32: what counts as lips when their light is measured."""
        odds = cv2.resize(self.odds, self.normals.shape[:0:-1], interpolation=cv2.INTER_AREA)
        weight: np.ndarray = (odds > 0).astype(np.float32)
        return weight


_COARSE_TO_PATCH = np.array([[COARSE, 0, (COARSE - 1) / 2], [0, COARSE, (COARSE - 1) / 2]])


def lip_region(face: Face) -> LipRegion | None:
    """None when the mouth is hidden."""
    if face.mouth_weight <= 0:
        return None
    patch = face.lips
    height, width = patch.logits.shape
    to_patch = cv2.invertAffineTransform(patch.to_px)
    points = face.points_px[LIPS].astype(np.float64)
    px_per_patch = abs(np.linalg.det(patch.to_px[:, :2])) ** 0.5
    xy = points[:, :2] @ to_patch[:, :2].T + to_patch[:, 2]
    xyz = np.column_stack([xy, points[:, 2] / px_per_patch])
    columns = np.arange(width, dtype=np.float64)
    limits, opening = _limits(xyz, columns, np.arange(height, dtype=np.float32)[:, None])
    normals = _normals(
        xyz, columns[::COARSE] + 0.5, np.arange(height // COARSE)[:, None] * COARSE + 0.5
    )
    reach = 1.5 * _REACH * px_per_patch * np.ptp(xyz[:, 0])
    low, high = points[:, :2].min(0) - reach, points[:, :2].max(0) + reach
    odds = np.minimum(patch.logits, limits)
    return LipRegion(face, odds, opening, normals, np.stack([low, high]))


def _curve(xyz: np.ndarray, ring: np.ndarray, columns: np.ndarray, axis: int) -> np.ndarray:
    """y (1) or z (2) of a ring at every column."""
    points = xyz[ring]
    x = np.maximum.accumulate(points[:, 0])  # a face seen from the side folds its rings
    return np.interp(columns, x, points[:, axis])


def _limits(
    xyz: np.ndarray, columns: np.ndarray, rows: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Odds that the mask may not exceed, and how near the opening of the mouth is."""
    top, upper = (_curve(xyz, _UPPER[i], columns, 1).astype(np.float32) for i in (0, 3))
    bottom, lower = (_curve(xyz, _LOWER[i], columns, 1).astype(np.float32) for i in (0, 3))
    left, right = xyz[_UPPER[0][[0, -1]], 0]
    reach = np.float32(_REACH * max(right - left, 1.0))
    beside = np.minimum(columns - left, right - columns).astype(np.float32)
    inside = np.minimum(np.minimum(rows - top, bottom - rows), beside)
    within = np.minimum(rows - upper, lower - rows)  # of the opening
    limits = np.float32(_LIMIT_STEEPNESS) * (np.minimum(inside, -within) + reach)
    gap = np.clip((lower - upper) / reach, 0, 1)
    near = np.where(
        rows < 0.5 * (upper + lower),
        (rows - top) / np.maximum(upper - top, 1),
        (bottom - rows) / np.maximum(bottom - lower, 1),
    )
    return limits, gap * np.clip(2 * near - 0.8, 0, 1)


def _normals(xyz: np.ndarray, columns: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """(2, rows, columns) float32: x and y of the unit normal towards the viewer."""
    sides = []
    for rings, fuller in ((_UPPER, _FULLER_UPPER), (_LOWER, _FULLER_LOWER)):
        y = np.stack([_curve(xyz, ring, columns, 1) for ring in rings])
        z = np.stack([_curve(xyz, ring, columns, 2) for ring in rings])
        down = np.diff(y, axis=0)
        down = np.where(down < 0, np.minimum(down, -0.5), np.maximum(down, 0.5))
        slopes = cv2.blur(np.clip(np.diff(z, axis=0) / down, -_STEEPEST, _STEEPEST), (7, 1))
        along = cv2.blur(np.gradient(z[1:3].mean(0), columns)[None], (7, 1))[0]
        tilt = cv2.blur(np.gradient(y[1:3].mean(0), columns)[None], (7, 1))[0]
        across = (rows - y[0]) / np.where(
            np.abs(y[3] - y[0]) < 0.5, np.copysign(0.5, y[3] - y[0]), y[3] - y[0]
        )
        sides.append(_slopes(np.clip(across, 0, 1), slopes, along, tilt, fuller))
    upper_ends = _curve(xyz, _UPPER[3], columns, 1) + _curve(xyz, _LOWER[3], columns, 1)
    gx, gy = np.where(2 * rows < upper_ends, sides[0], sides[1])
    length = np.sqrt(1 + gx * gx + gy * gy)
    return np.stack([gx / length, gy / length]).astype(np.float32)


def _slopes(
    across: np.ndarray,
    slopes: np.ndarray,
    along: np.ndarray,
    tilt: np.ndarray,
    fuller: tuple[float, float],
) -> tuple[np.ndarray, np.ndarray]:
    """dz/dx and dz/dy, from those between the rings and along them."""
    first, middle, last = _BETWEEN
    outer = slopes[0] + (slopes[1] - slopes[0]) * ((across - first) / (middle - first))
    inner = slopes[1] + (slopes[2] - slopes[1]) * ((across - middle) / (last - middle))
    down = np.where(across < middle, outer, inner) + fuller[0] + fuller[1] * across
    down = np.clip(down, -_STEEPEST, _STEEPEST)
    return np.clip(along - 0.5 * down * tilt, -_STEEPEST, _STEEPEST), down
