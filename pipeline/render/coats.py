"""A look on a face -> jobs: which coats of which products go on which surface, and where."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import groupby

import cv2
import numpy as np
from makeup_video.kernels.planes import Rect
from makeup_video.kernels.program import Device
from makeup_video.pipeline.faces.face import iod_px
from makeup_video.pipeline.frames.affine import AffineArray
from makeup_video.pipeline.look.kinds import KINDS
from makeup_video.pipeline.look.kinds.kind import Coat, Kind, Stroke
from makeup_video.pipeline.look.look import Layer
from makeup_video.pipeline.look.params import GraphicsParams
from makeup_video.pipeline.render.draw_strokes import box_of_strokes, draw_strokes
from makeup_video.pipeline.render.grid import box_of
from makeup_video.pipeline.render.regions import REGIONS
from makeup_video.pipeline.render.scene import FaceScene, FrameScene, Lit, SceneLight
from makeup_video.pipeline.render.surfaces.surface import Surface

_FAINTEST = 1 / 512  # a fainter density changes no code


@dataclass(frozen=True, slots=True, eq=False)
class SurfaceCoat:
    """A product on one surface.

    amount: 0..1, how much of all of the product.
    density: (H, W) float32 on the surface's grid, 0..1; None for 1 everywhere. Of strokes, 1 where
    they may be seen.
    strokes: (H, W) each, drawn in place of the density, and faded over blur_px of the frame.
    """

    kind: Kind
    product: GraphicsParams
    amount: float
    density: np.ndarray | None
    strokes: tuple[Stroke, ...] = ()
    blur_px: float = 1.0


@dataclass(frozen=True, slots=True, eq=False)
class Job:
    """Coats that are painted on one surface in one go.

    coats: one or more, in the order of painting.
    shade: share of the light that falls on the surface, 0..1.
    skin_px: px of the picture for the distance of the eyes.
    density: (H, W) float32 on the surface's grid, 0..1; of one coat its own, of several 1 where
    there is any of them; None for 1 everywhere.
    share: px of the picture for one of the frame.
    """

    lit: Lit
    surface: Surface
    coats: tuple[SurfaceCoat, ...]
    light: SceneLight
    shade: float
    skin_px: float
    density: np.ndarray | None
    share: float = 1.0

    @property
    def softness(self) -> float:
        """Of the surface's own border."""
        return self.coats[0].product.edge_softness

    @property
    def is_veil(self) -> bool:
        """True when it has nothing finer than its densities, such as a sparkle."""
        return self.surface.is_broad and not any(coat.product.shimmer for coat in self.coats)

    def rect(self, size_wh: tuple[int, int], block: tuple[int, int]) -> Rect | None:
        """All that has weight on a frame; None when nothing of it lies there."""
        if self.density is not None and self.coats[0].strokes:  # whatever the surface's own border
            low_xy, high_xy = self.surface.grid.box_px(box_of(self.density > 0), more=1)
        else:
            low_xy, high_xy = self.surface.reach(self.softness, self.density)
        return Rect.around(low_xy, high_xy, size_wh, block)

    def weigh(self, out: np.ndarray, origin_xy: tuple[int, int]) -> None:
        """Fill (h, w) float32 with the weight of the coats on the frame's pixels from
        origin_xy on."""
        first = self.coats[0]
        if first.strokes:
            blur_px = max(first.blur_px * self.share, 1.0)
            grid = self.surface.grid
            draw_strokes(out, origin_xy, grid, first.strokes, blur_px, self.share)
        else:
            self.surface.weigh(out, origin_xy, self.softness, self.density)


def scaled(job: Job, to_new: AffineArray, share: float) -> Job:
    """The same on a picture of another size.  share: its px for one of the frame."""
    return replace(
        job, surface=job.surface.scaled(to_new), skin_px=job.skin_px * share, share=share
    )


def jobs_of(
    item: FrameScene, scene: FaceScene, layers: Sequence[Layer], device: Device
) -> Iterator[Job]:
    """The jobs of a look on one face, in the order of painting.

    layers: as Look.painted has them.  device: of the calling thread.
    """
    skin_px = iod_px(scene.face)
    for (region_name, _), group in groupby(layers, _together):
        region = REGIONS[region_name]
        share, lits = region.amount(scene.face), region.lit(item, scene, device)
        if share <= 0 or not lits:
            continue
        for lit, surface, coats in _on_surfaces(lits, list(group), share):
            shade = region.shade(scene.light, lit.mean)
            density = _any_density(coats)
            yield Job(lit, surface, coats, scene.light, shade, skin_px, density)


def _together(layer: Layer) -> tuple[str, str]:
    """Layers with equal keys are painted in one go: all on a surface, but each line alone."""
    kind = KINDS[layer.kind]
    return kind.surface, kind.name if kind.is_line else ""


def _on_surfaces(
    lits: Sequence[Lit], layers: list[Layer], share: float
) -> Iterator[tuple[Lit, Surface, tuple[SurfaceCoat, ...]]]:
    """The coats of some layers on each side of each surface of a region, where there are any.

    Lines lie where they are drawn, whatever the side.
    """
    sides = list(zip(*(lit.surface.sides() for lit in lits), strict=True))
    for surfaces in sides[:1] if KINDS[layers[0].kind].is_line else sides:
        made = [(layer, coat) for layer in layers for coat in _coats(surfaces[0], layer)]
        for lit, surface in zip(lits, surfaces, strict=True):
            here = [_on(surface.number, layer, coat, share) for layer, coat in made]
            there = tuple(
                coat
                for coat in here
                if coat.density is None or float(coat.density.max()) > _FAINTEST
            )
            if there:
                yield lit, surface, there


def _coats(surface: Surface, layer: Layer) -> list[Coat]:
    """Of all surfaces of a region, (N, H, W)."""
    return KINDS[layer.kind].coats(surface.fields(), layer.product, layer.shape)


def _on(number: int, layer: Layer, coat: Coat, share: float) -> SurfaceCoat:
    """A coat on one surface of the region."""
    strokes = tuple(Stroke(one.above[number], one.below[number]) for one in coat.strokes)
    if strokes:
        density: np.ndarray | None = box_of_strokes(strokes, coat.blur_px)
    else:
        density = None if coat.density is None else coat.density[number]
    kind, amount = KINDS[layer.kind], share * layer.strength
    return SurfaceCoat(kind, coat.product, amount, density, strokes, coat.blur_px)


def _any_density(coats: Sequence[SurfaceCoat]) -> np.ndarray | None:
    """Of one coat its density; of several, 1 where there is any of them."""
    first, *others = (coat.density for coat in coats)
    if first is None or not others:
        return first
    most = first
    for density in others:
        if density is None:
            return None
        most = cv2.max(most, density)
    _, there = cv2.threshold(most, _FAINTEST, 1.0, cv2.THRESH_BINARY)
    any_of_them: np.ndarray = there
    return any_of_them
