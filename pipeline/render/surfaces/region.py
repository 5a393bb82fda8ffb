"""What the renderer asks of a region of a face: the lips, the eyes, the whole face."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, Protocol

import numpy as np
from makeup_video.kernels.colour import Coding
from makeup_video.kernels.program import Device
from makeup_video.kernels.surface import FaceSurfaces, GridPlace
from makeup_video.pipeline.faces.face import Face
from makeup_video.pipeline.faces.track_memory import TrackMemory
from makeup_video.pipeline.frames.frame import Frame
from makeup_video.pipeline.render.scene import FaceScene, FrameScene, Lit, SceneLight
from makeup_video.pipeline.render.surfaces.surface import Surface

_FORGET_SECONDS = 1.0
# A surface, the broad light on its grid, (H, W) float32 linear, and that light's mean.
LitSurface = tuple[Surface, np.ndarray, float]


@dataclass(frozen=True, slots=True, eq=False)
class SeenFace:
    """One face of a frame, and the surfaces that kernels/surface.cl made of its lips and lids.

    surfaces: None where neither lips nor lids are seen.
    """

    frame: Frame
    coding: Coding
    face: Face
    surfaces: FaceSurfaces | None


@dataclass(frozen=True, slots=True, eq=False)
class Reader:
    """What a region needs that is read only for some looks.

    device: the device of the calling thread.
    kept: what a region remembers of a track, by the track's number and the region's name.
    """

    device: Device
    kept: TrackMemory[tuple[int, str], Any] = field(
        default_factory=lambda: TrackMemory(_FORGET_SECONDS)
    )


class Region(Protocol):
    """The surfaces of one sort on a face."""

    def lit(self, item: FrameScene, scene: FaceScene, reader: Reader) -> tuple[Lit, ...]:
        """The surfaces that are seen, and the light on them, on the unpainted frame."""
        ...

    def amount(self, scene: FaceScene) -> float:
        """How much of a product is shown, 0..1: less while the region is half hidden."""
        ...

    def shade(self, light: SceneLight, mean: float) -> float:
        """The light on the region as a share of that on the face, 0..1; mean: see LitSurface."""
        ...


class ReadRegion(Region, Protocol):
    """A region that is read in every frame, so that its light can be followed over time."""

    def places(self, face: Face) -> list[GridPlace | None]:
        """Where the grids of its surfaces lie on the frame; None for a surface that is not seen."""
        ...

    def surfaces(
        self, seen: SeenFace, places: Sequence[GridPlace | None]
    ) -> list[LitSurface | None]:
        """The surfaces in the order of their places; None where there is no place."""
        ...
