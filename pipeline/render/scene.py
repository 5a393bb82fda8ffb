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

# Skin of less luminance than _DARK_SKIN is as often in the dark as it is dark itself. Products on
# it get (luminance / _DARK_SKIN) ** _DARKER of the light, at least _LEAST of it. On any skin, light
# is no stronger than _MOST.
_DARK_SKIN, _DARKER, _LEAST, _MOST = 0.27, 0.9, 0.45, 1.05


@dataclass(frozen=True, slots=True, eq=False)
class SceneLight:
    """The light on one face, in the frame's own primaries.

    colour: (3,) float32, linear; its luminance is 1, and (1, 1, 1) is white light.
    strength: the most probable strength: 1 for the light in which a product of colour p shows as p,
    0.5 for half that light.
    direction: (3,) float32 unit vector from the face to the light, in the axes of points_px (x
    right and y down in the stored picture, z away from the viewer, so the light has z < 0).
    environment: (16, 16, 3) float32, linear light that a mirror held before the face would show:
    the frame, much reduced; rows and columns as in the stored picture.
    skin: linear luminance of the bare face under this light; 0 when it is not known.
    under_eyes: luminance of the skin right under the brighter eye, as a share of `skin`, more than
    0. Dark glasses make it small; it is 1 when it is not known.
    veil_colour, veil_share: the light that soft veils are painted in, as a colour like `colour` and
    a share of the strength, 0..1. Veils take on some of what makes skin darker and warmer than pale
    skin. None: the same as `colour`.
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
        glows, but makeup that is too dark only looks like a deeper shade. The strength is also
        limited to little more than 1: pale skin is mistaken for skin in strong light, and on it
        nudes would look like chalk and pinks like neon.
        """
        strength = min(self.strength, _MOST)
        if self.skin <= 0:
            return strength
        return strength * min(max(math.pow(self.skin / _DARK_SKIN, _DARKER), _LEAST), 1.0)


@dataclass(frozen=True, slots=True, eq=False)
class Lit:
    """A surface and the broad light on it.

    shading: (H, W) float32 on the surface's grid, linear luminance without the skin's texture.
    mean: the mean luminance of the surface, smoothed over time.
    """

    surface: Surface
    shading: np.ndarray
    mean: float


@dataclass(frozen=True, slots=True, eq=False)
class FaceScene:
    """One face as the renderer sees it.

    regions: the surfaces that are seen, by region, in the order of painting.
    sigma_px: how soft the picture is, by region, px of the frame, see softness.py; a missing region
    is sharp.
    """

    face: Face
    light: SceneLight
    regions: Mapping[str, tuple[Lit, ...]]
    sigma_px: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True, slots=True, eq=False)
class FrameScene:
    """A frame, how its codes encode colour, and its faces, largest first; often there are none.

    cut: see FrameFaces.
    """

    frame: Frame
    coding: Coding
    faces: tuple[FaceScene, ...] = ()
    cut: bool = False
