"""What the renderer knows of a frame: its faces as painted regions, and the light on them."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from makeup_video.kernels.colour import Coding
from makeup_video.kernels.material import ENVIRONMENT_PX
from makeup_video.pipeline.faces.face import Face
from makeup_video.pipeline.frames.frame import Frame
from makeup_video.pipeline.render.surfaces.surface import Surface

# Skin of less luminance than _DARK_SKIN is as often in the dark as it is dark itself: products on
# it get (luminance / _DARK_SKIN) ** _DARKER of the light, at least _LEAST, at most _MOST.
_DARK_SKIN, _DARKER, _LEAST, _MOST = 0.27, 0.9, 0.45, 1.05


@dataclass(frozen=True, slots=True, eq=False)
class SceneLight:
    """The light on one face, in the frame's own primaries.

    colour: (3,) float32, linear; its luminance is 1, and (1, 1, 1) is white light.
    strength: 1 for the light in which a product of colour p shows as p, 0.5 for half that light;
    the most probable one.
    direction: (3,) float32 unit vector from the face to the light, in the axes of points_px (x
    right and y down in the stored picture, z away from the viewer, so the light has z < 0).
    environment: (16, 16, 3) float32, linear light that a mirror held before the face would show:
    the frame, much reduced; rows and columns as in the stored picture.
    skin: luminance of the bare face under this light, linear; 0 when it is not known.
    under_eyes: luminance of the skin right under the eyes, of the brighter side, as a share of
    `skin`, more than 0: far less where dark glasses hide the eyes; 1 when it is not known.
    veil_colour, veil_share: the colour, as `colour`, and the share of the strength, 0..1, of the
    light that soft veils are painted in. On skin that is darker and warmer than pale skin they
    share some of that. None: as `colour`.
    """

    colour: np.ndarray
    strength: float
    direction: np.ndarray
    environment: np.ndarray
    skin: float = 0.0
    under_eyes: float = 1.0
    veil_colour: np.ndarray | None = None
    veil_share: float = 1.0

    def __post_init__(self) -> None:
        shapes = self.colour.shape, self.direction.shape, self.environment.shape
        if shapes != ((3,), (3,), (ENVIRONMENT_PX, ENVIRONMENT_PX, 3)):
            raise ValueError(f"a light has shapes (3,), (3,), (16, 16, 3); got {shapes}")

    @property
    def for_veils(self) -> "SceneLight":
        """The light that soft veils, such as blush, are painted in."""
        if self.veil_colour is None:
            return self
        return replace(self, colour=self.veil_colour, strength=self.strength * self.veil_share)

    @property
    def strength_for_products(self) -> float:
        """The strength that products are painted with: less than `strength` on dark skin.

        Whether a face is dark or in the dark is a guess. Makeup that is too light for its face
        glows, and makeup that is too dark looks like a deeper shade. Nor does it get much more than
        1: pale skin passes for skin in strong light, on which nudes would be chalk and pinks neon.
        """
        strength = min(self.strength, _MOST)
        if self.skin <= 0:
            return strength
        return strength * min(max(math.pow(self.skin / _DARK_SKIN, _DARKER), _LEAST), 1.0)


@dataclass(frozen=True, slots=True, eq=False)
class Lit:
    """A surface and the broad light on it.

    shading: luminance without texture on the surface's grid, (H, W) float32, linear.
    mean: that of the whole surface, smoothed over time.
    """

    surface: Surface
    shading: np.ndarray
    mean: float


@dataclass(frozen=True, slots=True, eq=False)
class FaceScene:
    """One face as the renderer sees it.

    regions: by region the surfaces that are seen, in the order of painting.
    sigma_px: by region how soft the picture is there, px of the frame, see softness.py; a region
    that is missing is sharp.
    """

    face: Face
    light: SceneLight
    regions: Mapping[str, tuple[Lit, ...]]
    sigma_px: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, eq=False)
class FrameScene:
    """A frame, how its codes mean colour, and its faces, largest first; often there are none.

    cut: see FrameFaces.
    """

    frame: Frame
    coding: Coding
    faces: tuple[FaceScene, ...] = ()
    cut: bool = False
