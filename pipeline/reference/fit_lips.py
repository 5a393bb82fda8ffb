"""Fits a lipstick's colour to the lips of a photo: painted on bare lips, it would show as they do.

The net that reads a lipstick's numbers was trained on painted faces. In real photos its colours are
paler and greyer than those on the lips, and its gloss is chance; only its roughness of the gloss is
kept, and a little of the reflection. How a lipstick shines and fades is read by a net of its own
(read_lipstick.py); highlights may show more gloss, and the lips laid flat whether there is a darker
rim.
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

# Bare lips, as training/worn/bare_skin.py measures, and how lipstick of opacity 1 shows on them, by
# what comes across best of real photos (docs/decisions/reference.md).
FILM = ProductFilm(np.array([0.749, 0.613, 0.678]), np.array(0.92), np.array(0.87))
_CERTAIN = 0.9  # least weight of the px that count
_LEAST_PX = 30  # least number of such px
# Percentiles of their light, between which they show the lipstick: lighter ones have highlights. By
# the median of all, lips looked too pale in a blind choice.
_SHOWN_PERCENTILES = 30, 60
_CONTRAST = 0.1  # of roots between a lipstick and bare lips, from which on it is opaque
_LEAST_OPACITY, _MOST_OPACITY = 0.85, 1.0
_MOST_REFLECTION = 0.05
_ROUGHEST = 0.4  # rougher gloss is a veil, and what is seen are highlights
# Percentiles of the lips' pixels, by their faintest channel, whose difference shows highlights.
_HIGHLIGHT_PERCENTILES = 75, 99
_MATTE = 0.07  # the difference, in linear light, up to which lips are matte
_GLOSSY = 0.16  # by how much more painted lips with a gloss of 1 differ
_MOST_GLOSS = 1.2
_PALE = 60.0  # L* on typical skin above which a lipstick is pale
_PALER = 0.5  # what is kept of the L* beyond that
_OWN_HUE = 0.8  # of the photo's skin, as of TypicalSkin: with less a rose is coral, a brown a mauve
# The least gradient of light lipstick that may not be worn: a border where bare lips have none
# looks drawn on. All of it from the second L* on, and up to the first probability.
_SOFT = 0.3
_LIGHT, _UNSURE = (52.0, 57.0), (0.75, 0.9)
_THINNER = 0.37  # how much less the median of painted lips shows, for the square of the gradient
# How light and red the border of an even lipstick is beside its middle, in CIELAB: the median of
# 141 photos.
_EVEN = np.array([3.5, -3.4, 0.6])
_HARDLY_DARKER = 4.0  # by how much darker than that, in L*, a border is still no rim
_DARKER = 6.0  # by how much more it is a whole one
_FAINTEST = 1e-6
_NARROW = 2.5  # how many times as much a rim differs as is seen, since it is narrow
_DARKEST_RIM = 0.5  # of the lipstick's L*: darker ones would stand out as a black outline
# Taken off the lips' roots for gloss 1 whose light is white: half of what it adds to their median.
# With all of it lips came out too dark in a blind choice.
_SHINE = 0.015


def lip_pixels(neutral: NeutralFace) -> np.ndarray | None:
    """(N, 3) linear R, G, B of what is surely lips; None where hardly any are seen."""
    pixels: np.ndarray = neutral.linear[lip_mask(neutral.rgb8, neutral.face) > _CERTAIN]
    return pixels if len(pixels) >= _LEAST_PX else None


def shown_by_lips(neutral: NeutralFace, pixels: np.ndarray) -> np.ndarray:
    """(3,) what a lipstick is fitted to: the mean root of the lips' share of skin, where they are
    neither dark nor light.

    pixels: as of lip_pixels.
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
    """The lipstick with the colour and the opacity that fit, and the finish nearest to both.

    pixels: as of lip_pixels.  lips: as the net reads it; kept where hardly any lips are seen.
    flat: the lips laid flat.  form: how the lipstick shines and fades.  probability: that it is
    worn; the less likely, the softer the border of a light one.
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
    """Of a lipstick of this L* on typical skin, worn with this probability."""
    return _SOFT * ramp(lightness, _LIGHT) * (1 - ramp(probability, _UNSURE))


def _gloss(pixels: np.ndarray) -> float:
    """The gloss whose highlights, painted, stand out from the lips as these do."""
    bright, high = np.percentile(pixels.min(1), _HIGHLIGHT_PERCENTILES)
    return min(max((float(high - bright) - _MATTE) / _GLOSSY, 0.0), _MOST_GLOSS)


def _rim(
    skin: TypicalSkin, lipstick: GraphicsParams, roots: np.ndarray, bands: np.ndarray
) -> dict[str, Any]:
    """The dials of a darker rim; none for a lipstick that is even.

    roots: (3,) of the lipstick.  bands: as of FlatLips.
    """
    border, further_in = skin.lab(skin.roots(bands))
    off = border - further_in - _EVEN
    rim = min((-float(off[0]) - _HARDLY_DARKER) / _DARKER, 1.0)
    if rim <= 0:
        return {}
    lips = skin.lab(roots)
    rim_lab = lips + _NARROW * off
    rim_lab[0] = max(rim_lab[0], _DARKEST_RIM * lips[0])
    # brown liner around pale lips would be bright red
    vivid = float(np.linalg.norm(rim_lab[1:]))
    rim_lab[1:] *= min(float(np.linalg.norm(lips[1:])) / max(vivid, _FAINTEST), 1.0)
    red, green, blue = skin.codes(skin.roots_of(rim_lab))
    darker = replace(lipstick, red=red, green=green, blue=blue)
    return {"rim": round(rim, 3), "rim_color": darker.hex}


def _no_chalk(skin: TypicalSkin, roots: np.ndarray) -> np.ndarray:
    """Roots of lips (3,), less light where hardly any lipstick is as light: then plain skin was
    taken for darker than it is, as under hair or in the shadow of a hat."""
    lab = skin.lab(roots)
    lab[0] = min(lab[0], _PALE + _PALER * (lab[0] - _PALE))
    return skin.roots_of(lab)
