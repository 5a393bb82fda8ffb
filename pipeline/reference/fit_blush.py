"""Fits a blush to the cheeks of a photo, so that bare cheeks painted with it look most like them.

"Root" means a square root of light as a share of skin (product_film.py). What a blush "adds to the
roots" may be below 0. A blush "reddens" by how much more it adds to red than to green, "blues" by
how much more it adds to blue than to green, and "yellows" where it adds less to blue than to green.
"""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from makeup_video.pipeline.look.finishes import product
from makeup_video.pipeline.look.kinds import KINDS
from makeup_video.pipeline.look.look import Layer
from makeup_video.pipeline.reference.cheeks import COVER, RESPONSE, Cheeks, density
from makeup_video.pipeline.reference.flush import Flush, find_flush
from makeup_video.pipeline.reference.neutral_face import LUMINANCE, NeutralFace
from makeup_video.pipeline.reference.product_film import likely_share
from makeup_video.pipeline.reference.typical_skin import TypicalSkin

_OPACITY = 0.5
_ALL_FROM = 0.3  # from this probability of blush on, all of the opacity is painted
_UNLIKELY_SHARE = 0.6  # share of the opacity that a hardly likely blush gets
_OWN_HUE = 0.4  # share of the photo's own skin hue, as of TypicalSkin
_LEAST_RED = 0.02  # a red blush reddens at least this much
_LEAST_BLUE = 0.2  # a blue blush adds at least this much more to blue than to red
_MOST_LIT = 0.03  # a cheek that is bluer and lighter than this shows light, not a blue blush
_DARKER = 0.02  # a blue blush darkens at least this much
_OLIVE = 0.9  # reddening by less than this share of the yellowing: an olive or ruddy cheek instead
# The weights that keep the light on the cheeks near the light on plain skin: for a blush that
# stands out from plain skin, and for one that stands out from the cheek around it.
_EVEN = (2.5, 0.2)
_DARKEST = 0.1  # least light on the cheeks, as a share of the light on plain skin
_STIFF = 1e-4  # the weight that keeps the product's root near that of skin
# Blush is painted more vivid and lighter than it is fitted, since it fades over half of its place.
_VIVID = 1.1  # times as vivid
_LIGHTEN = 0.15  # share of its darkening that is given back
_STANDS_OUT = 1.4  # times as vivid against the cheek around it: part of a blush counts as light
# The share of a red blush's yellowing that is kept. All of it would look orange on skin that is
# warmer than the photo's.
_YELLOWS = 0.45
_BLUES = 0.05  # for the same reason a rose blues more, by this share of its reddening
_YELLOW = 0.15  # a blush that yellows by more than this share is orange, and does not blue more
_REDDENS = 0.12  # a worn blush that is hardly seen reddens at least this much, as most do
_ROSE = np.array([-0.12, -0.55, -0.48])  # what a rose of opacity 1 adds to the roots of skin
# The rest is for a blush that stands out from the cheek around it. At opacity 1 it reddens by _TINT
# times the power _FAINTER of its red in Flush: faint blush is painted more vivid than it is seen,
# strong blush less vivid.
_TINT = 0.68
_FAINTER = 0.6
_LEAST_PATCH = 0.1  # a patch that reddens less is no blush
_MOST_RED = 0.45  # a patch is painted with at most this reddening
_DARK = -0.25  # what a dark blush such as a contour adds to the luminance of roots, at most
_DARKENS = 0.35  # a patch darkens at least by this share of its reddening
# The hue of a patch is its bluing as a share of its reddening.
_COOLER = 0.1  # added to the hue of a blush that only the cheek around it shows
_ORANGE, _LILAC = -0.8, 0.6  # the least and the greatest hue
_RUDDY = -0.4  # a patch of a lower hue that does not show beside plain skin is no blush
_LEAST_WEIGHT = 0.5  # about ten nodes of skin
_KIND = KINDS["blush"]


def fit_blush(
    neutral: NeutralFace,
    cheeks: Cheeks | None,
    shape: Mapping[str, float],
    probability: float = 1.0,
) -> list[Layer]:
    """The blush that fits; an empty list when nothing like blush is seen.

    shape: the dials that a net read, used unless the blush stands out from the cheek around it in
    another shape.  probability: that blush is worn; the less likely, the sheerer it is painted.
    """
    skin = TypicalSkin.of(neutral, _OWN_HUE)
    found = None
    if cheeks is not None:
        found = _fitted(replace(cheeks, roots=skin.roots(cheeks.roots)), shape, skin.most())
    if found is None:
        return []
    roots, shape = found
    worn = product(skin.codes(roots), _KIND.first_finish, _KIND.part)
    opacity = round(_OPACITY * likely_share(probability, _ALL_FROM, _UNLIKELY_SHARE), 3)
    return [Layer("blush", replace(worn, opacity=opacity), dict(shape))]


def _fitted(
    cheeks: Cheeks, shape: Mapping[str, float], most: np.ndarray
) -> tuple[np.ndarray, Mapping[str, float]] | None:
    """(3,) roots of the product, and its shape; None when nothing like blush is seen."""
    bare = _bare_below(cheeks, shape)
    if bare is None:
        return None
    change, flush = _beside_skin(cheeks, shape, bare), find_flush(cheeks)
    if flush is not None and (patch := _patch(flush, change)) is not None:
        change, shape = patch, flush.shape
        bare = _bare_below(cheeks, shape)
    if change is None or bare is None:
        return None
    return np.clip((COVER * bare + _rosy(change)) / RESPONSE, 0, most), shape


