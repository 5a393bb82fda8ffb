"""The skin around the eyes as a surface: places for makeup that follow the eye and its blinks.

Each eye has a grid of its own, in widths of the eye: across from the side of the nose over the
inner (-0.5) and the outer corner (0.5) to the temple, and from above the brow to the cheek. The
other eye's grid is its mirror image. Its columns know the heights of the upper lash line (0), the
crease (1), the fold under the brow bone (LID_FOLD_UP) and the lower edge of the brow (2), and how
far each place lies from both lash lines. A closing lid moves the lash line only, and the lid grows
with it, as lids do.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import Any, ClassVar

import cv2
import numpy as np
from makeup_video.kernels.surface import (
    LID_CURVES,
    LID_FOLD_UP,
    LID_HW,
    LID_LEFT,
    LID_LIGHT_BESIDE,
    LID_LIGHT_FROM,
    LID_LIGHT_TO,
    LID_LIT,
    LID_SIGMA_PX,
    LID_STEP,
    RING_POINTS,
    FaceSurfaces,
    GridPlace,
)
from makeup_video.pipeline.faces.face import Face
from makeup_video.pipeline.faces.topology import BROW, EYE, RIGHT_BROW, RIGHT_EYE
from makeup_video.pipeline.frames.affine import AffineArray, compose
from makeup_video.pipeline.frames.sampling import step_px
from makeup_video.pipeline.render.grid import Grid, box_of
from makeup_video.pipeline.render.luminance import broad
from makeup_video.pipeline.render.regions.base import LitSurface, SeenFace
from makeup_video.pipeline.render.scene import SceneLight

SIZE_WH = LID_HW[::-1]
_TOP = -0.99  # the first row of the grid, in widths of the eye
# From the outer to the inner corner, as places in EYE: upper lashes, two rings, lower lashes.
_LASHES = np.array([0, 15, 14, 13, 12, 11, 10, 9, 8])
_CREASE = np.array([16, 25, 26, 27, 28, 29, 30, 31, 24])
_FOLD = np.array([32, 41, 42, 43, 44, 45, 46, 47, 40])
_LOWER_LASHES = np.arange(9)
_LASH_FEATHER, _LEAST_FEATHER_PX = 0.025, 1.2  # away from a lash line; the first in eye widths
_LIT = slice(8 * LID_LIT[0], 8 * LID_LIT[1])  # columns that light is read for
_FAINTEST = 1 / 512
_LID_TO_FACE = 0.75  # luminance of lids in even light: the brow shades them
_CORNERS = [10, 152, EYE[0], EYE[8], RIGHT_EYE[0], RIGHT_EYE[8]]  # forehead, chin; outer, inner
_NARROWEST_PX = 4
_CORNER = 0.5  # place of the corners of the eye, in its widths from its middle
# The same from the inner to the outer corner, as points of the face, with the brow's lower edge.
EYE_CURVES = tuple(
    tuple(
        curve[::-1] for curve in (eye[_LASHES], eye[_CREASE], eye[_FOLD], brow, eye[_LOWER_LASHES])
    )
    for eye, brow in ((EYE, BROW), (RIGHT_EYE, RIGHT_BROW))
)
# For the kernel: of both eyes, (10, RING_POINTS), filled up with zeros.
LID_RINGS = np.zeros((2 * LID_CURVES, RING_POINTS), np.int32)
for _ring, _curve in zip(LID_RINGS, (curve for eye in EYE_CURVES for curve in eye), strict=True):
    _ring[: len(_curve)] = _curve
COLUMNS = np.arange(SIZE_WH[0])
OUTWARDS = LID_LEFT + LID_STEP * COLUMNS


@dataclass(frozen=True, slots=True)
class Zone:
    """Where eye-shadow goes: it rises from the first to the second number, falls from the third to
    the fourth, upwards (lash line 0, crease 1, fold 2) and outwards (corners at -0.5 and 0.5)."""

    up: tuple[float, float, float, float]
    out: tuple[float, float, float, float]


ZONES = {
    "lid": Zone((-0.6, -0.5, 0.45, 1.40), (-0.58, -0.20, 0.38, 0.68)),
    "crease": Zone((0.30, 0.95, 1.05, 1.75), (-0.52, -0.10, 0.42, 0.76)),
    "full": Zone((-0.6, -0.5, 0.80, 2.50), (-0.60, -0.20, 0.42, 0.82)),
    "outer": Zone((-0.6, -0.5, 0.70, 1.90), (-0.15, 0.34, 0.48, 0.82)),
}


class ZoneWeights:
    """Weights of zones on all eyes of a face: made for all at once, and kept."""

    def __init__(self, up: np.ndarray) -> None:
        """up: (E, 32, 48), see LidSurface."""
        self._up = up
        self._found: dict[tuple[Zone, float], np.ndarray] = {}

    def weights(self, zone: Zone, softness: float) -> np.ndarray:
        """(E, 32, 48) float32: see zone_weight."""
        key = zone, softness
        if key not in self._found:
            wide = 0.5 + softness
            # the fold is 2 in zones, the crease 1 in both
            steeper = np.float32(1 / (LID_FOLD_UP - 1))
            ring = np.maximum(self._up, self._up * steeper + (1 - steeper))
            self._found[key] = _ramp(ring, zone.up, wide)
            self._found[key] *= _across(zone, wide)
        return self._found[key]


@dataclass(frozen=True, slots=True, eq=False)
class LidSurface:
    """The skin around one eye, ready to be painted; (32, 48) float32 on its grid.

    up: height above the upper lash line, 1 at the crease, LID_FOLD_UP at the fold under the brow
    bone, 2 at the lower edge of the brow.  lash_px, below_px: px of the frame above the upper and
    below the lower lash line; the eyeball is where both are negative.
    out: (48,), -0.5 to 0.5 between the corners, in widths of the eye.  width_px: that width, in px
    of the frame.
    normals: (2, 32, 48).  zones, number: the weights of all eyes of the face, and which it is.
    """

    grid: Grid
    up: np.ndarray
    lash_px: np.ndarray
    below_px: np.ndarray
    out: np.ndarray
    width_px: float
    normals: np.ndarray
    zones: "ZoneWeights"
    number: int
    spared: ClassVar[float] = 0.2  # lashes, brows, liner: see `material`

    def zone_weight(self, zone: Zone, softness: float) -> np.ndarray:
        """(32, 48) float32, 0 to 1: softness 0 halves the width of the borders, 1 is half as
        wide again."""
        weight: np.ndarray = self.zones.weights(zone, softness)[self.number]
        return weight

    def reach(self, softness: float, shape: Mapping[str, Any]) -> tuple[np.ndarray, np.ndarray]:
        """Lowest and highest px (x, y) of the frame with weight, and some more."""
        inside: np.ndarray = (self.zone_weight(ZONES[shape["zone"]], softness) > 0) & (
            self.lash_px > 0
        )
        return self.grid.box_px(box_of(inside), more=1)  # weights are interpolated

    def weigh(
        self, out: np.ndarray, origin_xy: tuple[int, int], softness: float, shape: Mapping[str, Any]
    ) -> None:
        """Fill (h, w) float32 with the weight of eye-shadow on the frame's pixels from
        origin_xy on."""
        # four channels, of which two are used: OpenCV is quick at one and at four
        maps = np.zeros((*self.up.shape, 4), np.float32)
        np.multiply(self.lash_px, 1 / self._feather_px(), out=maps[..., 0])
        maps[..., 1] = self.zone_weight(ZONES[shape["zone"]], softness)
        there = self._on_frame(maps, origin_xy, out.shape, (-1e3, 0))
        np.minimum(there[..., 0], 1, out=out)
        out *= there[..., 1]
        cv2.threshold(
            out, _FAINTEST, 0, cv2.THRESH_TOZERO, out
        )  # also removes what lies below the lashes

    def skin(self, out: np.ndarray, origin_xy: tuple[int, int]) -> None:
        """Fill (h, w) float32 on the frame's pixels from origin_xy on: 1 skin, 0 the eyeball.

        It rises away from each lash line, so that lashes at their roots and the tear duct stay
        clean. All is skin beyond the corners, and beyond the grid.
        """
        per_px = 1 / self._feather_px()
        maps = np.zeros((*self.up.shape, 4), np.float32)
        np.multiply(self.lash_px, per_px, out=maps[..., 0])
        np.multiply(self.below_px, per_px, out=maps[..., 1])
        maps[..., 2] = (np.abs(self.out) - _CORNER) * (self.width_px * per_px)
        there = self._on_frame(maps, origin_xy, out.shape, (1, 1, 1))
        np.maximum(there[..., 0], there[..., 1], out=out)
        np.maximum(out, there[..., 2], out=out)
        np.clip(out, 0, 1, out=out)

    def _feather_px(self) -> float:
        return max(_LASH_FEATHER * self.width_px, _LEAST_FEATHER_PX)

    def _on_frame(
        self,
        maps: np.ndarray,
        origin_xy: tuple[int, int],
        hw: tuple[int, ...],
        beyond: tuple[float, ...],
    ) -> np.ndarray:
        """(32, 48, 4) float32 on the grid -> (h, w, 4) on the frame's pixels from origin_xy on.

        beyond: the values outside the grid.
        """
        to_px = self.grid.to_px.copy()
        to_px[:, 2] -= origin_xy
        there: np.ndarray = cv2.warpAffine(
            maps, to_px, hw[::-1], borderMode=cv2.BORDER_CONSTANT, borderValue=beyond
        )
        return there

    def shaded(self, luminance: np.ndarray) -> tuple[np.ndarray, float]:
        """Luminance on the grid -> the broad light on the grid, and its mean over the lid.

        Also a twin of kernels/surface.cl.
        """
        is_lid = (self.up > LID_LIGHT_FROM) & (self.up < LID_LIGHT_TO)
        is_lid &= np.abs(self.out) < LID_LIGHT_BESIDE
        (light,), mean = broad(luminance, (is_lid,), LID_SIGMA_PX, _LIT)
        return light, mean

    def scaled(self, to_new: AffineArray) -> "LidSurface":
        """The same on a picture of another size."""
        grid, scale = Grid(compose(to_new, self.grid.to_px), self.grid.size_wh), step_px(to_new)
        return replace(
            self,
            grid=grid,
            lash_px=self.lash_px * np.float32(scale),
            below_px=self.below_px * np.float32(scale),
            width_px=self.width_px * scale,
        )


@lru_cache
def _across(zone: Zone, wide: float) -> np.ndarray:
    """(48,) float32: a zone's weight by column."""
    return _ramp(OUTWARDS, zone.out, wide).astype(np.float32)


