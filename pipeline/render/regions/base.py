"""What the renderer asks of a region of makeup."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from makeup_video.kernels.colour import Coding
from makeup_video.kernels.surface import FaceSurfaces, GridPlace
from makeup_video.pipeline.faces.face import Face
from makeup_video.pipeline.frames.frame import Frame
from makeup_video.pipeline.render.luminance import luminances
from makeup_video.pipeline.render.scene import SceneLight
from makeup_video.pipeline.render.surface import Surface

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
    """Where one product goes on a face."""

    def places(self, face: Face) -> list[GridPlace | None]:
        """Where the grids of its surfaces lie on the frame; None for a surface that is not seen."""
        ...

    def surfaces(
        self, seen: SeenFace, places: Sequence[GridPlace | None]
    ) -> list[LitSurface | None]:
        """The surfaces in the order of their places; None where there is no place."""
        ...

    def amount(self, face: Face) -> float:
        """How much of the product is shown, 0..1: less while the region is half hidden."""
        ...

    def shade(self, light: SceneLight, mean: float) -> float:
        """The light on the region as a share of that on the face, 0..1; mean: see LitSurface."""
        ...


def lit_in_numpy(seen: SeenFace, surfaces: Sequence[Surface | None]) -> list[LitSurface | None]:
    """Read the light on surfaces that no kernel makes. They lie close together on the face."""
    there = [surface for surface in surfaces if surface is not None]
    if not there:
        return [None for _ in surfaces]
    light = iter(luminances(seen.frame, seen.coding, [surface.grid for surface in there]))
    return [
        None if surface is None else (surface, *surface.shaded(next(light))) for surface in surfaces
    ]
