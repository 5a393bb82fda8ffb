"""The lips of a face as a surface: where lipstick goes, the shape, the broad light.

All of it lives on the grid of the face's lip patch, which is turned with the face. The lips are
cut into columns; each has four contour points and the depths of the mesh's four rings.
"""

from dataclasses import dataclass, field
from typing import ClassVar

import cv2
import numpy as np
from makeup_video.kernels.surface import LIPS_HW, FaceSurfaces, Place
from makeup_video.pipeline.crop import step_px
from makeup_video.pipeline.face import Face
from makeup_video.pipeline.shading import Box, Grid, box_of, broad, slopes_along
from makeup_video.pipeline.topology import LIPS

COARSE = 2  # px of the patch to one of the grid of shape and light
_SHADING_SIGMA = 2.5  # of that grid: what is finer is texture
# The mesh's rings from border to opening, each from corner to corner, as places in LIPS.
_RINGS = (0, 40, 60, 20)
_LOWER = np.array([[ring + i for i in range(11)] for ring in _RINGS])
_UPPER = np.array([[ring, *range(ring + 11, ring + 20), ring + 10] for ring in _RINGS])
# The same as points of the face, (8, 11): as kernels/surface.cl takes them.
LIP_RINGS = LIPS[np.concatenate([_UPPER, _LOWER])]
# Between the rings, from border (0) to opening (1), where their slopes hold.
_BETWEEN = (0.19, 0.57, 0.88)
# Lips are fuller than the mesh: added to the slope at the border, and on the way to the opening.
_FULLER = np.array([[-0.30, 0.45], [0.75, -1.0]], np.float32)[..., None, None]  # upper, lower
_STEEPEST = 2.5
_SEAM_SIGMA = 0.8  # px of the coarse grid
_REACH = 0.06  # of the mouth's width: the mask is trusted so far beyond the contours
_ODDS_PER_PX = 1.1  # the mask's steepness at the border: median over photos
_LIMIT_STEEPNESS = 3.0  # odds for a px beyond the contours' reach
# What the contours say is mixed in where the mask is not sure of itself, and both draw the border
# a little too tight.
_CONTOUR_SHARE, _CONTOUR_MOST = 0.25, 4.0
_WIDER = 0.25
# Half the width of the edge: px of the patch at softness 0 and what 1 adds; least px of the frame.
_FEATHER_PX, _FEATHER_MORE_PX, _FEATHER_LEAST_PX = 0.6, 4.0, 0.7
_BEYOND = -15.0  # beyond the patch: half the odds
_AROUND = 3  # px of the patch around what is seen
_OVER_SEAM = 0.3  # of that half: how far the edge is pushed over the line where shut lips meet


