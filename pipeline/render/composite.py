"""FrameScene -> Frame: lays the look on the planes. Bytes outside every mask stay the decoder's."""

import math
from collections.abc import Iterable, Iterator

import numpy as np
from makeup_video.kernels.colour import Coding
from makeup_video.kernels.material import Material
from makeup_video.kernels.paint import Canvas, PaintedRegion
from makeup_video.kernels.planes import Rect
from makeup_video.pipeline.engine.quality import QualityLevel
from makeup_video.pipeline.frames.affine import Affine
from makeup_video.pipeline.frames.frame import Frame
from makeup_video.pipeline.look.look import Look
from makeup_video.pipeline.render.blend_layers import blend
from makeup_video.pipeline.render.coats import Group, Job, WornCoat, groups_of, jobs_of, scaled
from makeup_video.pipeline.render.environment import environment_of
from makeup_video.pipeline.render.half_resolution import (
    LARGE_PX,
    SmallPlanes,
    small_size,
    to_small,
)
from makeup_video.pipeline.render.opencl import open_device
from makeup_video.pipeline.render.product_material import SkinAxes, material
from makeup_video.pipeline.render.scene import FaceScene, FrameScene
from makeup_video.pipeline.render.surfaces.region import Reader

_MUCH_LARGER = 1.3  # ratio of areas from which another face takes the makeup over
# Luma px of a rect from which on a veil is painted at half size, and at a quarter.
_VEIL_PX, _LARGE_VEIL_PX = 8_000, 32_000
_STAYS_SMALL = 0.8  # share of LARGE_PX down to which painting stays at half size
# A job, and the rectangle of the frame that holds all its weight.
_Placed = tuple[Job, Rect]


def open_canvas(device: str = "") -> Canvas:
    """A canvas on a device, for one thread. Raises as open_device does."""
    return Canvas(open_device(device))


class Composite:
    """Paints `look` on every frame.

    device: as for open_device, or a canvas, which several may share in one thread.
    faces: all, largest, or a face's number.
    painted_frames: how many frames had a face that was painted.
    chosen_frames: how many had a face that was chosen by `faces`, its lips and lids seen or not.
    numbers: the ids of all faces seen.  largest_id: the face that was painted last as the largest.
    level: may be set between two frames. At LESS_DETAIL large regions are painted at half size.
    Raises InstallError, UsageError for the device.
    """

    def __init__(self, look: Look, device: str | Canvas = "", faces: str = "all") -> None:
        self._canvas = open_canvas(device) if isinstance(device, str) else device
        self._reader = Reader(self._canvas.device)
        self._faces = faces
        self.largest_id = -1
        self.painted_frames = self.chosen_frames = 0
        self.numbers: set[int] = set()
        self.level = QualityLevel.FULL
        self._small = {factor: SmallPlanes(factor) for factor in (2, 4)}
        self._is_small = False
        self.set_look(look)

    def set_look(self, look: Look) -> None:
        """Take effect from the next frame on."""
        self.look = look
        self._groups = groups_of(look.painted)

    def __call__(self, item: FrameScene) -> Frame:
        chosen = self._chosen(item.faces)
        self.numbers.update(scene.face.track_id for scene in item.faces)
        self.chosen_frames += bool(chosen)
        # read once: another thread may set a new look while this frame is painted
        self.painted_frames += self._paint_faces(item, chosen, self._groups)
        return item.frame

    def settle(self, item: FrameScene, *, read: bool) -> None:
        """Choose the faces of a frame, and paint nothing: the next frame is then painted as if this
        one had been. read: also read the surfaces that painting keeps from frame to frame."""
        chosen = self._chosen(item.faces)
        if read:
            self._jobs(item, chosen, self._groups)

    def rehearse(self, item: FrameScene, look: Look) -> None:
        """Paint once off screen, so that kernels are ready before the first frame: loading them
        takes 30 ms, and compiling them 300."""
        self._paint_faces(item, item.faces, groups_of(look.painted))
        self._reader.kept.clear()

    def _paint_faces(
        self, item: FrameScene, faces: tuple[FaceScene, ...], groups: list[Group]
    ) -> bool:
        """Paint the layers of a look on some faces; False when there was nothing to paint."""
        if not groups or len(item.frame.planes) < 2:  # a grey frame holds no colour
            return False
        jobs = self._jobs(item, faces, groups)
        if not jobs:
            return False
        planes = item.frame.writable_planes()
        size = item.frame.width_px, item.frame.height_px
        placed = list(_placed(jobs, size, item.frame.chroma))
        # a veil has no detail of its own, and its area is large
        veils = [(job, rect) for job, rect in placed if job.is_veil and _area_px(rect) > _VEIL_PX]
        for veil, rect in veils:  # they come first in the order of painting
            self._paint_small(item, planes, [veil], 4 if _area_px(rect) > _LARGE_VEIL_PX else 2)
        if veils:
            placed = [one for one in placed if one not in veils]
        area_px = sum(_area_px(rect) for _, rect in placed)
        # hysteresis: otherwise the glitter would flicker between the two sizes
        least_px = _STAYS_SMALL * LARGE_PX if self._is_small else LARGE_PX
        self._is_small = self.level >= QualityLevel.LESS_DETAIL and area_px >= least_px
        if self._is_small:
            self._paint_small(item, planes, [job for job, _ in placed], 2)
        else:
            for together in _apart(placed):
                self._paint(item, planes, together)
        return True

    def _jobs(
        self, item: FrameScene, faces: tuple[FaceScene, ...], groups: list[Group]
    ) -> list[Job]:
        """What there is to paint: all surfaces are read before anything is painted."""
        kept = self._reader.kept
        if item.cut:
            kept.clear()
        jobs = [job for scene in faces for job in jobs_of(item, scene, groups, self._reader)]
        kept.forget(item.frame.seconds)
        return jobs

    def _chosen(self, faces: tuple[FaceScene, ...]) -> tuple[FaceScene, ...]:
        if self._faces == "all":
            return faces
        if self._faces == "largest":
            return self._largest(faces)
        return tuple(scene for scene in faces if str(scene.face.track_id) == self._faces)

    def _largest(self, faces: tuple[FaceScene, ...]) -> tuple[FaceScene, ...]:
        """The largest face, or none. Between two faces of about the same size the makeup would jump
        back and forth, so it stays on one until that face is gone or another is much larger."""
        stays = [scene for scene in faces if scene.face.track_id == self.largest_id]
        if not stays or faces[0].face.area_px2 > _MUCH_LARGER * stays[0].face.area_px2:
            stays = list(faces[:1])
        if stays:
            self.largest_id = stays[0].face.track_id
        return tuple(stays[:1])

    def _paint_small(
        self, item: FrameScene, planes: tuple[np.ndarray, ...], jobs: list[Job], factor: int
    ) -> None:
        size = small_size((item.frame.width_px, item.frame.height_px), factor)
        jobs = [scaled(job, to_small(factor), 1 / factor) for job in jobs]
        small = _placed(jobs, size, item.frame.chroma)
        for together in _apart(small):

            def paint(planes: tuple[np.ndarray, ...], together: list[_Placed] = together) -> None:
                self._paint(item, planes, together)

            rects = [rect for _, rect in together]
            painter, chroma = self._small[factor], item.frame.chroma
            painter.paint(planes, rects, chroma, item.coding.max_code, paint)

    def _paint(
        self, item: FrameScene, planes: tuple[np.ndarray, ...], placed: list[_Placed]
    ) -> None:
        rects = [rect for _, rect in placed]
        weights = self._canvas.place(rects, item.frame.chroma, planes[0].dtype)
        regions = []
        for (job, rect), weight in zip(placed, weights, strict=True):
            job.weigh(weight, (rect.x, rect.y))
            regions.append(_region(job, rect, weight, item.coding))
        self._canvas.paint(planes, regions, item.coding)


