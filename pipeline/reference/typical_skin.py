"""Transfers the colours of a face to typical skin, so that makeup stands out as in the photo.

People see makeup by how it differs from skin, in CIELAB. How light skin is in a photo depends as
much on the exposure as on the person. So when skin is lighter or darker than typical skin, most of
the difference counts as light. Each kind of makeup decides how much of the difference in hue is the
person's own.
"""

from dataclasses import dataclass

import numpy as np
from makeup_video.kernels.colour import SRGB, to_encoded
from makeup_video.pipeline.look.ciede2000 import lab_of_linear, linear_of_lab
from makeup_video.pipeline.reference.neutral_face import NeutralFace
from makeup_video.pipeline.render.skin_light import TYPICAL_SKIN

_OWN_LIGHT = 0.4  # the share of the difference in L* that is the person's; tried between 0 and 1
# Skin may be darker than typical by more than the first, in L*. Of the excess, the second share is
# the person's, since no photo is so underexposed.
_DARK, _OWN_DARK = 12.0, 0.8
_BRIGHT = 1.5  # a colour whose L* times this reaches the skin's shows all of the light's hue
_BLACK = 16.0  # L* plus this is in proportion to the cube root of light
_FAINTEST = 1e-4


@dataclass(frozen=True, slots=True, eq=False)
class TypicalSkin:
    """Skin that stands for the skin of a photo.

    linear: (3,) its linear R, G, B.  seen: (3,) the linear R, G, B of the photo's own skin.
    """

    linear: np.ndarray
    seen: np.ndarray

    @classmethod
    def of(cls, neutral: NeutralFace, own_hue: float) -> "TypicalSkin":
        """The skin for a face.

        own_hue: the share of the skin's difference in hue that is the person's, 0..1.
        """
        typical = lab_of_linear(np.array(TYPICAL_SKIN))
        off = lab_of_linear(neutral.skin) - typical
        own = np.array([_OWN_LIGHT, own_hue, own_hue]) * off
        own[0] -= (_OWN_DARK - _OWN_LIGHT) * max(-float(off[0]) - _DARK, 0.0)
        return cls(np.maximum(linear_of_lab(typical + own), _FAINTEST), neutral.skin)

    def roots(self, roots: np.ndarray) -> np.ndarray:
        """Roots of shares of the photo's skin (..., 3) -> roots of shares of this skin.

        Each colour differs from this skin, in CIELAB, as it did from the photo's. But the darker a
        colour is, the less it shows the hue of the light, so black stays black. If the photo's skin
        is too light, all colours lose the same share of their light, as in a shorter exposure, so
        reds do not become black.
        """
        lab, skin = lab_of_linear(roots * roots * self.seen), lab_of_linear(self.seen)
        off = lab_of_linear(self.linear) - skin
        moved = np.repeat(np.clip(_BRIGHT * lab[..., :1] / skin[0], 0, 1), 3, axis=-1)
        moved[..., 0] = (lab[..., 0] + _BLACK) / (skin[0] + _BLACK) if off[0] < 0 else 1
        here = linear_of_lab(lab + moved * off)
        shares: np.ndarray = np.sqrt(np.maximum(here, _FAINTEST) / self.linear)
        return shares

    def lab(self, roots: np.ndarray) -> np.ndarray:
        """Roots of shares of this skin (..., 3) -> CIELAB."""
        return lab_of_linear(roots * roots * self.linear)

    def roots_of(self, lab: np.ndarray) -> np.ndarray:
        """CIELAB (..., 3) -> roots of shares of this skin."""
        roots: np.ndarray = np.sqrt(np.maximum(linear_of_lab(lab), 0) / self.linear)
        return roots

    def most(self) -> np.ndarray:
        """(3,) the roots of white."""
        white: np.ndarray = 1 / np.sqrt(self.linear)
        return white

    def codes(self, roots: np.ndarray) -> tuple[float, float, float]:
        """The colour of a product, R'G'B' codes 0..255, from (3,) roots of shares of this skin."""
        linear = np.clip(roots * roots * self.linear, 0, 1)
        red, green, blue = (255 * to_encoded(linear, SRGB)).clip(0, 255).round(3).tolist()
        return red, green, blue