@dataclass(frozen=True, slots=True, eq=False)
class LipRegion:
    """Lips, ready to be painted; (H, W) float32 on the patch, (H/2, W/2) on the coarse grid.

    grid: where the coarse grid lies on the frame.  odds: (H, W) log-odds of lipstick, limited to the
    contours' neighbourhood.  rim: (H, W), by how many half widths of the edge it is pushed inwards: 1
    at the rim of an open mouth, -0.3 where shut lips meet, 0 at the outer border.
    normals: (2, H/2, W/2), x and y.
    upper: (H/2, W/2) share of each px that lies above the line where the lips meet.
    boxes: of the patch, where weight was found by softness.
    """

    face: Face
    grid: Grid
    odds: np.ndarray
    rim: np.ndarray
    normals: np.ndarray
    upper: np.ndarray
    boxes: dict[float, Box] = field(default_factory=dict, repr=False)
    spared: ClassVar[float] = 0.17  # the dark of the mouth: see `material`

    def reach(self, softness: float, zone: str) -> tuple[np.ndarray, np.ndarray]:
        """Lowest and highest px (x, y) of the frame with weight, and some more."""
        patch = Grid(self.face.lips.to_px, self.odds.shape[::-1])
        return patch.box_px(self._box(softness), more=2)  # weights are interpolated

    def weigh(
        self, out: np.ndarray, origin_xy: tuple[int, int], softness: float, zone: str
    ) -> None:
        """Fill (h, w) float32 with the weight of lipstick on the frame's pixels from origin_xy on.

        1 on the lips, 0 beyond their edge. At an open mouth all of the edge is on the lips, at a shut
        one it is pushed over the seam.
        """
        x, y, wide, high = self._box(softness)
        left, top = max(x - _AROUND, 0), max(y - _AROUND, 0)
        part = np.s_[top : y + high + _AROUND, left : x + wide + _AROUND]
        half = self._half_edge(softness)
        # 0 to 1 across the edge, whose middle lies at odds of half * rim
        edge = cv2.addWeighted(self.odds[part], 0.5 / half, self.rim[part], -0.5, 0.5)
        to_px = self.face.lips.to_px.copy()
        to_px[:, 2] += to_px[:, :2] @ (left, top) - origin_xy
        if step_px(to_px) > 1.5:
            # twice as fine by cubics, then linear: on large faces a third of the cost of cubics alone
            edge = cv2.resize(edge, None, fx=2, fy=2, interpolation=cv2.INTER_CUBIC)
            to_px[:, :2] /= 2
            to_px[:, 2] -= to_px[:, :2].sum(1) / 2
        cv2.warpAffine(
            edge, to_px, out.shape[::-1], out,
            borderMode=cv2.BORDER_CONSTANT, borderValue=_BEYOND / half,
        )  # fmt: skip
        np.maximum(out, 0, out=out)
        np.minimum(out, 1, out=out)
        rest = np.multiply(out, -2)
        rest += 3
        out *= out
        out *= rest

    def _box(self, softness: float) -> Box:
        """Of the patch, where there is weight."""
        if softness not in self.boxes:
            seen = self.odds > -(1 + _OVER_SEAM) * self._half_edge(softness)
            self.boxes[softness] = box_of(seen)
        return self.boxes[softness]

    def _half_edge(self, softness: float) -> float:
        """Odds from the middle of the edge to where it ends."""
        least_px = _FEATHER_LEAST_PX / step_px(self.face.lips.to_px)
        feather = max(_FEATHER_PX + _FEATHER_MORE_PX * softness**2, least_px)
        return feather * _ODDS_PER_PX

    def shaded(self, luminance: np.ndarray) -> tuple[np.ndarray, float]:
        """Luminance on the grid -> the broad light, alike, and its mean over the lips: a twin too.

        Each lip is blurred alone: the upper one is mostly in the shade, and would make a highlight
        of all the lower one.
        """
        odds = cv2.resize(self.odds, luminance.shape[::-1], interpolation=cv2.INTER_AREA)
        upper = (odds > 0) * self.upper
        lower = (odds > 0) - upper
        (above, below), mean = broad(luminance, (upper, lower), _SHADING_SIGMA)
        return below + self.upper * (above - below), mean


def lip_place(face: Face) -> Place | None:
    """Where the lips' coarse grid and patch lie; None when the mouth is hidden."""
    if face.mouth_weight <= 0:
        return None
    (a, b, left), (c, d, top) = face.lips.to_px.tolist()
    middle = (COARSE - 1) / 2
    coarse = (
        COARSE * a, COARSE * b, left + middle * (a + b),
        COARSE * c, COARSE * d, top + middle * (c + d),
    )  # fmt: skip
    return Place(coarse, (a, b, left, c, d, top))


def lip_region_of(face: Face, place: Place, made: FaceSurfaces) -> LipRegion:
    """The lips that kernels/surface.cl made."""
    grid = Grid.at(place.to_px, LIPS_HW)
    return LipRegion(face, grid, made.odds, made.rim, made.lips[1:3], made.lips[3])


def lip_region(face: Face) -> LipRegion | None:
    """The same in numpy, the twin of kernels/surface.cl. None when the mouth is hidden."""
    place = lip_place(face)
    if place is None:
        return None
    patch = face.lips
    height, width = patch.logits.shape
    to_patch = cv2.invertAffineTransform(patch.to_px)
    points = face.points_px[LIPS].astype(np.float64)
    px_per_patch = step_px(patch.to_px)
    xy = points[:, :2] @ to_patch[:, :2].T + to_patch[:, 2]
    xyz = np.column_stack([xy, points[:, 2] / px_per_patch])
    columns = np.arange(width)
    rows = np.arange(height, dtype=np.float32)[:, None]
    left, right = xyz[_UPPER[0, [0, -1]], 0].tolist()
    y = _curves(xyz, columns)[:, ::3, 0]  # of the border and of the opening
    inside, reach, opening = _contours(y, rows, left, right)
    normals, upper = _normals(_curves(xyz, columns[::COARSE] + 0.5), rows[::COARSE] + 0.5)
    odds = np.float32(1 - _CONTOUR_SHARE) * patch.logits
    odds += np.float32(_CONTOUR_SHARE) * np.clip(inside, -_CONTOUR_MOST, _CONTOUR_MOST)
    odds += np.float32(_WIDER) * (opening <= 0)
    np.minimum(odds, _LIMIT_STEEPNESS * (inside + reach), out=odds)
    rim = np.maximum(opening, _OVER_SEAM * opening)
    grid = Grid.at(place.to_px, upper.shape)
    return LipRegion(face, grid, odds, rim, normals, upper)


