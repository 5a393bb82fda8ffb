"""FrameScene -> Frame: lays the look on the planes. Bytes outside every mask stay the decoder's."""

import math
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from makeup_video.kernels.colour import Coding
from makeup_video.kernels.paint import Canvas, PaintedRegion
from makeup_video.kernels.planes import Rect
from makeup_video.pipeline.engine.quality import QualityLevel
from makeup_video.pipeline.faces.face import iod_px
from makeup_video.pipeline.frames.affine import Affine
from makeup_video.pipeline.frames.frame import Frame
from makeup_video.pipeline.look.look import Layer, Look
from makeup_video.pipeline.look.params import GraphicsParams
from makeup_video.pipeline.render.environment import environment_of
from makeup_video.pipeline.render.half_resolution import LARGE_PX, HalfSize, half_of, half_size
from makeup_video.pipeline.render.opencl import open_device
from makeup_video.pipeline.render.product_material import SkinAxes, material
from makeup_video.pipeline.render.regions import PAINTED
from makeup_video.pipeline.render.scene import FaceScene, FrameScene, Lit, SceneLight

_MUCH_LARGER = 1.3  # ratio of areas from which another face takes the makeup over
_STAYS_SMALL = 0.8  # share of LARGE_PX down to which painting stays at half size
# The surfaces of a face that wear one layer of the look, and how much of its product is shown.
_Part = tuple[tuple[Lit, ...], Layer, float]


@dataclass(frozen=True, slots=True, eq=False)
class _Job:
    """A surface to be painted: the product and how much of it, under which light, where.

    shape: as for Surface.  shade: as for material.  environment: as for PaintedRegion.
    skin_px: as for SkinAxes.
    """

    lit: Lit
    params: GraphicsParams
    shape: Mapping[str, Any]
    amount: float
    light: SceneLight
    shade: float
    environment: np.ndarray
    skin_px: float
    rect: Rect


class Composite:
    """Paints `look` on every frame.

    device: as for open_device.  faces: all, largest, or a face's number.
    painted_frames: how many frames had a face that was painted.
    chosen_frames: how many had a face that was chosen by `faces`, its lips and lids seen or not.
    numbers: the ids of all faces seen.
    level: may be set between two frames. At LESS_DETAIL large regions are painted at half size.
    Raises InstallError, UsageError for the device.
    """

    def __init__(self, look: Look, device: str = "", faces: str = "all") -> None:
        self._canvas = Canvas(open_device(device))
        self._faces = faces
        self._largest_id = -1
        self.painted_frames = self.chosen_frames = 0
        self.numbers: set[int] = set()
        self.level = QualityLevel.FULL
        self._half = HalfSize()
        self._is_small = False
        self.set_look(look)

    def set_look(self, look: Look) -> None:
        """Take effect from the next frame on."""
        self.look = look

    def __call__(self, item: FrameScene) -> Frame:
        chosen = self._chosen(item.faces)
        self.numbers.update(scene.face.track_id for scene in item.faces)
        self.chosen_frames += bool(chosen)
        # read once: another thread may set a new look while this frame is painted
        self.painted_frames += self._paint_faces(item, chosen, self.look)
        return item.frame

    def rehearse(self, item: FrameScene, look: Look) -> None:
        """Paint once off screen, so that kernels are ready before the first frame: loading them
        takes 30 ms, and compiling them 300."""
        self._paint_faces(item, item.faces, look)

    def _paint_faces(self, item: FrameScene, faces: tuple[FaceScene, ...], look: Look) -> bool:
        """Paint a look on some faces; False when there was nothing to paint."""
        chosen = [(scene, self._parts(scene, look)) for scene in faces]
        chosen = [(scene, parts) for scene, parts in chosen if parts]
        if not chosen or len(item.frame.planes) < 2:  # a grey frame holds no colour
            return False
        planes = item.frame.writable_planes()
        jobs = [
            job for scene, parts in chosen for part in parts for job in _jobs(item, scene, part)
        ]
        area_px = sum(job.rect.width * job.rect.height for job in jobs)
        # hysteresis: otherwise the glitter would flicker between the two sizes
        least_px = _STAYS_SMALL * LARGE_PX if self._is_small else LARGE_PX
        self._is_small = self.level >= QualityLevel.LESS_DETAIL and area_px >= least_px
        if self._is_small:
            self._paint_small(item, planes, jobs)
        else:
            for together in _apart(jobs):
                self._paint(item, planes, together)
        return True

    def _chosen(self, faces: tuple[FaceScene, ...]) -> tuple[FaceScene, ...]:
        if self._faces == "all":
            return faces
        if self._faces == "largest":
            return self._largest(faces)
        return tuple(scene for scene in faces if str(scene.face.track_id) == self._faces)

    def _largest(self, faces: tuple[FaceScene, ...]) -> tuple[FaceScene, ...]:
        """The largest face, or none. Between two faces of about the same size the makeup would jump
        back and forth, so it stays on one until that face is gone or another is much larger."""
        stays = [scene for scene in faces if scene.face.track_id == self._largest_id]
        if not stays or faces[0].face.area_px2 > _MUCH_LARGER * stays[0].face.area_px2:
            stays = list(faces[:1])
        if stays:
            self._largest_id = stays[0].face.track_id
        return tuple(stays[:1])

    def _parts(self, scene: FaceScene, look: Look) -> list[_Part]:
        parts = []
        for layer in look.layers:
            surfaces = scene.regions.get(layer.region, ())
            amount = layer.amount * PAINTED[layer.region].amount(scene.face)
            if surfaces and amount > 0 and layer.product.is_worn:
                parts.append((surfaces, layer, amount))
        return parts

    def _paint_small(
        self, item: FrameScene, planes: tuple[np.ndarray, ...], jobs: list[_Job]
    ) -> None:
        small = [half for job in jobs for half in _half(job, item.frame)]
        for together in _apart(small):

            def paint(planes: tuple[np.ndarray, ...], together: list[_Job] = together) -> None:
                self._paint(item, planes, together)

            rects = [job.rect for job in together]
            self._half.paint(planes, rects, item.frame.chroma, item.coding.max_code, paint)

    def _paint(self, item: FrameScene, planes: tuple[np.ndarray, ...], jobs: list[_Job]) -> None:
        rects = [job.rect for job in jobs]
        weights = self._canvas.place(rects, item.frame.chroma, planes[0].dtype)
        surfaces = []
        for job, weight in zip(jobs, weights, strict=True):
            origin_xy = job.rect.x, job.rect.y
            job.lit.surface.weigh(weight, origin_xy, job.params.edge_softness, job.shape)
            surfaces.append(_surface(job, weight, item.coding))
        self._canvas.paint(planes, surfaces, item.coding)


