"""The lips of a face as a surface: where lipstick goes, the shape, the broad light.

All arrays lie on the face's lip patch, which is turned with the face, or on a coarser grid there.
The lips are cut into columns; each has four contour points and the depths of the mesh's four rings.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from typing import ClassVar

import cv2
import numpy as np
from makeup_video.kernels.program import Device
from makeup_video.kernels.surface import (
    LIPS_HW,
    ONTO_LIP,
    OVER_SEAM,
    FaceSurfaces,
    GridPlace,
)
from makeup_video.pipeline.faces.face import Face, moved
from makeup_video.pipeline.faces.topology import LIPS, LIPS_INNER, LIPS_OUTER
from makeup_video.pipeline.frames.affine import Affine, AffineArray, compose, invert
from makeup_video.pipeline.frames.sampling import step_px
from makeup_video.pipeline.look.kinds.fields import LipsFields
from makeup_video.pipeline.render.grid import Box, Grid, PointXY, box_of
from makeup_video.pipeline.render.lay_coats import lay_coats
from makeup_video.pipeline.render.scene import FaceScene, FrameScene, Lit, SceneLight
from makeup_video.pipeline.render.surfaces.region import LitSurface, Reader, SeenFace
from makeup_video.pipeline.render.surfaces.surface import Charts, Edge, Laid

COARSE = 2  # px of the patch for one px of the coarse grid, which holds shape and light
# The mesh's rings from border to opening, each from corner to corner, as indices of LIPS.
_RINGS = (0, 40, 60, 20)
LOWER = np.array([[ring + i for i in range(11)] for ring in _RINGS])
UPPER = np.array([[ring, *range(ring + 11, ring + 20), ring + 10] for ring in _RINGS])
# The same as points of the face, (8, 11): as kernels/surface.cl takes them.
LIP_RINGS = LIPS[np.concatenate([UPPER, LOWER])]
_CONTOURS = np.concatenate([LIPS_OUTER, LIPS_INNER])
_ODDS_PER_PX = 1.1  # the mask's steepness at the border: median over photos
# Half the width of the edge: px of the patch at softness 0, px that softness 1 adds, and the least
# px of the frame.
_FEATHER_PX, _FEATHER_MORE_PX, _FEATHER_LEAST_PX = 0.72, 4.8, 0.7
# Log-odds that pale products get at the outer border. The lips' red goes on for a px or two beyond
# the border, and would be seen as a rim around paler products.
_WIDER = 1.2
# A wide blur is made at down to a quarter of the size, with at least this sigma there.
_LEAST_SIGMA_PX, _MOST_SMALLER = 3.0, 4
_LOW, _HIGH = -2.0, 3.0  # bounds of values across the edge, which only count in 0..1
_BEYOND = -15.0  # half the log-odds of all places beyond the patch
_SUB_BITS = 4
_SUB = 2**_SUB_BITS  # parts of a px in which contours are drawn
_INWARD_SIGMA_PX = 1.0  # of the patch
_SIGMAS = 4  # how far OpenCV's blur reaches
_MARGIN = 3  # px of the coarse grid: more than the blur's four px of the patch
_AROUND = 3  # px of the patch that are warped around the part with weight
# The chart: one row from the border of the lips to where they meet.
_CHART_PX = 255
_CHART = LipsFields(lambda: np.linspace(0, 1, _CHART_PX + 1, dtype=np.float32)[None, None])


@dataclass(frozen=True, slots=True, eq=False)
class LipsSurface:
    """Lips, ready to be painted; (H, W) float32 on the patch, (H/2, W/2) on the coarse grid.

    grid: where the coarse grid lies on the frame.  odds: (H, W) log-odds of lipstick, limited to
    the contours' neighbourhood.  rim: (H, W), by how many of its half widths the edge is pushed
    inwards: 0.5 at the rim of an open mouth, -0.3 where shut lips meet, 0 at the outer border.
    normals: (3, H/2, W/2), x and y, and how exposed they are to light: not in the furrow where the
    lips meet.
    upper: (H/2, W/2) share of each px that lies above the line where the lips meet.
    boxes: the part of the patch with weight, by edge; kept once it is found.
    """

    face: Face
    grid: Grid
    odds: np.ndarray
    rim: np.ndarray
    normals: np.ndarray
    upper: np.ndarray
    boxes: dict[Edge, Box] = field(default_factory=dict, repr=False)
    number: ClassVar[int] = 0
    is_broad: ClassVar[bool] = False

    def sides(self) -> "list[LipsSurface]":
        return [self]

    def side_of(self, charts: Charts) -> "LipsSurface":
        return self

    def lay(self, charts: Charts, opacities: Sequence[float], device: Device) -> Laid:
        return lay_coats(self, charts, opacities)

    def join(self, on_sides: Sequence[np.ndarray]) -> np.ndarray:
        return on_sides[0]

    def fields(self) -> LipsFields:
        return LipsFields(lambda: _inward(self.face, self.grid)[None])

    @property
    def chart(self) -> LipsFields:
        return _CHART

    def charts_of(self, charts: Charts) -> Sequence[np.ndarray]:
        return [chart for chart in charts.on_sides if chart is not None]

    def on_chart(self) -> tuple[np.ndarray, np.ndarray]:
        columns = _inward(self.face, self.grid)
        columns *= np.float32(_CHART_PX)
        return columns, np.zeros_like(columns)

    def reach(self, edge: Edge, density: np.ndarray | None) -> tuple[PointXY, PointXY]:
        """Lowest and highest px of the frame with weight, with a margin."""
        patch = Grid(self.face.lips.to_px, self.odds.shape[::-1])
        soft = math.ceil(_SIGMAS * edge.sigma_px / patch.step_px())
        return patch.box_px(self._box(edge), more=2 + soft)  # weights are interpolated

    def weigh(
        self,
        out: np.ndarray,
        origin_xy: tuple[int, int],
        edge: Edge,
        density: np.ndarray | None,
    ) -> None:
        """Fill (h, w) float32 with the weight of lipstick on the frame's pixels from origin_xy on.

        It is 1 on the lips and 0 beyond their edge. At an open mouth most of the edge lies on the
        lips; where shut lips meet, the edge is pushed over the seam.
        """
        x, y, wide, high = self._box(edge)
        left, top = max(x - _AROUND, 0), max(y - _AROUND, 0)
        part = np.s_[top : y + high + _AROUND, left : x + wide + _AROUND]
        half = self._half_edge(edge)
        # 0 to 1 across the edge, whose middle lies at odds of half * rim
        rim = self.rim[part]
        wider = 0.5 * _WIDER * edge.wider / half
        across = cv2.addWeighted(self.odds[part], 0.5 / half, rim, -0.5, 0.5 + wider)
        if wider:  # but not wider towards an open mouth
            cv2.scaleAdd(np.maximum(rim, 0), -wider / ONTO_LIP, across, dst=across)
        a, b, shift_x, c, d, shift_y = Affine.from_array(self.face.lips.to_px)
        shift_x += a * left + b * top - origin_xy[0]
        shift_y += c * left + d * top - origin_xy[1]
        if abs(a * d - b * c) > 1.5**2:
            # cubics to twice the size, then linear: on large faces a third of the cost of cubics
            # alone. Unbounded, cubics would swing up beside a steep fall, as a spike on the skin
            np.minimum(np.maximum(across, _LOW, out=across), _HIGH, out=across)
            across = cv2.resize(across, None, fx=2, fy=2, interpolation=cv2.INTER_CUBIC)
            a, b, c, d = a / 2, b / 2, c / 2, d / 2
            shift_x, shift_y = shift_x - (a + b) / 2, shift_y - (c + d) / 2
        to_px = np.array(((a, b, shift_x), (c, d, shift_y)))
        # in an array of its own: rows of `out` are apart in memory, which slows each step
        there: np.ndarray = cv2.warpAffine(
            across, to_px, out.shape[::-1],
            borderMode=cv2.BORDER_CONSTANT, borderValue=_BEYOND / half,
        )  # fmt: skip
        np.minimum(np.maximum(there, 0, out=there), 1, out=there)
        rest = there * -2
        rest += 3
        there *= there
        cv2.multiply(there, rest, dst=out)
        if edge.sigma_px:
            _blur(out, edge.sigma_px)
        if density is not None:
            out *= self.grid.warped(density, origin_xy, out.shape, 0.0)

    def _box(self, edge: Edge) -> Box:
        """The part of the patch where lipstick has weight."""
        if edge not in self.boxes:
            least = -(1 + OVER_SEAM) * self._half_edge(edge) - _WIDER * edge.wider
            self.boxes[edge] = box_of(self.odds > least)
        return self.boxes[edge]

    def _half_edge(self, edge: Edge) -> float:
        """Log-odds from the middle of the edge to its end."""
        least_px = _FEATHER_LEAST_PX / step_px(self.face.lips.to_px)
        feather = max(_FEATHER_PX + _FEATHER_MORE_PX * edge.softness**2, least_px)
        return feather * _ODDS_PER_PX

    def scaled(self, to_new: AffineArray) -> "LipsSurface":
        """The surface on a picture of another size."""
        grid = Grid(compose(to_new, self.grid.to_px), self.grid.size_wh)
        return replace(self, grid=grid, face=moved(self.face, to_new), boxes={})


def _blur(weight: np.ndarray, sigma_px: float) -> None:
    """Blur (h, w) float32 in place. What is very soft anyway is blurred at a part of its size."""
    factor = int(min(max(sigma_px / _LEAST_SIGMA_PX, 1), _MOST_SMALLER))
    high, wide = weight.shape
    if factor == 1 or min(high, wide) < factor:
        cv2.GaussianBlur(weight, (0, 0), sigma_px, dst=weight)
        return
    small = cv2.resize(weight, (wide // factor, high // factor), interpolation=cv2.INTER_AREA)
    cv2.GaussianBlur(small, (0, 0), sigma_px / factor, dst=small)
    cv2.resize(small, (wide, high), dst=weight, interpolation=cv2.INTER_LINEAR)


def lip_place(face: Face) -> GridPlace | None:
    """Where the lips' coarse grid and patch lie; None when the mouth is hidden or has no area."""
    (a, b, left), (c, d, top) = face.lips.to_px.tolist()
    if face.mouth_weight <= 0 or a * d == b * c:
        return None
    middle = (COARSE - 1) / 2
    coarse = (
        COARSE * a, COARSE * b, left + middle * (a + b),
        COARSE * c, COARSE * d, top + middle * (c + d),
    )  # fmt: skip
    return GridPlace(coarse, (a, b, left, c, d, top))