def _ramp(at: np.ndarray, corners: tuple[float, float, float, float], wide: float) -> np.ndarray:
    """Smooth trapezoid: 0, up to 1 between the first two corners, down between the last two."""
    a, b, c, d = corners
    half, fall = (b - a) * wide / 2, (d - c) * wide / 2
    middle, end = (a + b) / 2, (c + d) / 2
    up = at * (0.5 / half) + (0.5 - middle * 0.5 / half)
    down = at * (-0.5 / fall) + (0.5 + end * 0.5 / fall)
    for side in (up, down):
        np.maximum(side, 0, out=side)
        np.minimum(side, 1, out=side)
    weight: np.ndarray = up * down
    weight *= weight
    for side in (up, down):
        side *= -2
        side += 3
        weight *= side
    return weight


class Eyes:
    """The region of eye-shadow: the lids of both eyes, which kernels/surface.cl makes."""

    def places(self, face: Face) -> list[GridPlace | None]:
        return eye_places(face)

    def surfaces(
        self, seen: SeenFace, places: Sequence[GridPlace | None]
    ) -> list[LitSurface | None]:
        made = seen.surfaces
        if made is None:
            return [None for _ in places]
        lids = zip(lid_surfaces_of(places, made), made.lids, made.means[1:], strict=True)
        return [None if surface is None else (surface, lid[2], mean) for surface, lid, mean in lids]

    def amount(self, face: Face) -> float:
        return 1.0

    def shade(self, light: SceneLight, mean: float) -> float:
        """Lids are skin: where they are darker than the face, that much less light falls on them.

        So shadow stays shadow in deep-set eyes, and behind sunglasses nothing shines.
        """
        if light.skin <= 0:
            return 1.0
        return min(max(mean / (_LID_TO_FACE * light.skin), 0.05), 1.0)