def _half(job: _Job, frame: Frame) -> Iterator[_Job]:
    """A job on the picture at half size; none when nothing of it lies there."""
    lit = half_of(job.lit)
    reach = lit.surface.reach(job.params.edge_softness, job.shape)
    rect = Rect.around(*reach, half_size((frame.width_px, frame.height_px)), frame.chroma)
    if rect is not None:
        yield replace(job, lit=lit, skin_px=job.skin_px / 2, rect=rect)


def _jobs(item: FrameScene, scene: FaceScene, part: _Part) -> Iterator[_Job]:
    """The surfaces of a part that lie on the frame."""
    surfaces, layer, amount = part
    params, region = layer.product, PAINTED[layer.region]
    frame, environment = item.frame, environment_of(scene.light, params, item.coding)
    size, block, skin_px = (frame.width_px, frame.height_px), frame.chroma, iod_px(scene.face)
    for lit in surfaces:
        low_xy, high_xy = lit.surface.reach(params.edge_softness, layer.shape)
        rect = Rect.around(low_xy, high_xy, size, block)
        if rect is not None:
            yield _Job(
                lit, params, layer.shape, amount, scene.light, region.shade(scene.light, lit.mean),
                environment, skin_px, rect,
            )  # fmt: skip


def _apart(jobs: Iterable[_Job]) -> Iterator[list[_Job]]:
    """The jobs in order, in groups whose rectangles do not overlap."""
    together: list[_Job] = []
    for job in jobs:
        if any(job.rect.overlaps(other.rect) for other in together):
            yield together
            together = []
        together.append(job)
    if together:
        yield together


def _surface(job: _Job, weight: np.ndarray, coding: Coding) -> PaintedRegion:
    surface = job.lit.surface
    a, b, x, c, d, y = Affine.from_array(surface.grid.to_px)
    along, across = math.hypot(a, c), math.hypot(b, d)  # px of a step on the grid
    turn = (a / along, b / across), (c / along, d / across)
    to_grid = Affine(a, b, x - job.rect.x, c, d, y - job.rect.y).inverse()
    # the surface's own axes, in units of the eyes' distance
    units = [along / job.skin_px] * 3 + [across / job.skin_px] * 3
    to_skin = [number * unit for number, unit in zip(to_grid, units, strict=True)]
    axes = SkinAxes(turn, job.skin_px)
    product = material(
        job.params, job.amount, job.light, axes, coding, surface.spared, job.shade,
        surface.keep_highlights,
    )  # fmt: skip
    return PaintedRegion(
        job.rect, weight, job.lit.shading, surface.normals, to_grid, job.lit.mean, to_skin,
        job.environment, product,
    )  # fmt: skip
