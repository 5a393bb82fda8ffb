"""Takes the colours of a face to typical skin, so that makeup stands out on others as in the photo.

What people see of makeup is how it differs from skin, in CIELAB. How light skin is in a photo
depends as much on the exposure as on the person, so most of what sets its lightness apart from that
of typical skin is taken to be light. Of its hue each kind of makeup says how much is the person's.
"""

from dataclasses import dataclass

import numpy as np
from makeup_video.kernels.colour import SRGB, to_encoded
from makeup_video.pipeline.look.ciede2000 import lab_of_linear, linear_of_lab
from makeup_video.pipeline.reference.neutral_face import NeutralFace
from makeup_video.pipeline.render.skin_light import TYPICAL_SKIN

_OWN_LIGHT = 0.4  # how much of the difference of L* is the person's: tried between 0 and 1
# Of what skin is darker than that, in L*, that share is the person's: no photo is so underexposed.
_DARK, _OWN_DARK = 12.0, 0.8
_BRIGHT = 1.5  # colours down to one part in so much of the skin's L* show all of the light's hue
_BLACK = 16.0  # what L* lacks to be in proportion to the cube root of light
_FAINTEST = 1e-4


@dataclass(frozen=True, slots=True, eq=False)
class TypicalSkin:
    """Skin (3,), linear R, G, B, that stands for that of a photo, whose own is `seen`."""

    linear: np.ndarray
    seen: np.ndarray

    @classmethod
    def of(cls, neutral: NeutralFace, own_hue: float) -> "TypicalSkin":
        """own_hue: how much of the hue that sets this skin apart is the person's, 0..1."""
        typical = lab_of_linear(np.array(TYPICAL_SKIN))
        off = lab_of_linear(neutral.skin) - typical
        own = np.array([_OWN_LIGHT, own_hue, own_hue]) * off
        own[0] -= (_OWN_DARK - _OWN_LIGHT) * max(-float(off[0]) - _DARK, 0.0)
        return cls(np.maximum(linear_of_lab(typical + own), _FAINTEST), neutral.skin)

    def roots(self, roots: np.ndarray) -> np.ndarray:
        """Roots of shares of the photo's skin (..., 3) -> of this skin: as different in CIELAB.

        The darker a colour is, the less it shows the hue of the light: black stays black. Where the
        photo's skin is too light, all colours lose the same share of their light, as in a shorter
        exposure: reds do not become black.
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
