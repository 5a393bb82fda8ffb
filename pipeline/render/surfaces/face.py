"""The whole face as a surface: places for blush and highlighter that stick to the cheeks.

A square grid lies over the face, turned with the line of the eyes. Each node knows its place on the
mean face (`across`, `down`), so that a product that is described there once moves with every face.
It also knows how the face is turned there, whether the face is seen, and whether it is bare skin.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cache
from itertools import pairwise
from typing import ClassVar, NamedTuple

import cv2
import numpy as np
from makeup_video.kernels.colour import Coding
from makeup_video.kernels.face import (
    LOWEST,
    MARGIN,
    POINTS,
    SIDE,
    STEP,
    FaceKernel,
    FaceToRead,
)
from makeup_video.kernels.program import Device
from makeup_video.kernels.shares import FAINTEST
from makeup_video.kernels.surface import GridPlace
from makeup_video.pipeline.faces.face import Face
from makeup_video.pipeline.faces.topology import (
    EYE_CONTOUR,
    EYE_CORNERS,
    FACE_OVAL,
    LIPS_OUTER,
    RIGHT_EYE,
)
from makeup_video.pipeline.frames.affine import AffineArray, compose
from makeup_video.pipeline.frames.frame import Frame
from makeup_video.pipeline.look.kinds.fields import FaceFields
from makeup_video.pipeline.render.grid import Box, Grid, PointXY, box_of
from makeup_video.pipeline.render.lay_coats import lay_coats
from makeup_video.pipeline.render.light_planes import light_planes
from makeup_video.pipeline.render.surfaces.face_points import fit_points, fit_tables
from makeup_video.pipeline.render.surfaces.surface import Charts, Edge, Laid

_NARROWEST_PX = 8  # least distance of the outer eye corners as seen in the picture
EIGHTH_BITS = 3  # OpenCV takes corners of polygons in eighths of a px

# Closed contours of the parts of a face that are no bare skin.
_BROW = 70, 63, 105, 66, 107, 55, 65, 52, 53, 46
_OTHER_BROW = 300, 293, 334, 296, 336, 285, 295, 282, 283, 276
_NOSTRIL = 79, 239, 238, 20, 60, 75, 166
_OTHER_NOSTRIL = 309, 459, 458, 250, 290, 305, 392
_HOLES = [
    np.array(contour)
    for contour in (
        EYE_CONTOUR, RIGHT_EYE[: len(EYE_CONTOUR)], LIPS_OUTER,
        _BROW, _OTHER_BROW, _NOSTRIL, _OTHER_NOSTRIL,
    )
]  # fmt: skip
# Points whose convex hull is a face's outline: nose and mouth stick out of a turned face's oval.
OUTLINE = np.concatenate([FACE_OVAL, [1, 4, 5, 195, 197, 6, 0, 17, 37, 267, 98, 327, 50, 280]])
# All points that are drawn, and where each contour among them ends.
_DRAWN = np.concatenate([OUTLINE, *_HOLES])
_ENDS = np.cumsum([len(OUTLINE), *map(len, _HOLES)]).tolist()

# The chart covers more than can be painted of the mean face: IOD across and down; px for one IOD.
_CHARTED, _CHART_PX = ((-1.1, 1.1), (-0.6, 1.2)), np.float32(96)
_ACROSS, _DOWN = (np.arange(low, high, 1 / _CHART_PX, dtype=np.float32) for low, high in _CHARTED)
_CHART = FaceFields(_ACROSS[None, None], _DOWN[None, :, None])

_ACROSS_AND_DOWN = np.array((1, 1, 0), np.float32)
_HIDDEN_BELOW = 0.15  # when the mouth is hidden, skin is sampled where `down` is less than this


@dataclass(frozen=True, slots=True, eq=False)
class FaceSurface:
    """A face, ready to be painted; (40, 40) float32 on its grid.

    across: from the middle of the nose to the right in the picture of an upright face, in IOD of
    the mean face; -across is the mirror place.  down: from the line of the eye corners, in IOD.
    normals: (2, 40, 40), x and y of the unit normal, in the axes of the grid.
    facing: its z towards the viewer, 0..1.
    visible: 0..1, how far the face is seen and may be skin: 0 beyond its outline, where it turns
    away, and on eyes, brows, lips and nostrils.
    likeness: 0..1, how much it looks like this face's skin.
    laid, weights: results that are kept for the next frame of a resting face: laid coats by their
    charts and opacities; weights and their box by the `id` of the density. The density is kept with
    them, so that no other object gets its id.
    """

    grid: Grid
    across: np.ndarray
    down: np.ndarray
    normals: np.ndarray
    facing: np.ndarray
    visible: np.ndarray
    likeness: np.ndarray
    laid: dict[tuple[Charts, tuple[float, ...]], Laid] = field(default_factory=dict, repr=False)
    weights: dict[int, tuple[np.ndarray | None, np.ndarray, Box]] = field(
        default_factory=dict, repr=False
    )
    number: ClassVar[int] = 0
    is_broad: ClassVar[bool] = True
    READ: ClassVar = "across", "down", "normals", "facing", "visible", "likeness"  # from the kernel

    def sides(self) -> "list[FaceSurface]":
        return [self]

    def side_of(self, charts: Charts) -> "FaceSurface":
        return self

    def lay(self, charts: Charts, opacities: Sequence[float], device: Device) -> Laid:
        key = charts, tuple(opacities)
        if key not in self.laid:
            laid = lay_coats(self, charts, opacities)
            # the same array objects in every frame: `weights` has them by their ids
            self.laid[key] = laid._replace(density=list(laid.density))
        return self.laid[key]

    def join(self, on_sides: Sequence[np.ndarray]) -> np.ndarray:
        return on_sides[0]

    def fields(self) -> FaceFields:
        return FaceFields(self.across[None], self.down[None])

    @property
    def chart(self) -> FaceFields:
        return _CHART

    def charts_of(self, charts: Charts) -> Sequence[np.ndarray]:
        return [chart for chart in charts.on_sides if chart is not None]

    def on_chart(self) -> tuple[np.ndarray, np.ndarray]:
        (left, _), (top, _) = _CHARTED
        x, y = self.across - np.float32(left), self.down - np.float32(top)
        x *= _CHART_PX
        y *= _CHART_PX
        return x, y

    def reach(self, edge: Edge, density: np.ndarray | None) -> tuple[PointXY, PointXY]:
        """Lowest and highest px of the frame with weight, with a margin."""
        _, box = self._weight(density)
        return self.grid.box_px(box, more=1)  # weights are interpolated

    def weigh(
        self,
        out: np.ndarray,
        origin_xy: tuple[int, int],
        edge: Edge,
        density: np.ndarray | None,
    ) -> None:
        """Fill (h, w) float32 with the weight of a product on the frame's pixels from origin_xy on:
        only on what is seen and looks like skin."""
        weight, _ = self._weight(density)
        there = self.grid.warped(weight, origin_xy, out.shape, 0.0)
        cv2.threshold(there, FAINTEST, 0, cv2.THRESH_TOZERO, out)

    def scaled(self, to_new: AffineArray) -> "FaceSurface":
        """The surface on a picture of another size.  to_new: px of the frame -> px of it."""
        return self.on(Grid(compose(to_new, self.grid.to_px), self.grid.size_wh))

    def on(self, grid: Grid) -> "FaceSurface":
        """The surface at another place on the frame."""
        return FaceSurface(
            grid, self.across, self.down, self.normals, self.facing, self.visible, self.likeness,
            self.laid, self.weights,
        )  # fmt: skip

    def _weight(self, density: np.ndarray | None) -> tuple[np.ndarray, Box]:
        """The weight of a product on the grid, and the box around all weight."""
        if id(density) not in self.weights:
            weight: np.ndarray = self.visible * self.likeness
            if density is not None:
                weight *= density
            self.weights[id(density)] = density, weight, box_of(weight > FAINTEST)
        _, weight, box = self.weights[id(density)]
        return weight, box


class FaceOnGrid(NamedTuple):
    """The grid of a face, laid over it.

    points: (U, 3) float32, `used_points` in px of the grid; z, too, away from the viewer, but 0 for
    points that are only drawn.
    middle_xy: the grid's middle, in px of the grid from the middle between the eye corners.
    """

    place: GridPlace
    grid: Grid
    points: np.ndarray
    middle_xy: PointXY


# A surface, the broad light on its grid, and that light's mean over the cheeks: see LitSurface.
LitFace = tuple[FaceSurface, np.ndarray, float]


def face_on_grid(face: Face, middle_xy: PointXY | None = None) -> FaceOnGrid | None:
    """Lay the grid over a face. None for a face too small, from the side, or with points that are
    not finite.

    middle_xy: of the FaceOnGrid that the face already has; by default the grid's middle is that of
    the points.
    """
    (x0, y0, z0), (x1, y1, z1) = face.points_px.take(EYE_CORNERS, 0).tolist()
    right, down = x1 - x0, y1 - y0
    seen_px = math.hypot(right, down)
    iod_px = math.hypot(seen_px, z1 - z0)  # a turned face keeps its size
    if not _NARROWEST_PX <= seen_px <= iod_px < math.inf:
        return None
    step, x, y = STEP * iod_px, (x0 + x1) / 2, (y0 + y1) / 2
    a, b = right / seen_px / step, down / seen_px / step
    left, top = (SIDE - 1) / 2 - (a * x + b * y), (SIDE - 1) / 2 - (a * y - b * x)
    if middle_xy is not None:
        left, top = left - middle_xy[0], top - middle_xy[1]
    to_grid = np.array(((a, b, 0, left), (-b, a, 0, top), (0, 0, 1 / step, 0)))
    points: np.ndarray = cv2.transform(face.points_px.take(used_points(), 0)[None], to_grid)[0]
    if not cv2.checkRange(points)[0]:
        return None
    points[POINTS:, 2] = 0
    if middle_xy is None:
        low, high = points[:POINTS].min(0), points[:POINTS].max(0)
        off = (low + high - np.float32(SIDE - 1)) * (0.5 * _ACROSS_AND_DOWN)
        points -= off
        middle_xy = (float(off[0]), float(off[1]))
        left, top = left - middle_xy[0], top - middle_xy[1]
    a, b = a * step**2, b * step**2  # of the map back
    to_px = a, -b, b * top - a * left, b, a, -b * left - a * top
    grid = Grid.at(to_px, (SIDE, SIDE))
    return FaceOnGrid(GridPlace(to_px, to_px), grid, points, middle_xy)


def face_surface(face: Face, frame: Frame, coding: Coding, kernel: FaceKernel) -> LitFace | None:
    """The surface of a face, the broad light on its grid, and that light's mean over the cheeks.
    None where `face_on_grid` has none."""
    at = face_on_grid(face)
    return None if at is None else surface_at(at, face, frame, coding, kernel)


def surface_at(
    at: FaceOnGrid, face: Face, frame: Frame, coding: Coding, kernel: FaceKernel
) -> LitFace:
    """`face_surface` of a face over which the grid is laid already."""
    frame_wh = frame.width_px, frame.height_px
    inside, holes = drawn(at.points)
    given = FaceToRead(
        points_in_iod(at.points), inside, holes, at.place, frame_wh, sampled_down(face)
    )
    light = light_planes(frame, coding, [at.place], at.grid.corners_px(), around=0)
    made = kernel(given, light)
    surface = FaceSurface(at.grid, *(made[name] for name in FaceSurface.READ))
    return surface, made["shading"], float(made["mean"])


@cache
def used_points() -> np.ndarray:
    """All points that a surface depends on, as indices of points_px; `fit_points` come first."""
    return np.concatenate([fit_points(), _DRAWN])


def points_in_iod(on_grid: np.ndarray) -> np.ndarray:
    """The points of the fit in IOD, from the middle of the grid.

    on_grid: points of FaceOnGrid.
    """
    points: np.ndarray = on_grid[:POINTS] - np.float32((SIDE - 1) / 2) * _ACROSS_AND_DOWN
    points *= STEP
    return points


def drawn(on_grid: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The outline of a face, and its eyes, brows, lips and nostrils: `inside` and `holes` of
    FaceToRead.

    on_grid: points of FaceOnGrid.
    """
    near = on_grid[POINTS:, :2]
    near = np.clip(near, -SIDE, 2 * SIDE)  # so that no number is too large for OpenCV
    near += MARGIN
    near *= 2**EIGHTH_BITS
    corners = np.rint(near, out=near).astype(np.int32)
    wide = SIDE + 2 * MARGIN
    inside, holes = np.zeros((2, wide, wide), np.uint8)
    outline = cv2.convexHull(corners[: _ENDS[0]])
    cv2.fillConvexPoly(inside, outline, 255, cv2.LINE_AA, EIGHTH_BITS)
    contours = [corners[begin:end] for begin, end in pairwise(_ENDS)]
    cv2.fillPoly(holes, contours, 255, cv2.LINE_AA, EIGHTH_BITS)
    return inside, holes


def sampled_down(face: Face) -> float:
    """The skin is sampled where `down` is less than this: where a hand or a mask hides the mouth,
    the cheeks give no samples."""
    return _HIDDEN_BELOW + (LOWEST[0] - _HIDDEN_BELOW) * face.mouth_weight


def face_kernel(device: Device) -> FaceKernel:
    """The kernel that makes these surfaces on a device; made at the first call."""
    return device.once(_new_kernel)


def _new_kernel(device: Device) -> FaceKernel:
    return FaceKernel(device, fit_tables())
