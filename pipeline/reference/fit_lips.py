"""Fits a lipstick to the lips of a photo, so that bare lips painted with it would look like them.

The net that reads a lipstick's numbers was trained on painted faces. In real photos its colours are
paler and greyer than those on the lips, and its gloss is chance. Only its roughness of the gloss is
kept, and a little of its reflection. Another net reads how a lipstick shines and fades
(read_lipstick.py). Highlights may show more gloss, and the lips laid flat may show a darker rim.
"""

from dataclasses import replace
from typing import Any

import numpy as np
from makeup_video.pipeline.faces.lip_mask import lip_mask
from makeup_video.pipeline.look.finishes import nearest_finish, product
from makeup_video.pipeline.look.look import Layer
from makeup_video.pipeline.look.params import GraphicsParams
from makeup_video.pipeline.reference.flat_lips import FlatLips
from makeup_video.pipeline.reference.neutral_face import LUMINANCE, NeutralFace
from makeup_video.pipeline.reference.product_film import ProductFilm, ramp
from makeup_video.pipeline.reference.read_lipstick import LipstickForm
from makeup_video.pipeline.reference.typical_skin import TypicalSkin
from makeup_video.pipeline.render.product_material import hue_in_highlight

# Bare lips, as training/worn/bare_skin.py measures them, and how lipstick of opacity 1 shows on
# them. The latter was chosen by which painted lips match real photos best
# (docs/decisions/reference.md).
FILM = ProductFilm(np.array([0.749, 0.613, 0.678]), np.array(0.92), np.array(0.87))
_CERTAIN = 0.9  # pixels with a higher weight in the lip mask count
_LEAST_PX = 30  # least number of such pixels
# The lipstick is measured on pixels whose light lies between these percentiles, since lighter ones
# have highlights. With the median of all pixels, lips looked too pale in a blind choice.
_SHOWN_PERCENTILES = 30, 60
_CONTRAST = 0.1  # from this difference of roots from bare lips on, a lipstick is wholly opaque
_LEAST_OPACITY, _MOST_OPACITY = 0.85, 1.0
_MOST_REFLECTION = 0.05
_ROUGHEST = 0.4  # rougher gloss would be a veil, but photos show highlights
# Percentiles of the faintest channel of the lips' pixels; their difference shows highlights.
_HIGHLIGHT_PERCENTILES = 75, 99
_MATTE = 0.07  # up to this difference, in linear light, lips are matte
_GLOSSY = 0.16  # how much more the percentiles of lips painted with a gloss of 1 differ
_MOST_GLOSS = 1.2
_PALE = 60.0  # a lipstick of a higher L* on typical skin is pale
_PALER = 0.5  # share that is kept of the L* above _PALE
# Share of the photo's own skin hue, as of TypicalSkin. With less, a rose becomes coral, and a brown
# mauve.
_OWN_HUE = 0.8
# The least gradient of a light lipstick that may not be worn: a border where bare lips have none
# looks drawn on. It applies wholly from the second L* on and up to the first probability, and not
# at all below the first L* or above the second probability.
_SOFT = 0.3
_LIGHT, _UNSURE = (52.0, 57.0), (0.75, 0.9)
_THINNER = 0.37  # a gradient lessens what the median of painted lips shows by its square times this
# How the border of an even lipstick differs from the middle, in CIELAB: the median of 141 photos.
_EVEN = np.array([3.5, -3.4, 0.6])
_HARDLY_DARKER = 4.0  # a border that is darker than even by this L* is still no rim
_DARKER = 6.0  # a border that is darker by this much more has a whole rim
_FAINTEST = 1e-6
_NARROW = 2.5  # a rim is painted with this times the difference that is seen, since it is narrow
_DARKEST_RIM = 0.5  # as a share of the lipstick's L*: darker rims would look like a black outline
# Taken off the lips' roots at gloss 1, if the gloss is white: half of what it adds to their median.
# When all of it was taken off, lips came out too dark in a blind choice.
_SHINE = 0.015


def lip_pixels(neutral: NeutralFace) -> np.ndarray | None:
    """(N, 3) linear R, G, B of pixels that surely show lips; None when there are hardly any."""
    pixels: np.ndarray = neutral.linear[lip_mask(neutral.rgb8, neutral.face) > _CERTAIN]
    return pixels if len(pixels) >= _LEAST_PX else None


def shown_by_lips(neutral: NeutralFace, pixels: np.ndarray) -> np.ndarray:
    """(3,) the roots to which a lipstick is fitted: the mean over lips neither dark nor light.

    pixels: from lip_pixels.
    """
    light = pixels @ LUMINANCE
    dark, bright = np.percentile(light, _SHOWN_PERCENTILES)
    middle: np.ndarray = neutral.roots(pixels[(light >= dark) & (light <= bright)]).mean(0)
    return middle


