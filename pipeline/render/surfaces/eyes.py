"""The skin around the eyes as a surface: places for makeup that follow the eye and its blinks.

Each eye has a grid of its own, in widths of the eye: across from the side of the nose over the
inner (-0.5) and the outer corner (0.5) to the temple, and down from above the brow to the cheek.
The other eye's grid is its mirror image. Each place has a height: 0 on the upper lash line, 1 in
the crease, 1.5 in the fold under the brow bone, 2 on the lower edge of the brow. It also has its
distance from both lash lines. When a lid closes, only the lash line moves, and the lid grows with
it, as real lids do.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import partial, reduce
from typing import ClassVar

import cv2
import numpy as np
from makeup_video.kernels.program import Device
from makeup_video.kernels.shares import CHART_HEIGHT, CHART_ROWS, FAINTEST, ShareKernel
from makeup_video.kernels.surface import (
    LID_CURVES,
    LID_HW,
    LID_LEFT,
    LID_STEP,
    RING_POINTS,
    FaceSurfaces,
    GridPlace,
)
from makeup_video.pipeline.faces.face import Face
from makeup_video.pipeline.faces.topology import BROW, EYE, RIGHT_BROW, RIGHT_EYE
from makeup_video.pipeline.frames.affine import AffineArray, compose
from makeup_video.pipeline.frames.sampling import step_px
from makeup_video.pipeline.look.kinds import kind
from makeup_video.pipeline.look.kinds.fields import EyeChart, EyeFields
from makeup_video.pipeline.render.grid import Grid, PointXY, box_of
from makeup_video.pipeline.render.lay_coats import lay_coats
from makeup_video.pipeline.render.scene import FaceScene, FrameScene, Lit, SceneLight
from makeup_video.pipeline.render.softness import FADE_PER_SIGMA
from makeup_video.pipeline.render.surfaces.both_eyes import ACROSS, OUTWARDS, TOP, BothEyes
from makeup_video.pipeline.render.surfaces.face_outline import parts_on_face
from makeup_video.pipeline.render.surfaces.region import LitSurface, Reader, SeenFace
from makeup_video.pipeline.render.surfaces.surface import Charts, Edge, Laid
from makeup_video.pipeline.render.surfaces.unfolded import unfolded, upper_charts

# From the outer to the inner corner, as indices of EYE: upper lashes, two rings, lower lashes.
_LASHES = np.array([0, 15, 14, 13, 12, 11, 10, 9, 8])
_CREASE = np.array([16, 25, 26, 27, 28, 29, 30, 31, 24])
_FOLD = np.array([32, 41, 42, 43, 44, 45, 46, 47, 40])
_LOWER_LASHES = np.arange(9)
# The width of the edge at a lash line, in widths of the eye, and its least width in px.
_LASH_FEATHER, _LEAST_FEATHER_PX = 0.025, 1.2
_LID_TO_FACE = 0.75  # luminance of lids in even light: the brow shades them
# Log luminance of the skin under the eyes relative to the face's: behind dark glass, and unhidden.
_BEHIND_GLASS = -1.1, -0.6
_DEEP_SHADE = 2.2  # a lid darker than a fifth of the face lies in the shade, or behind glass
# Forehead, chin; outer and inner corners of both eyes.
_CORNERS = np.array([10, 152, EYE[0], EYE[8], RIGHT_EYE[0], RIGHT_EYE[8]])
NUMBERS = {kind.RIGHT_EYE: 0, kind.LEFT_EYE: 1}  # of the surfaces: EYE is the wearer's right one
_NARROWEST_PX = 4
# Pixels that are this close to squares count as squares; no pixels are longer than that.
_SQUARE, _MOST_ASPECT = 1e-6, 4.0
# How far, in widths of the eye, an open eye opens at least, and a shut one at most.
_OPEN = 0.07, 0.03
# The same curves from the inner to the outer corner, as points of the face, and the brow's lower
# edge; for both eyes.
EYE_CURVES = tuple(
    tuple(
        curve[::-1] for curve in (eye[_LASHES], eye[_CREASE], eye[_FOLD], brow, eye[_LOWER_LASHES])
    )
    for eye, brow in ((EYE, BROW), (RIGHT_EYE, RIGHT_BROW))
)
LASH_CURVE, FOLD_CURVE = 0, 2  # places in the curves of an eye
# The same for the kernel: (10, RING_POINTS), rows filled up with zeros.
LID_RINGS = np.zeros((2 * LID_CURVES, RING_POINTS), np.int32)
for _ring, _curve in zip(LID_RINGS, (curve for eye in EYE_CURVES for curve in eye), strict=True):
    _ring[: len(_curve)] = _curve
# By column: 0 between the corners of the eye, 1 from one column beyond them on.
_BEYOND = np.clip((np.abs(OUTWARDS) - 0.5) / LID_STEP, 0, 1).astype(np.float32)
# Charts: columns as on the grid; rows from the lash line to the height of the brow and more.
_HEIGHTS = np.arange(CHART_ROWS * CHART_HEIGHT + 1, dtype=np.float32)[None, :, None] / CHART_ROWS
_CHARTS = tuple(EyeChart(up > 0, ACROSS, up * _HEIGHTS) for up in (-1, 1))


@dataclass(frozen=True, slots=True, eq=False)
class LidSurface:
    """The skin around one eye, above it or below it, ready to be painted; float32 on its grid.

    up: (32, 48) height above the upper lash line, 1 at the crease, 1.5 at the fold under the brow
    bone, 2 at the lower edge of the brow.  lash_px, below_px: px of the frame above the upper and
    below the lower lash line; the eyeball is where both are negative.
    normals: (2, H, W).  width_px: of the eye.
    both: what both eyes of the face share.  number: which of these eyes it is.
    is_upper, is_lower: True for the skin above the eye, and for that below it.
    """

    grid: Grid
    up: np.ndarray
    lash_px: np.ndarray
    below_px: np.ndarray
    normals: np.ndarray
    width_px: float
    both: BothEyes
    number: int
    is_upper: bool = True
    is_lower: bool = False
    is_broad: ClassVar[bool] = False

    def _away_px(self) -> list[np.ndarray]:
        """Distance from the lash lines of this surface in px, negative on the eyeball."""
        sides = (self.is_upper, self.lash_px), (self.is_lower, self.below_px)
        return [away_px for is_here, away_px in sides if is_here]

    def sides(self) -> "list[LidSurface]":
        return [self, replace(self, is_upper=False, is_lower=True)]

    def side_of(self, charts: Charts) -> "LidSurface":
        sides = tuple([chart is not None for chart in charts.on_sides])
        if sides == (self.is_upper, self.is_lower):
            return self
        # several times as quick as `replace`
        return LidSurface(
            self.grid, self.up, self.lash_px, self.below_px, self.normals, self.width_px,
            self.both, self.number, *sides,
        )  # fmt: skip

    def lay(self, charts: Charts, opacities: Sequence[float], device: Device) -> Laid:
        upper, lower = charts.on_sides
        if len(opacities) == 1 and (upper is None or lower is None):
            return lay_coats(self, charts, opacities)  # as quick as the kernel
        kernel = device.once(ShareKernel)
        above = None if upper is None else partial(unfolded, upper)
        shares, seen, density = kernel(charts, (above, lower), opacities, self.both.to_lay)
        return Laid(shares if len(shares) else None, seen, density)

    def join(self, on_sides: Sequence[np.ndarray]) -> np.ndarray:
        return self.both.joined(*on_sides)

    @property
    def on_face(self) -> np.ndarray | None:
        """(H, W), 0 beyond the outline of the face; None for 1 everywhere."""
        return self.both.on_face[self.number]

    def fields(self) -> EyeFields:
        return self.both.upper if self.is_upper else self.both.lower

    @property
    def chart(self) -> EyeChart:
        return _CHARTS[self.is_upper]

    def charts_of(self, charts: Charts) -> Sequence[np.ndarray]:
        if self.is_upper and any(self.both.steps):
            return upper_charts(charts, self.both.steps)
        chart = charts.on_sides[1 - self.is_upper]
        assert chart is not None
        return [chart]

    def on_chart(self) -> tuple[np.ndarray, np.ndarray]:
        return self.both.on_chart(self.is_upper)

    def reach(self, edge: Edge, density: np.ndarray | None) -> tuple[PointXY, PointXY]:
        """Lowest and highest px of the frame with weight, with a margin."""
        # a pixel of skin is interpolated from places up to the diagonal of a step away
        _, over_px = self._feather(edge)
        beyond_px = 1.5 * self.grid.step_px() + over_px
        inside = reduce(np.maximum, self._away_px()) > -beyond_px
        if density is not None:
            inside &= density > 0
        return self.grid.box_px(box_of(inside), more=1)  # weights are interpolated

    def weigh(
        self,
        out: np.ndarray,
        origin_xy: tuple[int, int],
        edge: Edge,
        density: np.ndarray | None,
    ) -> None:
        """Fill (h, w) float32 with the weight of makeup on the frame's pixels from origin_xy on:
        on skin, and feathered at the lash line."""
        feather_px, over_px = self._feather(edge)
        covers = self._covered(feather_px, over_px) + np.float32(over_px / feather_px)
        lashes = [away_px * np.float32(1 / feather_px) + covers for away_px in self._away_px()]
        if density is None:
            density = np.ones(self.up.shape, np.float32)
        if (on_face := self.on_face) is not None:
            density = density * on_face
        if len(lashes) == 1:
            there = self.grid.warped(lashes[0], origin_xy, out.shape, -1e3)
            dense = self.grid.warped(density, origin_xy, out.shape, 0.0)
        else:
            # each side is warped alone: otherwise a nearly shut eye would close between two places
            # of the grid. OpenCV warps four channels at once in half the time of three one by one
            maps = cv2.merge([*lashes, density, density])
            warped = self.grid.warped(maps, origin_xy, out.shape, (-1e3, -1e3, 0.0, 0.0))
            there, dense = np.maximum(warped[..., 0], warped[..., 1]), warped[..., 2]
        np.minimum(there, 1, out=there)
        np.multiply(there, dense, out=out)
        # also removes the negative weights beyond the lash lines
        cv2.threshold(out, FAINTEST, 0, cv2.THRESH_TOZERO, out)

    def _feather(self, edge: Edge) -> tuple[float, float]:
        """The width of the edge at a lash line, and how far it reaches over the line because the
        picture is soft, in px. A blurred edge has its middle where a sharp edge has it."""
        sharp_px = max(_LASH_FEATHER * self.width_px, _LEAST_FEATHER_PX)
        feather_px = math.hypot(sharp_px, FADE_PER_SIGMA * edge.sigma_px)
        return feather_px, 0.5 * (feather_px - sharp_px)

    def _covered(self, feather_px: float, over_px: float) -> np.ndarray | np.float32:
        """Return what to add to the weight between the lash lines: by column, (48,) float32, or one
        number for all.

        A shut eye has no eyeball to be spared, and there is none beyond the corners. So a joined
        surface has no bare line beyond the corners, nor along the lashes of a nearly shut eye.
        """
        opened, (most, least) = self.both.opened[self.number], _OPEN
        shut = min(max((most - opened) / (most - least), 0.0), 1.0)
        if not (self.is_upper and self.is_lower):
            return np.float32(shut * (1 - 2 * over_px / feather_px))
        deepest_px = max(0.5 * opened * self.width_px, 0.0)
        share = np.float32(shut * (feather_px - over_px + deepest_px) / feather_px)
        covered: np.ndarray = np.maximum(_BEYOND, share)
        return covered

    def scaled(self, to_new: AffineArray) -> "LidSurface":
        """The surface on a picture of another size."""
        grid, share = Grid(compose(to_new, self.grid.to_px), self.grid.size_wh), step_px(to_new)
        return replace(
            self, grid=grid, width_px=self.width_px * share,
            lash_px=self.lash_px * np.float32(share), below_px=self.below_px * np.float32(share),
        )  # fmt: skip


class EyesRegion:
    """The skin around both eyes. Its surfaces come from kernels/surface.cl."""

    def places(self, face: Face) -> list[GridPlace | None]:
        return eye_places(face)

    def surfaces(
        self, seen: SeenFace, places: Sequence[GridPlace | None]
    ) -> list[LitSurface | None]:
        made = seen.surfaces
        if made is None:
            return [None for _ in places]
        lids = zip(lid_surfaces_of(seen.face, places, made), made.lids, made.means[1:], strict=True)
        return [None if surface is None else (surface, lid[2], mean) for surface, lid, mean in lids]

    def lit(self, item: FrameScene, scene: FaceScene, reader: Reader) -> tuple[Lit, ...]:
        return scene.regions.get("eyes", ())

    def amount(self, scene: FaceScene) -> float:
        """0 behind dark glasses, which darken the skin right under the eyes as well."""
        hidden, seen = _BEHIND_GLASS
        share = (math.log(scene.light.under_eyes) - hidden) / (seen - hidden)
        return min(max(share, 0.0), 1.0)

    def shade(self, light: SceneLight, mean: float) -> float:
        """Lids are skin: where they are darker than the face, less light falls on them.

        So deep-set eyes stay in shadow, and nothing shines behind sunglasses. But lashes, folds and
        pigment darken lids as well: only half of the difference, in logarithms, counts as shade.
        """
        if light.skin <= 0:
            return 1.0
        darker = min(max(mean / (_LID_TO_FACE * light.skin), 0.05), 1.0)
        return min(math.sqrt(darker), darker * _DEEP_SHADE)


EYES = EyesRegion()


def eye_places(face: Face) -> list[GridPlace | None]:
    """Where the grids of both eyes lie; None for an eye too narrow to be seen, as from the side."""
    corners = face.points_px.take(_CORNERS, 0)[:, :2].tolist()
    forehead, chin, left, left_inner, right, right_inner = corners
    up, aspect = (forehead[0] - chin[0], forehead[1] - chin[1]), _pixel_aspect(face)
    return [_eye_place(left, left_inner, up, aspect), _eye_place(right, right_inner, up, aspect)]


def _pixel_aspect(face: Face) -> float:
    """The width of a pixel divided by its height.

    The patch of the lips has square pixels in the picture as it is shown, whatever its turn.
    """
    (a, b, _), (c, d, _) = face.lips.to_px.tolist()
    across, down = math.hypot(a, b), math.hypot(c, d)
    aspect = down / across if across else 1.0
    is_usual = abs(aspect - 1) > _SQUARE and 1 / _MOST_ASPECT < aspect < _MOST_ASPECT
    return aspect if is_usual else 1.0


def lid_surfaces_of(
    face: Face, places: Sequence[GridPlace | None], made: FaceSurfaces
) -> list[LidSurface | None]:
    """The lids that kernels/surface.cl made."""
    grids = [None if place is None else Grid.at(place.to_px, LID_HW) for place in places]
    widths = [1.0 if grid is None else grid.step_px() / LID_STEP for grid in grids]
    heights = made.lids[:, 0], made.lids[:, 1], made.lids[:, 5]
    both = BothEyes(*heights, widths, partial(parts_on_face, face, grids))
    return [
        None
        if grid is None
        else LidSurface(grid, lid[0], lid[1], lid[5], lid[3:5], widths[number], both, number)
        for number, (grid, lid) in enumerate(zip(grids, made.lids, strict=True))
    ]


def _eye_place(
    outer_xy: list[float], inner_xy: list[float], up_xy: tuple[float, float], aspect: float
) -> GridPlace | None:
    """The place of one eye's grid; None when the eye is too narrow.  aspect: of the pixels."""
    (x0, y0), (x1, y1) = outer_xy, inner_xy
    right, down = x0 - x1, y0 - y1
    if not math.hypot(right, down) >= _NARROWEST_PX:
        return None
    x, y = -down / aspect, right * aspect  # down the grid
    if x * up_xy[0] + y * up_xy[1] > 0:
        x, y = -x, -y
    to_px = (
        right * LID_STEP, x * LID_STEP, (x0 + x1) / 2 + right * LID_LEFT + x * TOP,
        down * LID_STEP, y * LID_STEP, (y0 + y1) / 2 + down * LID_LEFT + y * TOP,
    )  # fmt: skip
    return GridPlace(to_px, to_px)
