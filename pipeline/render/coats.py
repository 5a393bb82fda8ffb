"""A look on a face -> jobs: which coats of which products go on which surface, and where."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import reduce
from itertools import groupby

import numpy as np
from makeup_video.kernels.planes import Rect
from makeup_video.pipeline.faces.face import iod_px
from makeup_video.pipeline.frames.affine import AffineArray
from makeup_video.pipeline.look.kinds import KINDS
from makeup_video.pipeline.look.kinds.kind import Kind
from makeup_video.pipeline.look.look import Layer
from makeup_video.pipeline.look.params import GraphicsParams
from makeup_video.pipeline.render.regions import REGIONS
from makeup_video.pipeline.render.scene import FaceScene, FrameScene, Lit, SceneLight
from makeup_video.pipeline.render.surfaces.surface import Surface

_FAINTEST = 1 / 512  # a fainter density changes no code


@dataclass(frozen=True, slots=True, eq=False)
class SurfaceCoat:
    """A product on one surface.

    amount: 0..1, how much of all of the product.
    density: (H, W) float32 on the surface's grid, 0..1; None for 1 everywhere.
    """

    kind: Kind
    product: GraphicsParams
    amount: float
    density: np.ndarray | None


@dataclass(frozen=True, slots=True, eq=False)
class Job:
    """Coats that are painted on one surface in one go.

    coats: one or more, in the order of painting.
    line: the layer that is drawn on the frame's pixels; its coat's density is only a rough one.
    shade: share of the light that falls on the surface, 0..1.
    skin_px: px of the frame for the distance of the eyes.
    """

    lit: Lit
    surface: Surface
    coats: tuple[SurfaceCoat, ...]
    line: Layer | None
    light: SceneLight
    shade: float
    skin_px: float

    @property
    def softness(self) -> float:
        """Of the surface's own border."""
        return self.coats[0].product.edge_softness

    def rect(self, size_wh: tuple[int, int], block: tuple[int, int]) -> Rect | None:
        """All that has weight on a frame; None when nothing of it lies there."""
        low_xy, high_xy = self.surface.reach(self.softness, _any_density(self.coats))
        return Rect.around(low_xy, high_xy, size_wh, block)

    def weigh(self, out: np.ndarray, origin_xy: tuple[int, int]) -> None:
        """Fill (h, w) float32 with the weight of the coats on the frame's pixels from
        origin_xy on."""
        if self.line is None:
            self.surface.weigh(out, origin_xy, self.softness, _any_density(self.coats))
            return
        fields = self.surface.line_fields(origin_xy, (out.shape[1], out.shape[0]))
        kind = KINDS[self.line.kind]
        (coat,) = kind.coats(fields, self.line.product, self.line.whole_shape)
        out[:] = 1 if coat.density is None else coat.density


def scaled(job: Job, to_new: AffineArray, share: float) -> Job:
    """The same on a picture of another size.  share: its px for one of the frame."""
    return Job(
        job.lit, job.surface.scaled(to_new), job.coats, job.line, job.light, job.shade,
        job.skin_px * share,
    )  # fmt: skip


def jobs_of(item: FrameScene, scene: FaceScene, layers: Sequence[Layer]) -> Iterator[Job]:
    """The jobs of a look on one face, in the order of painting.

    layers: as Look.painted has them.
    """
    for (region_name, line_name), group in groupby(layers, _together):
        region = REGIONS[region_name]
        share, lits = region.amount(scene.face), region.lit(item, scene)
        if share <= 0 or not lits:
            continue
        together, skin_px = list(group), iod_px(scene.face)
        for lit, surface, coats in _on_surfaces(lits, together, share):
            shade = region.shade(scene.light, lit.mean)
            line = together[0] if line_name else None
            yield Job(lit, surface, coats, line, scene.light, shade, skin_px)


def _together(layer: Layer) -> tuple[str, str]:
    """Layers with equal keys are painted in one go: all on a surface, but each line alone."""
    kind = KINDS[layer.kind]
    return kind.surface, kind.name if kind.is_line else ""


def _on_surfaces(
    lits: Sequence[Lit], layers: list[Layer], share: float
) -> Iterator[tuple[Lit, Surface, tuple[SurfaceCoat, ...]]]:
    """The coats of some layers on each side of each surface of a region, where there are any."""
    for surfaces in zip(*(lit.surface.sides() for lit in lits), strict=True):
        coats = list(_coats(surfaces[0].fields(), layers, share))
        for lit, surface in zip(lits, surfaces, strict=True):
            here = [_on(coat, surface.number) for coat in coats]
            there = tuple(coat for coat in here if _is_seen(coat))
            if there:
                yield lit, surface, there


def _coats(fields: object, layers: list[Layer], share: float) -> Iterator[SurfaceCoat]:
    """With densities of all surfaces of a region, (N, H, W)."""
    for layer in layers:
        kind = KINDS[layer.kind]
        for coat in kind.coats(fields, layer.product, layer.whole_shape):
            yield SurfaceCoat(kind, coat.product, share * layer.strength, coat.density)


def _on(coat: SurfaceCoat, number: int) -> SurfaceCoat:
    density = None if coat.density is None else coat.density[number]
    return SurfaceCoat(coat.kind, coat.product, coat.amount, density)


def _is_seen(coat: SurfaceCoat) -> bool:
    return coat.density is None or float(coat.density.max()) > _FAINTEST


def _any_density(coats: Sequence[SurfaceCoat]) -> np.ndarray | None:
    """Of one coat its density; of several, 1 where there is any of them."""
    densities = [coat.density for coat in coats]
    if len(coats) == 1:
        return densities[0]
    given = [density for density in densities if density is not None]
    if len(given) < len(densities):
        return None
    return (reduce(np.maximum, given) > _FAINTEST).astype(np.float32)
