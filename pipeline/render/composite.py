"""FrameScene -> Frame: lays the look on the planes. Bytes outside every mask stay the decoder's."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from functools import partial

import numpy as np
from makeup_video.kernels.paint import Canvas
from makeup_video.kernels.planes import Rect
from makeup_video.pipeline.engine.quality import QualityLevel
from makeup_video.pipeline.frames.frame import Frame
from makeup_video.pipeline.look.look import Look
from makeup_video.pipeline.render.coats import Group, PaintJob, groups_of, jobs_of, scaled
from makeup_video.pipeline.render.half_resolution import (
    LARGE_PX,
    SmallPlanes,
    small_size,
    to_small,
)
from makeup_video.pipeline.render.opencl import open_device
from makeup_video.pipeline.render.products import PlacedJob, made_regions
from makeup_video.pipeline.render.scene import FaceScene, FrameScene
from makeup_video.pipeline.render.surfaces.region import Reader

_MUCH_LARGER = 1.3  # ratio of areas from which another face takes the makeup over
# Luma px of a rect from which on a veil is painted at half size, and at a quarter.
_VEIL_PX, _LARGE_VEIL_PX = 8_000, 32_000
_STAYS_SMALL = 0.8  # share of LARGE_PX down to which painting stays at half size


def open_canvas(device: str = "") -> Canvas:
    """A canvas on a device, for one thread. Raises as open_device does."""
    return Canvas(open_device(device))


class Composite:
    """Paints `look` on every frame.

    device: see open_device; or a canvas, which several Composites of one thread may share.
    faces: all, largest, or a face's number.
    painted_frames: how many frames had a face that was painted.
    painted_areas: which areas of faces were painted, as Kind.must_see names them.
    chosen_frames: how many frames had a face that `faces` chose, whether or not its lips and lids
    were seen.
    numbers: the ids of all faces seen.  largest_id: the face that was last painted as the largest.
    level: may be set between two frames. At LESS_DETAIL large regions are painted at half size.
    Raises as open_device does.
    """

    def __init__(self, look: Look, device: str | Canvas = "", faces: str = "all") -> None:
        self._canvas = open_canvas(device) if isinstance(device, str) else device
        self._reader = Reader(self._canvas.device)
        self.faces = faces
        self.largest_id: int | None = None
        self.painted_frames = self.chosen_frames = 0
        self.painted_areas: set[str] = set()
        self.numbers: set[int] = set()
        self.level = QualityLevel.FULL
        self._small = {factor: SmallPlanes(factor) for factor in (2, 4)}
        self._is_small = False
        self.set_look(look)

    def forget(self) -> None:
        """Forget the faces of the frames so far: another video begins."""
        self.largest_id = None
        self._reader.kept.clear()

    def set_look(self, look: Look) -> None:
        """Paint this look from the next frame on."""
        self.look = look
        self._groups = groups_of(look.painted)

    def __call__(self, item: FrameScene) -> Frame:
        chosen = self._chosen(item.faces)
        self.numbers.update(scene.face.track_id for scene in item.faces)
        self.chosen_frames += bool(chosen)
        # read once: another thread may set a new look while this frame is painted
        areas = self._paint_faces(item, chosen, self._groups)
        self.painted_frames += bool(areas)
        self.painted_areas |= areas
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
    ) -> set[str]:
        """Paint the layers of a look on some faces. Returns the areas that were painted."""
        if not groups or len(item.frame.planes) < 2:  # a grey frame holds no colour
            return set()
        jobs = self._jobs(item, faces, groups)
        if not jobs:
            return set()
        planes = item.frame.writable_planes()
        size = item.frame.width_px, item.frame.height_px
        on_frame = list(_placed(jobs, size, item.frame.chroma))
        placed: list[PlacedJob] = []
        for job, rect in on_frame:
            # a veil has no detail to lose; veils are first in the order of painting, so they may be
            # painted before all other jobs
            if job.is_veil and _area_px(rect) > _VEIL_PX:
                self._paint_small(item, planes, [job], 4 if _area_px(rect) > _LARGE_VEIL_PX else 2)
            else:
                placed.append((job, rect))
        area_px = sum(_area_px(rect) for _, rect in placed)
        # hysteresis: otherwise the glitter would flicker between the two sizes
        least_px = _STAYS_SMALL * LARGE_PX if self._is_small else LARGE_PX
        self._is_small = self.level >= QualityLevel.LESS_DETAIL and area_px >= least_px
        if self._is_small:
            self._paint_small(item, planes, [job for job, _ in placed], 2)
        else:
            for together in _apart(placed):
                self._paint(item, together, planes)
        return {coat.kind.must_see for job, _ in on_frame for coat in job.part.coats}

    def _jobs(
        self, item: FrameScene, faces: tuple[FaceScene, ...], groups: list[Group]
    ) -> list[PaintJob]:
        """All that there is to paint: every surface is read before anything is painted."""
        kept = self._reader.kept
        if item.cut:
            kept.clear()
        jobs = [job for scene in faces for job in jobs_of(item, scene, groups, self._reader)]
        kept.forget(item.frame.seconds)
        return jobs

    def _chosen(self, faces: tuple[FaceScene, ...]) -> tuple[FaceScene, ...]:
        if self.faces == "all":
            return faces
        if self.faces == "largest":
            return self._largest(faces)
        return tuple(scene for scene in faces if str(scene.face.track_id) == self.faces)

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
        self, item: FrameScene, planes: tuple[np.ndarray, ...], jobs: list[PaintJob], factor: int
    ) -> None:
        size = small_size((item.frame.width_px, item.frame.height_px), factor)
        jobs = [scaled(job, to_small(factor), 1 / factor) for job in jobs]
        small = _placed(jobs, size, item.frame.chroma)
        painter, chroma = self._small[factor], item.frame.chroma
        for together in _apart(small):
            rects = [pile.rect for pile in together]
            paint = partial(self._paint, item, together)
            painter.paint(planes, rects, chroma, item.coding.max_code, paint)

    def _paint(
        self, item: FrameScene, piles: list["_Pile"], planes: tuple[np.ndarray, ...]
    ) -> None:
        rects, counts = [pile.rect for pile in piles], [len(pile.placed) for pile in piles]
        weights = self._canvas.place(rects, item.frame.chroma, planes[0].dtype, counts)
        jobs = [(pile.rect, job, own) for pile in piles for job, own in pile.placed]
        lines = [
            (number, own, job.line()) for number, (_, job, own) in enumerate(jobs) if job.is_line
        ]
        if lines:
            self._canvas.draw(lines)
        for (rect, job, own), weight in zip(jobs, weights, strict=True):
            if not job.is_line:
                job.weigh(rect.part(weight, own), (own.x, own.y))
        placed = [(job, rect) for rect, job, _ in jobs]
        regions = made_regions(placed, weights, item.coding, self._canvas.device)
        self._canvas.paint(planes, regions, item.coding)


@dataclass(slots=True)
class _Pile:
    """Jobs on one surface, which are painted as coats on one copy of their pixels.

    rect: encloses the rectangles of all jobs.
    """

    rect: Rect
    placed: list[PlacedJob]


def _placed(
    jobs: Iterable[PaintJob], size_wh: tuple[int, int], block: tuple[int, int]
) -> Iterator[PlacedJob]:
    """The jobs that lie on a frame, each with its rectangle."""
    for job in jobs:
        rect = job.rect(size_wh, block)
        if rect is not None:
            yield job, rect


def _area_px(rect: Rect) -> int:
    return rect.width * rect.height


def _apart(placed: Iterable[PlacedJob]) -> Iterator[list[_Pile]]:
    """The jobs in order, piled up by their surface, in groups whose rectangles do not overlap."""
    piles: list[_Pile] = []
    for job, rect in placed:
        own = next((pile for pile in piles if pile.placed[0][0].part.lit is job.part.lit), None)
        whole = rect if own is None else own.rect.joined(rect)
        if any(pile is not own and whole.overlaps(pile.rect) for pile in piles):
            yield piles
            piles, own = [], None
        if own is None:
            piles.append(_Pile(rect, [(job, rect)]))
        else:
            own.rect = whole
            own.placed.append((job, rect))
    if piles:
        yield piles
