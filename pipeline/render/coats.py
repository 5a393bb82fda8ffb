"""A look on a face -> jobs: which coats of which products go on which surface, and where.

Densities are drawn once for a look, on a chart of each side of a region. For each frame they are
looked up at the places of the region's surfaces. Lines are drawn anew for every frame.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from itertools import groupby, zip_longest
from typing import Any, NamedTuple

import numpy as np
from makeup_video.kernels.paint import LAYERS
from makeup_video.kernels.planes import Rect
from makeup_video.kernels.program import Device
from makeup_video.kernels.shares import FAINTEST
from makeup_video.kernels.strokes import Line
from makeup_video.pipeline.faces.face import iod_px
from makeup_video.pipeline.frames.affine import AffineArray
from makeup_video.pipeline.look.ciede2000 import lab_of
from makeup_video.pipeline.look.kinds import KINDS
from makeup_video.pipeline.look.kinds.kind import BOTH_EYES, Coat, Kind, Stroke
from makeup_video.pipeline.look.look import Layer
from makeup_video.pipeline.look.params import GraphicsParams
from makeup_video.pipeline.render.grid import box_of
from makeup_video.pipeline.render.regions import REGIONS
from makeup_video.pipeline.render.scene import FaceScene, FrameScene, Lit, SceneLight
from makeup_video.pipeline.render.strokes import box_of_strokes, fade_px, line_of
from makeup_video.pipeline.render.surfaces.eyes import NUMBERS
from makeup_video.pipeline.render.surfaces.region import Reader
from makeup_video.pipeline.render.surfaces.surface import Charts, Edge, Surface

# L* of products that hide the red around lips, and of those that show it; bare lips have about 55.
_HIDES_RED, _SHOWS_RED = 45.0, 70.0


@dataclass(frozen=True, slots=True, eq=False)
class WornCoat:
    """A product of a look.  strength: 0..1, scales the whole product."""

    kind: Kind
    product: GraphicsParams
    strength: float


@dataclass(frozen=True, slots=True, eq=False)
class Drawn:
    """Coats that are painted in one go, LAYERS at most, and their charts.

    charts: None for a single coat with a density of 1 everywhere.
    edge: how the coats end at the surface's own border.
    """

    coats: tuple[WornCoat, ...]
    charts: Charts | None
    edge: Edge


@dataclass(slots=True, eq=False)
class Group:
    """Layers that are painted in one go: successive layers of one region, lines apart from areas.

    region: a key of REGIONS.  number: the one surface that wears the layers; None: all wear them.
    """

    region: str
    layers: tuple[Layer, ...]
    is_line: bool
    number: int | None
    _drawn: list[Drawn] | None = field(default=None, init=False, repr=False)

    def on(self, surface: Surface) -> list[Drawn]:
        """The coats of the layers, drawn on the charts of all sides of a surface of the region, in
        the order of painting."""
        if self._drawn is None:  # drawn once for all frames
            self._drawn = _draw([side.chart for side in surface.sides()], self.layers)
        return self._drawn


class Part(NamedTuple):
    """Coats that lie on one surface.

    coats: one or more, in the order of painting.
    edge: how the coats end at the surface's own border.
    shares: (coats, H, W) float32 on the surface's grid, 0..1, how much of each coat shows; None for
    a single coat.
    seen: the sums of these shares, one for each of several coats.
    density: (H, W): of a single coat its density, of several coats 1 where any of them lies, of
    strokes True where they may be seen; None for 1 everywhere.
    strokes: (H, W) each, drawn in place of a density; their borders fade over blur_px of the frame.
    """

    lit: Lit
    surface: Surface
    coats: tuple[WornCoat, ...]
    edge: Edge
    shares: np.ndarray | None = None
    seen: Sequence[float] = ()
    density: np.ndarray | None = None
    strokes: tuple[Stroke, ...] = ()
    blur_px: float = 1.0


class PaintJob(NamedTuple):
    """Coats that are painted on one surface in one go.

    amount: 0..1, scales all of their products.
    shade: share of the light on the face that falls on the surface, 0..1.
    skin_px: the distance of the eyes in px of the painted picture.
    share: px of the painted picture for one px of the frame.
    """

    part: Part
    light: SceneLight
    amount: float
    shade: float
    skin_px: float
    share: float = 1.0

    @property
    def coats(self) -> tuple[WornCoat, ...]:
        return self.part.coats

    @property
    def surface(self) -> Surface:
        return self.part.surface

    @property
    def is_veil(self) -> bool:
        """True for coats on a broad surface without sparkles, which are finer than densities."""
        return self.surface.is_broad and not any(coat.product.shimmer for coat in self.coats)

    def rect(self, size_wh: tuple[int, int], block: tuple[int, int]) -> Rect | None:
        """The rectangle of a frame that holds all weight of the job; None when none lies there."""
        part = self.part
        if part.density is not None and part.strokes:  # lines may cross the surface's own border
            low_xy, high_xy = part.surface.grid.box_px(box_of(part.density), more=1)
        else:
            low_xy, high_xy = part.surface.reach(part.edge, part.density)
        return Rect.around(low_xy, high_xy, size_wh, block)

    @property
    def is_line(self) -> bool:
        """True for coats that are drawn with strokes."""
        return bool(self.part.strokes)

    def line(self) -> Line:
        """The strokes as kernels/strokes.cl draws them."""
        part, share = self.part, self.share
        soft_px = fade_px(part.edge.sigma_px)
        blur_px = max(part.blur_px * share, soft_px)
        return line_of(part.surface.grid, part.strokes, blur_px, soft_px, share)

    def weigh(self, out: np.ndarray, origin_xy: tuple[int, int]) -> None:
        """Fill (h, w) float32 with the coats' weight on the frame's pixels from origin_xy on; not
        for lines."""
        part = self.part
        part.surface.weigh(out, origin_xy, part.edge, part.density)


def scaled(job: PaintJob, to_new: AffineArray, share: float) -> PaintJob:
    """The job on a picture of another size.

    to_new: px of the frame -> px of that picture.  share: px of it for one px of the frame.
    """
    edge = job.part.edge._replace(sigma_px=job.part.edge.sigma_px * share)
    part = job.part._replace(surface=job.surface.scaled(to_new), edge=edge)
    return job._replace(part=part, skin_px=job.skin_px * share, share=share)


def groups_of(layers: Sequence[Layer]) -> list[Group]:
    """Group the layers of Look.painted, in the order of painting."""
    return [
        Group(region, tuple(together), bool(line), NUMBERS.get(eye))
        for (region, line, eye), together in groupby(layers, _together)
    ]


def _together(layer: Layer) -> tuple[str, str, str]:
    """What layers of one group share: the region, the kind if they are lines, and the eye."""
    kind = KINDS[layer.kind]
    return kind.region, kind.name if kind.is_line else "", layer.shape.get("eye", BOTH_EYES)


def _draw(charts: Sequence[Any], layers: Sequence[Layer]) -> list[Drawn]:
    """Draw layers on the charts of all sides; coats that lie nowhere are left out."""
    made = [
        (_worn(layer.kind, next(filter(None, each)).product, layer.strength), each)
        for layer in layers
        for each in zip_longest(*(_coats(chart, layer) for chart in charts))
        if any(map(_lies, each))
    ]
    if len(made) == len(charts) == 1 and made[0][1][0].density is None:
        return [Drawn((made[0][0],), None, _edge_of(made))]
    drawn = []
    for first in range(0, len(made), LAYERS):
        together = made[first : first + LAYERS]
        coats, on_charts = zip(*together, strict=True)
        stacked = tuple([_stacked(on_chart) for on_chart in zip(*on_charts, strict=True)])
        drawn.append(Drawn(coats, Charts(stacked), _edge_of(together)))
    return drawn


def _edge_of(coats: Sequence[tuple[WornCoat, Sequence[Coat | None]]]) -> Edge:
    """How coats end at the surface's own border.

    The first coat decides. A darker coat over it, such as a lip liner's rim, counts by how much of
    it shows where it is densest.

    coats: each with its Coat on every chart, None on charts where the coat does not lie.
    """
    (first, _), *others = coats
    pale = _paleness(first.product)
    for worn, on_charts in others:
        densest = max(
            1.0 if coat.density is None else float(coat.density.max())
            for coat in on_charts
            if coat is not None
        )
        shows = worn.strength * worn.product.opacity * densest
        pale = min(pale, 1 - (1 - _paleness(worn.product)) * min(shows, 1.0))
    return Edge(first.product.edge_softness, pale)


def _lies(coat: Coat | None) -> bool:
    """True for a coat that lies anywhere on its chart."""
    return coat is not None and (coat.density is None or coat.density.max() > FAINTEST)


def _stacked(coats: Sequence[Coat | None]) -> np.ndarray | None:
    """(h, w, coats): the densities of coats on a chart; None where no coat lies."""
    if not any(map(_lies, coats)):
        return None
    densities = [None if coat is None else coat.density for coat in coats]
    shapes = [one.shape[1:] for one in densities if one is not None]
    stacked = np.ones((*(shapes or [(1, 1)])[0], len(coats)), np.float32)
    for at, (coat, density) in enumerate(zip(coats, densities, strict=True)):
        if coat is None:
            stacked[..., at] = 0
        elif density is not None:
            stacked[..., at] = density[0]
    return stacked


def _coats(at: Any, layer: Layer) -> list[Coat]:
    """The coats of a layer.  at: the fields or the chart of a surface, see look/kinds/fields.py."""
    return KINDS[layer.kind].coats(at, layer.product, layer.shape)


@lru_cache(maxsize=64)
def _worn(kind: str, product: GraphicsParams, strength: float) -> WornCoat:
    """The same object in all frames, though lines are drawn anew in each: `coat_records` caches by
    the object what no light changes."""
    return WornCoat(KINDS[kind], product, strength)


@lru_cache(maxsize=64)
def _paleness(product: GraphicsParams) -> float:
    """0 for a product that hides the red beyond the lips' border, to 1 if it shows all of it."""
    lightness = float(lab_of(np.array((product.red, product.green, product.blue)))[0])
    share = min(max((lightness - _HIDES_RED) / (_SHOWS_RED - _HIDES_RED), 0), 1)
    return share * share * (3 - 2 * share)