def _curves(xyz: np.ndarray, columns: np.ndarray) -> np.ndarray:
    """(2, 4, 2, C) float32: of the upper and the lower lip, each ring's y and z at every column."""
    points = xyz[np.concatenate([_UPPER, _LOWER])]
    x = np.maximum.accumulate(points[..., 0], axis=1)  # a face seen from the side folds its rings
    yz = points[..., 1] + 1j * points[..., 2]  # np.interp takes both at once
    curves = np.stack([np.interp(columns, *ring) for ring in zip(x, yz, strict=True)])
    return np.stack([curves.real, curves.imag], 1, dtype=np.float32).reshape(2, 4, 2, -1)


def _contours(
    y: np.ndarray, rows: np.ndarray, left: float, right: float
) -> tuple[np.ndarray, float, np.ndarray]:
    """How far within the contours each px lies, how far they may be off, and `opening`.

    y: (2, 2, C), of upper and lower lip, of border and opening.
    """
    (top, upper), (bottom, lower) = y
    # across a contour, not down its column: where it is steep that would make it a stair
    slope = slopes_along(y, 1)
    (at_top, at_upper), (at_bottom, at_lower) = 1 / np.sqrt(1 + slope * slope)
    columns = np.arange(y.shape[-1], dtype=np.float32)
    reach = _REACH * max(right - left, 1.0)
    beside = np.minimum(columns - np.float32(left), np.float32(right) - columns)
    inside = np.minimum(np.minimum((rows - top) * at_top, (bottom - rows) * at_bottom), beside)
    within = np.minimum((rows - upper) * at_upper, (lower - rows) * at_lower)  # of the opening
    gap = np.clip((lower - upper) / reach, 0, 1)
    near = np.where(
        rows < 0.5 * (upper + lower),
        (rows - top) / np.maximum(upper - top, 1),
        (bottom - rows) / np.maximum(bottom - lower, 1),
    )
    return np.minimum(inside, -within), reach, (2 * gap - 1) * np.clip(2 * near - 0.8, 0, 1)


def _normals(curves: np.ndarray, rows: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(2, rows, columns) float32: x and y of the unit normal towards the viewer; `upper`."""
    y, z = curves[:, :, 0], curves[:, :, 1]  # (2, 4, C)
    down = _at_least_half(y[:, 1:] - y[:, :-1])
    slopes = np.clip((z[:, 1:] - z[:, :-1]) / down, -_STEEPEST, _STEEPEST)
    middle = 0.5 * (curves[:, 1] + curves[:, 2])  # (2, 2, C), y and z
    bends = np.concatenate([slopes, slopes_along(middle, COARSE)], axis=1)
    bends = cv2.blur(bends.reshape(10, -1), (7, 1)).reshape(2, 5, 1, -1)
    first, last = y[:, 0, None], y[:, 3, None]
    across = np.clip((rows - first) / _at_least_half(last - first), 0, 1)
    # by parts of a px, or the line would be a stair whose steps jump as the mouth moves
    upper = np.clip((0.5 * (y[0, 3] + y[1, 3]) - rows) * (1 / COARSE) + 0.5, 0, 1)
    gx, gy = np.where(upper > 0.5, *_slopes(across, bends).swapaxes(0, 1))
    # where the lips meet the slope would jump, and be seen as steps
    gx, gy = (cv2.GaussianBlur(slope, (0, 0), _SEAM_SIGMA) for slope in (gx, gy))
    length = np.sqrt(1 + gx * gx + gy * gy)
    return np.stack([gx / length, gy / length]), upper


def _at_least_half(length: np.ndarray) -> np.ndarray:
    """With its sign."""
    far: np.ndarray = np.copysign(np.maximum(np.abs(length), np.float32(0.5)), length)
    return far


def _slopes(across: np.ndarray, bends: np.ndarray) -> np.ndarray:
    """(2, 2, rows, columns): dz/dx and dz/dy of both lips, from those between the rings and along them."""
    first, middle, last = _BETWEEN
    outer, inner = bends[:, 1] - bends[:, 0], bends[:, 2] - bends[:, 1]
    down = np.where(
        across < middle,
        bends[:, 0] + outer * ((across - first) / (middle - first)),
        bends[:, 1] + inner * ((across - middle) / (last - middle)),
    )
    down += _FULLER[0] + _FULLER[1] * across
    down = np.clip(down, -_STEEPEST, _STEEPEST)
    along, tilt = bends[:, 4], bends[:, 3]
    return np.stack([np.clip(along - 0.5 * down * tilt, -_STEEPEST, _STEEPEST), down])