REGION = Eyes()


def eye_places(face: Face) -> list[GridPlace | None]:
    """Where the grids of both eyes lie; None for one too narrow to be seen (a face
    from the side)."""
    forehead, chin, left, left_inner, right, right_inner = face.points_px[_CORNERS, :2].tolist()
    up = forehead[0] - chin[0], forehead[1] - chin[1]
    return [_eye_place(left, left_inner, up), _eye_place(right, right_inner, up)]


def lid_surfaces_of(
    places: Sequence[GridPlace | None], made: FaceSurfaces
) -> list[LidSurface | None]:
    """The lids that kernels/surface.cl made."""
    zones = ZoneWeights(made.lids[:, 0])
    surfaces: list[LidSurface | None] = []
    for number, (place, lid) in enumerate(zip(places, made.lids, strict=True)):
        if place is None:
            surfaces.append(None)
            continue
        grid = Grid.at(place.to_px, LID_HW)
        width_px = grid.step_px() / LID_STEP
        up, lash_px, below_px = lid[0], lid[1], lid[5]
        surfaces.append(
            LidSurface(grid, up, lash_px, below_px, OUTWARDS, width_px, lid[3:5], zones, number)
        )
    return surfaces


def _eye_place(
    outer_xy: list[float], inner_xy: list[float], up_xy: tuple[float, float]
) -> GridPlace | None:
    """The place of one eye's grid; None when the eye is too narrow."""
    (x0, y0), (x1, y1) = outer_xy, inner_xy
    right, down = x0 - x1, y0 - y1
    if not math.hypot(right, down) >= _NARROWEST_PX:
        return None
    x, y = -down, right  # down the grid
    if x * up_xy[0] + y * up_xy[1] > 0:
        x, y = -x, -y
    to_px = (
        right * LID_STEP, x * LID_STEP, (x0 + x1) / 2 + right * LID_LEFT + x * _TOP,
        down * LID_STEP, y * LID_STEP, (y0 + y1) / 2 + down * LID_LEFT + y * _TOP,
    )  # fmt: skip
    return GridPlace(to_px, to_px)