def fit_lips(
    neutral: NeutralFace,
    pixels: np.ndarray | None,
    lips: GraphicsParams,
    flat: FlatLips,
    form: LipstickForm,
    probability: float = 1.0,
) -> Layer:
    """The lipstick with the colour, opacity and shine that fit, and the nearest finish.

    pixels: from lip_pixels.  lips: the lipstick as the net reads it; it is kept unchanged when
    `pixels` is None.
    flat: the lips laid flat.  form: how the lipstick shines and fades.
    probability: that lipstick is worn; the less likely, the softer the border of a light lipstick.
    """
    if pixels is None:
        return Layer("lipstick", lips, {"gradient": form.gradient})
    seen = shown_by_lips(neutral, pixels)
    contrast = float(np.linalg.norm(seen - FILM.bare))
    opacity = min(max(contrast / _CONTRAST, _LEAST_OPACITY), _MOST_OPACITY)
    gloss, reflection = max(form.gloss, _gloss(pixels)), min(lips.reflection, _MOST_REFLECTION)
    roughness = min(lips.gloss_roughness, _ROUGHEST)
    skin = TypicalSkin.of(neutral, _OWN_HUE)
    lips_roots = _no_chalk(skin, skin.roots(seen))
    gradient = max(form.gradient, _least_gradient(float(skin.lab(lips_roots)[0]), probability))
    white = 1 - hue_in_highlight(float(lips_roots**2 * skin.linear @ LUMINANCE))
    matte = lips_roots - _SHINE * min(gloss, 1) * opacity * white
    dense = 1 - _THINNER * gradient * gradient
    roots = np.clip(FILM.product_for(matte, opacity * dense), 0, skin.most())
    finish = nearest_finish(opacity, gloss, roughness, reflection, shimmers=False)
    worn = replace(
        product(skin.codes(roots), finish, "lips"),
        opacity=round(opacity, 3),
        gloss=round(gloss, 3),
        gloss_roughness=roughness,
        reflection=reflection,
    )
    shape: dict[str, Any] = {"gradient": round(gradient, 3)}
    return Layer("lipstick", worn, shape | _rim(skin, worn, roots, flat.bands()))


def _least_gradient(lightness: float, probability: float) -> float:
    """The least gradient of a lipstick of this L* on typical skin, worn with this probability."""
    return _SOFT * ramp(lightness, _LIGHT) * (1 - ramp(probability, _UNSURE))


def _gloss(pixels: np.ndarray) -> float:
    """The gloss with which painted highlights stand out from the lips as these highlights do."""
    bright, high = np.percentile(pixels.min(1), _HIGHLIGHT_PERCENTILES)
    return min(max((float(high - bright) - _MATTE) / _GLOSSY, 0.0), _MOST_GLOSS)


def _rim(
    skin: TypicalSkin, lipstick: GraphicsParams, roots: np.ndarray, bands: np.ndarray
) -> dict[str, Any]:
    """The dials of a darker rim; empty for an even lipstick.

    roots: (3,) of the lipstick.  bands: from FlatLips.bands.
    """
    border, further_in = skin.lab(skin.roots(bands))
    off = border - further_in - _EVEN
    rim = min((-float(off[0]) - _HARDLY_DARKER) / _DARKER, 1.0)
    if rim <= 0:
        return {}
    lips = skin.lab(roots)
    rim_lab = lips + _NARROW * off
    rim_lab[0] = max(rim_lab[0], _DARKEST_RIM * lips[0])
    # no more vivid than the lips: brown liner around pale lips would become bright red
    vivid = float(np.linalg.norm(rim_lab[1:]))
    rim_lab[1:] *= min(float(np.linalg.norm(lips[1:])) / max(vivid, _FAINTEST), 1.0)
    red, green, blue = skin.codes(skin.roots_of(rim_lab))
    darker = replace(lipstick, red=red, green=green, blue=blue)
    return {"rim": round(rim, 3), "rim_color": darker.hex}


def _no_chalk(skin: TypicalSkin, roots: np.ndarray) -> np.ndarray:
    """Roots of lips (3,), darkened if they are lighter than almost any lipstick.

    Lips seem so light when plain skin was measured too dark, as under hair or a hat's shadow.
    """
    lab = skin.lab(roots)
    lab[0] = min(lab[0], _PALE + _PALER * (lab[0] - _PALE))
    return skin.roots_of(lab)