def jobs_of(
    item: FrameScene, scene: FaceScene, groups: Sequence[Group], reader: Reader
) -> Iterator[PaintJob]:
    """The jobs of a look on one face, in the order of painting.

    groups: the result of `groups_of`.
    """
    skin_px = iod_px(scene.face)
    for group in groups:
        region = REGIONS[group.region]
        amount, lits = region.amount(scene), region.lit(item, scene, reader)
        if group.number is not None:
            number = 1 - group.number if item.frame.is_mirrored else group.number
            lits = tuple([lit for lit in lits if lit.surface.number == number])
        if amount <= 0 or not lits:
            continue
        sigma_px = scene.sigma_px.get(group.region, 0.0)
        if group.is_line:
            parts = _lines(lits, group, sigma_px)
        else:
            parts = _areas(lits, group, amount, sigma_px, reader.device)
        for part in parts:
            light = scene.light.for_veils if part.surface.is_broad else scene.light
            shade = region.shade(light, part.lit.mean)
            yield PaintJob(part, light, amount, shade, skin_px)


def _areas(
    lits: Sequence[Lit], group: Group, amount: float, sigma_px: float, device: Device
) -> Iterator[Part]:
    """The coats of a group on each surface of a region, on the sides where coats lie."""
    for drawn in group.on(lits[0].surface):
        coats, charts, edge = drawn.coats, drawn.charts, drawn.edge._replace(sigma_px=sigma_px)
        if charts is None:
            for lit in lits:
                yield Part(lit, lit.surface, coats, edge)
            continue
        opacities = [coat.product.opacity * coat.strength * amount for coat in coats]
        shares, sums, there = lits[0].surface.lay(charts, opacities, device)
        for lit in lits:
            at, surface = lit.surface.number, lit.surface.side_of(charts)
            if shares is None:
                yield Part(lit, surface, coats, edge, density=there[at])
            else:
                yield Part(lit, surface, coats, edge, shares[:, at], sums[at], there[at])


def _lines(lits: Sequence[Lit], group: Group, sigma_px: float) -> Iterator[Part]:
    """The lines of a group on each surface. They lie where they are drawn, whatever the side."""
    for layer in group.layers:
        for coat in _coats(lits[0].surface.fields(), layer):
            worn = (_worn(layer.kind, coat.product, layer.strength),)
            edge = Edge(coat.product.edge_softness, sigma_px=sigma_px)
            seen = box_of_strokes(coat.strokes, max(coat.blur_px, fade_px(sigma_px)))
            for lit in lits:
                at = lit.surface.number
                strokes = tuple([Stroke(one.above[at], one.below[at]) for one in coat.strokes])
                yield Part(lit, lit.surface, worn, edge, None, (), seen[at], strokes, coat.blur_px)