def _placed(
    jobs: Iterable[Job], size_wh: tuple[int, int], block: tuple[int, int]
) -> Iterator[_Placed]:
    """The jobs that lie on a frame, each with its rectangle."""
    for job in jobs:
        rect = job.rect(size_wh, block)
        if rect is not None:
            yield job, rect


def _area_px(rect: Rect) -> int:
    return rect.width * rect.height


def _apart(placed: Iterable[_Placed]) -> Iterator[list[_Placed]]:
    """The jobs in order, in groups whose rectangles do not overlap."""
    together: list[_Placed] = []
    for job, rect in placed:
        if any(rect.overlaps(other) for _, other in together):
            yield together
            together = []
        together.append((job, rect))
    if together:
        yield together


def _region(job: Job, rect: Rect, weight: np.ndarray, coding: Coding) -> PaintedRegion:
    a, b, x, c, d, y = Affine.from_array(job.surface.grid.to_px)
    along, across = math.hypot(a, c), math.hypot(b, d)  # px of a step on the grid
    turn = (a / along, b / across), (c / along, d / across)
    to_grid = Affine(a, b, x - rect.x, c, d, y - rect.y).inverse()
    # the surface's own axes, in units of the eyes' distance
    units = [along / job.skin_px] * 3 + [across / job.skin_px] * 3
    to_skin = [number * unit for number, unit in zip(to_grid, units, strict=True)]
    axes = SkinAxes(turn, job.skin_px)

    def made(coat: WornCoat) -> Material:
        return material(
            coat.product, coat.strength * job.amount, job.light, axes, coding, coat.kind.spared,
            job.shade, coat.kind.keep_highlights,
        )  # fmt: skip

    lit, materials, layers = job.part.lit, [made(coat) for coat in job.coats], None
    product = materials[0]
    if job.part.shares is not None:
        layers, product = blend(job.part.shares, materials)
    mirrors = max(job.coats, key=lambda coat: coat.product.reflection)
    return PaintedRegion(
        rect, weight, lit.shading, job.surface.normals, to_grid, lit.mean, to_skin,
        environment_of(job.light, mirrors.product, coding), product, layers,
    )  # fmt: skip