class LipsRegion:
    """The lips. Their one surface comes from kernels/surface.cl."""

    def places(self, face: Face) -> list[GridPlace | None]:
        return [lip_place(face)]

    def surfaces(
        self, seen: SeenFace, places: Sequence[GridPlace | None]
    ) -> list[LitSurface | None]:
        (place,), made = places, seen.surfaces
        if place is None or made is None:
            return [None]
        return [(lips_surface_of(seen.face, place, made), made.lips[0], made.means[0])]

    def lit(self, item: FrameScene, scene: FaceScene, reader: Reader) -> tuple[Lit, ...]:
        return scene.regions.get("lips", ())

    def amount(self, scene: FaceScene) -> float:
        return scene.face.mouth_weight

    def shade(self, light: SceneLight, mean: float) -> float:
        return 1.0


LIPS_REGION = LipsRegion()


def lips_surface_of(face: Face, place: GridPlace, made: FaceSurfaces) -> LipsSurface:
    """The lips that kernels/surface.cl made."""
    grid = Grid.at(place.to_px, LIPS_HW)
    return LipsSurface(face, grid, made.odds, made.rim, made.lips[1:4], made.lips[4])


def _inward(face: Face, grid: Grid) -> np.ndarray:
    """(H, W) float32 on the grid: 0 at the outer border of the lips and beyond, 1 where they meet
    or the mouth opens.

    It is the distance to the border, as a share of the distances to both contours. They are drawn
    on the patch, only on the part around them.
    """
    to_patch = invert(face.lips.to_px)
    points = face.points_px.take(_CONTOURS, 0)[:, :2] @ to_patch[:, :2].T
    points += to_patch[:, 2]
    np.minimum(np.maximum(points, -99, out=points), 999, out=points)  # so that OpenCV takes them
    points *= _SUB
    fixed = np.rint(points, out=points).astype(np.int32)
    wide, high = grid.size_wh
    x, y, across, down = cv2.boundingRect(fixed)
    (left, right), (top, bottom) = _span(x, across, wide), _span(y, down, high)
    inward = np.zeros((high, wide), np.float32)
    if right <= left or bottom <= top:  # the lips lie beyond the patch
        return inward
    fixed -= (left * COARSE * _SUB, top * COARSE * _SUB)
    hw = (bottom - top) * COARSE, (right - left) * COARSE
    inside, opening = np.zeros(hw, np.uint8), np.ones(hw, np.uint8)
    cv2.fillPoly(inside, [fixed[: len(LIPS_OUTER)]], 1, shift=_SUB_BITS)
    cv2.fillPoly(opening, [fixed[len(LIPS_OUTER) :]], 0, shift=_SUB_BITS)
    from_border: np.ndarray = cv2.distanceTransform(inside, cv2.DIST_L2, 3)
    whole: np.ndarray = cv2.distanceTransform(opening, cv2.DIST_L2, 3)
    whole += from_border
    from_border /= np.maximum(whole, 1, out=whole)
    share = cv2.GaussianBlur(from_border, (0, 0), _INWARD_SIGMA_PX)
    size = right - left, bottom - top
    inward[top:bottom, left:right] = cv2.resize(share, size, interpolation=cv2.INTER_AREA)
    return inward


def _span(first: int, length: int, most: int) -> tuple[int, int]:
    """Begin and end on the coarse grid of contours, and of all px that their blur reaches.

    first, length: of the contours, in parts (_SUB) of a px of the patch.  most: px of the grid.
    """
    step = COARSE * _SUB
    return max(first // step - _MARGIN, 0), min((first + length) // step + 1 + _MARGIN, most)