def _bare_below(cheeks: Cheeks, shape: Mapping[str, float]) -> np.ndarray | None:
    """(3,) the mean root of bare cheeks where a blush lies; None if hardly any of it is seen."""
    weights, dense = cheeks.made_up(), _OPACITY * density(cheeks, shape)
    if float((weights * (dense * RESPONSE) ** 2).sum()) < _LEAST_WEIGHT:
        return None
    total = float((weights * dense).sum())
    bare: np.ndarray = np.einsum("hw,hwc->c", weights * dense, cheeks.film().bare) / total
    return bare


def _beside_skin(cheeks: Cheeks, shape: Mapping[str, float], bare: np.ndarray) -> np.ndarray | None:
    """(3,) what a blush of a given shape adds to the roots of cheeks, compared with plain skin.

    None when nothing like blush is seen: a red blush must also stand out from the cheek around it,
    which a ruddy or sallow cheek does not.
    """
    dense = _OPACITY * density(cheeks, shape)
    beside_skin, beside_cheek = (
        _VIVID * (RESPONSE * _root(cheeks, dense, even) - COVER * bare) for even in _EVEN
    )
    if (blue := _blue(beside_skin)) is not None:
        return blue
    around = _red(beside_cheek)
    if around is None:
        return _blue(beside_cheek)
    change = _red(beside_skin)
    if change is None or change[0] - change[1] < around[0] - around[1]:
        light = float(around @ LUMINANCE)
        change = light + _STANDS_OUT * (around - light)
    return change


def _patch(flush: Flush, change: np.ndarray | None) -> np.ndarray | None:
    """(3,) what a blush that stands out from the cheek around it adds to the roots of cheeks.

    change: what the blush adds beside plain skin, as of _beside_skin.
    None when the blush shows more clearly beside plain skin, as dark and blue blush does, or when
    it is no blush.
    """
    red, beside, light = min(_TINT * flush.red**_FAINTER, _MOST_RED), 0.0, 0.0
    if change is not None:
        beside, light = float(change[0] - change[1]), float(change @ LUMINANCE)
        if change[2] > change[0] + _LEAST_BLUE or light < _DARK:
            return None
    if red <= max(beside, _LEAST_PATCH):
        return None
    hue = flush.blue / flush.red
    if change is None and hue < _RUDDY:
        return None
    if change is not None and beside > 0:
        hue = (hue + min(max(float(change[2] - change[1]) / beside, -1.0), 1.0)) / 2
    else:
        hue += _COOLER
    tint = red * np.array([1.0, 0.0, min(max(hue, _ORANGE), _LILAC)])
    patch: np.ndarray = tint - tint @ LUMINANCE + min(light, -_DARKENS * red)
    return patch


def _root(cheeks: Cheeks, dense: np.ndarray, even: float) -> np.ndarray:
    """(3,) roots of the product, by weighted least squares over the nodes.

    The light on the cheeks is fitted as well, as a factor for each channel: cheeks are often
    lighter than plain skin elsewhere on the face, or in the warm light of a lamp from the side.
    even: the weight that keeps this factor near 1.
    """
    film, weights = cheeks.film(), cheeks.made_up()
    left = film.bare * (1 - dense * film.cover)[..., None]
    kept = float(weights.sum()) * np.array([even, _STIFF])
    roots = np.empty(3)
    for channel in range(3):
        parts = np.stack([left[..., channel], dense * film.response])
        normal = np.einsum("ihw,jhw,hw->ij", parts, parts, weights)
        shown = np.einsum("ihw,hw,hw->i", parts, cheeks.roots[..., channel], weights)
        light, root = np.linalg.solve(normal + np.diag(kept), shown + kept)
        roots[channel] = root / max(light, _DARKEST)
    return roots


def _blue(change: np.ndarray) -> np.ndarray | None:
    """What a blue or violet blush adds to a cheek's roots, never light; None for other colours."""
    lighter = float(change @ LUMINANCE)
    if lighter > _MOST_LIT or change[2] <= max(float(change[0]) + _LEAST_BLUE, 0.0):
        return None
    darker: np.ndarray = change - max(lighter + _DARKER, 0.0)
    return darker


def _red(change: np.ndarray) -> np.ndarray | None:
    """What a blush that reddens adds to the roots of a cheek; None for other colours.

    The blush never adds light: cheeks in strong light are paler than plain skin, and would come out
    chalky. Part of its darkening is given back.
    """
    lighter = float(change @ LUMINANCE)
    change = change - max(lighter, float(change.max()) / 2, 0.0) + _LIGHTEN * max(-lighter, 0.0)
    if change[0] - change[1] < max(_LEAST_RED, (change[1] - change[2]) * _OLIVE):
        return None
    return change


def _rosy(change: np.ndarray) -> np.ndarray:
    """What a blush adds, changed so that a red one yellows less, blues more, and is never faint."""
    red, green, blue = change.tolist()
    if blue > red:
        return change
    rose = max(_REDDENS - (red - green), 0.0) / float(_ROSE[0] - _ROSE[1]) * _ROSE
    if blue < green:
        blue = green + _YELLOWS * (blue - green)
    if red > green:
        yellow = max(green - blue, 0.0) / (red - green)
        blue += _BLUES * (red - green) * max(1 - yellow / _YELLOW, 0.0)
    rosy: np.ndarray = np.array([red, green, blue]) + rose
    return rosy
