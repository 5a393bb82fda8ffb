"""Fits a lipstick's colour to the lips of a photo: painted on bare lips, it would show as they do.

The net that reads lipstick was trained on painted faces. In real photos its colours are paler and
greyer than those on the lips, and it takes moist lips for a mirror; of the net's numbers only the
shine is kept, and less of it.
"""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from makeup_video.pipeline.faces.lip_mask import lip_mask
from makeup_video.pipeline.look.ciede2000 import lab_of_linear, linear_of_lab
from makeup_video.pipeline.look.finishes import nearest_finish, product
from makeup_video.pipeline.look.look import Layer
from makeup_video.pipeline.look.params import GraphicsParams
from makeup_video.pipeline.reference.film import Film
from makeup_video.pipeline.reference.neutral_face import NeutralFace
from makeup_video.pipeline.reference.typical_skin import TypicalSkin

# Bare lips, and how lipstick of opacity 1 shows on them, as training/worn/bare_skin.py measures.
FILM = Film(np.array([0.771, 0.639, 0.716]), np.array(0.93), np.array(0.925))
_CERTAIN, _LEAST_PX = 0.9, 30  # least weight of the px that count, and least number of such px
_CONTRAST = 0.25  # of roots between a lipstick and bare lips, from which on it is opaque
_LEAST_OPAQUE, _MOST_OPAQUE = 0.45, 0.95
_MOST_REFLECTION = 0.05
_PALE, _PALER = 60.0, 0.35  # L* on typical skin; what is lighter is lighter by this share of it
# Of the photo's skin, as of TypicalSkin: on tanned skin a brown or beige is no mauve, nor a pink a
# lilac.
_OWN_YELLOW = 1.1
_SHINE = 0.04  # what gloss 1 adds to the roots of the lips' median


def seen_lips(neutral: NeutralFace) -> np.ndarray | None:
    """(3,) the median root of the lips' share of skin; None where hardly any lips are seen."""
    at = lip_mask(neutral.rgb8, neutral.face) > _CERTAIN
    if at.sum() < _LEAST_PX:
        return None
    middle: np.ndarray = np.median(neutral.roots(neutral.linear[at]), axis=0)
    return middle


def fit_lips(
    neutral: NeutralFace,
    seen: np.ndarray | None,
    lips: GraphicsParams,
    shape: Mapping[str, float],
) -> Layer:
    """The lipstick with the colour and the opacity that fit, and the finish nearest to both.

    seen: as of seen_lips.  lips: as the net reads it.  shape: of the layer.
    """
    if seen is None:
        return Layer("lipstick", lips, dict(shape))
    contrast = float(np.linalg.norm(seen - FILM.bare))
    opacity = min(max(contrast / _CONTRAST, _LEAST_OPAQUE), _MOST_OPAQUE)
    gloss, reflection = lips.gloss, min(lips.reflection, _MOST_REFLECTION)
    skin = TypicalSkin.of(neutral, own_yellow=_OWN_YELLOW)
    matte = _no_chalk(skin, skin.roots(seen)) - _SHINE * min(gloss, 1) * opacity
    rgb = skin.codes(np.clip(FILM.product_for(matte, opacity), 0, skin.most()))
    finish = nearest_finish(opacity, gloss, lips.gloss_roughness, reflection, shimmers=False)
    worn = replace(
        product(rgb, finish, "lips"), opacity=round(opacity, 3), gloss=gloss,
        gloss_roughness=lips.gloss_roughness, reflection=reflection,
    )  # fmt: skip
    return Layer("lipstick", worn, dict(shape))


def _no_chalk(skin: TypicalSkin, roots: np.ndarray) -> np.ndarray:
    """Roots of lips (3,), less light where hardly any lipstick is as light: then plain skin was
    taken for darker than it is, as under hair or in the shadow of a hat."""
    lab = lab_of_linear(roots * roots * skin.linear)
    lab[0] = min(lab[0], _PALE + _PALER * (lab[0] - _PALE))
    darker: np.ndarray = np.sqrt(np.maximum(linear_of_lab(lab), 0) / skin.linear)
    return darker
