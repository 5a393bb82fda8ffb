"""What the renderer asks of a region of a face: the lips, the eyes, the whole face."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from makeup_video.kernels.colour import Coding
from makeup_video.kernels.program import Device
from makeup_video.kernels.surface import FaceSurfaces, GridPlace
from makeup_video.pipeline.faces.face import Face
from makeup_video.pipeline.frames.frame import Frame
from makeup_video.pipeline.render.scene import FaceScene, FrameScene, Lit, SceneLight
from makeup_video.pipeline.render.surfaces.surface import Surface

# A surface, the broad light on its grid, (H, W) float32 linear, and that light's mean.
LitSurface = tuple[Surface, np.ndarray, float]


@dataclass(frozen=True, slots=True, eq=False)
class SeenFace:
    """One face of a frame, and what kernels/surface.cl made of its lips and lids; None: nothing."""

    frame: Frame
    coding: Coding
    face: Face
    surfaces: FaceSurfaces | None


class Region(Protocol):
    """The surfaces of one sort on a face."""

    def lit(self, item: FrameScene, scene: FaceScene, device: Device) -> tuple[Lit, ...]:
        """The surfaces that are seen, and the light on them, on the unpainted frame.

        device: of the calling thread, for a region that is not read with every frame.
        """
        ...

    def amount(self, face: Face) -> float:
        """How much of a product is shown, 0..1: less while the region is half hidden."""
        ...

    def shade(self, light: SceneLight, mean: float) -> float:
        """The light on the region as a share of that on the face, 0..1; mean: see LitSurface."""
        ...


class ReadRegion(Region, Protocol):
    """A region of which every frame is read, since its light is followed over time."""

    def places(self, face: Face) -> list[GridPlace | None]:
        """Where the grids of its surfaces lie on the frame; None for a surface that is not seen."""
        ...

    def surfaces(
        self, seen: SeenFace, places: Sequence[GridPlace | None]
    ) -> list[LitSurface | None]:
        """The surfaces in the order of their places; None where there is no place."""
        ...
