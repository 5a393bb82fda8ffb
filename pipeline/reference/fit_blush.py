"""Fits a blush to the cheeks of a photo: the shape and colour that would make bare cheeks look most
like them."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from makeup_video.pipeline.look.finishes import product
from makeup_video.pipeline.look.kinds import KINDS
from makeup_video.pipeline.look.kinds.fields import FaceFields
from makeup_video.pipeline.look.look import Layer
from makeup_video.pipeline.reference.cheeks import COVER, RESPONSE, Cheeks
from makeup_video.pipeline.reference.neutral_face import LUMINANCE, NeutralFace
from makeup_video.pipeline.reference.typical_skin import TypicalSkin

_OPACITY = 0.5
_LEAST_RED = 0.02  # by how much more red than green it leaves, in roots of shares of skin
# By how much more blue than red it leaves a cheek that is no lighter than that: no light does both.
_LEAST_BLUE, _MOST_LIT = 0.2, 0.03
_DARKER = 0.02  # by how much a blue blush darkens at least
_OLIVE = 0.9  # less red than this for what it yellows would be an olive or a ruddy cheek
# What keeps the light on the cheeks at that of plain skin: for a blush as it stands out from plain
# skin, and from the cheek around it.
_EVEN = (1.5, 0.2)
_DARKEST = 0.1  # light on the cheeks, as a share of the one on plain skin
_STIFF = 1e-4  # keeps the product's root at that of skin
# Blush is painted more vivid and lighter than it is fitted: it fades over half of its place.
_VIVID, _LIGHTEN = 1.2, 0.2
_STANDS_OUT = 1.5  # more vivid still: part of a blush is taken for light
# How much of what a red blush yellows is kept: on skin that is warmer than the photo's it would be
# orange.
_YELLOWS = 0.4
# A blush that is worn and hardly seen reddens by that at least, as most blushes do: the roots that
# a rose of opacity 1 adds to those of skin.
_REDDENS, _ROSE = 0.12, np.array([-0.12, -0.55, -0.48])
_LEAST_WEIGHT = 0.5  # about ten nodes of skin
_KIND = KINDS["blush"]


def fit_blush(
    neutral: NeutralFace, cheeks: Cheeks | None, shape: Mapping[str, float]
) -> list[Layer]:
    """A blush of a given shape with the colour that fits; none where no cheek is seen."""
    skin = TypicalSkin.of(neutral)
    roots = None
    if cheeks is not None:
        roots = _colour(replace(cheeks, roots=skin.roots(cheeks.roots)), shape, skin.most())
    if roots is None:
        return []
    worn = product(skin.codes(roots), _KIND.first_finish, _KIND.part)
    return [Layer("blush", replace(worn, opacity=_OPACITY), dict(shape))]


def _colour(cheeks: Cheeks, shape: Mapping[str, float], most: np.ndarray) -> np.ndarray | None:
    """(3,) roots of the product; None where nothing like blush is seen.

    Blush stands out from the cheek around it, where a ruddy or sallow cheek does not.
    """
    film, weights = cheeks.film(), cheeks.made_up()
    dense = _OPACITY * density(cheeks, shape)
    if float((weights * (dense * film.response) ** 2).sum()) < _LEAST_WEIGHT:
        return None
    bare = np.einsum("hw,hwc->c", weights * dense, film.bare) / float((weights * dense).sum())
    beside_skin, beside_cheek = (
        _VIVID * (RESPONSE * _root(cheeks, dense, even) - COVER * bare) for even in _EVEN
    )
    change = _blue(beside_skin)
    if change is None and (around := _red(beside_cheek)) is not None:
        change = _red(beside_skin)
        if change is None or change[0] - change[1] < around[0] - around[1]:
            light = float(around @ LUMINANCE)
            change = light + _STANDS_OUT * (around - light)
    elif change is None:
        change = _blue(beside_cheek)
    if change is None:
        return None
    change = _rosy(change)
    within: np.ndarray = np.clip((COVER * bare + change) / RESPONSE, 0, most)
    return within


def _root(cheeks: Cheeks, dense: np.ndarray, even: float) -> np.ndarray:
    """(3,) roots of the product, by weighted least squares over the nodes.

    The light on the cheeks is fitted as well, a share of each channel: cheeks are often lighter
    than the skin that the face is compared with, or in the warm light of a lamp from the side.
    even: what keeps that light at the one on plain skin.
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
    """What a blue or violet blush adds to the roots of a cheek, never light; None for another."""
    lighter = float(change @ LUMINANCE)
    if lighter > _MOST_LIT or change[2] <= max(float(change[0]) + _LEAST_BLUE, 0.0):
        return None
    darker: np.ndarray = change - max(lighter + _DARKER, 0.0)
    return darker


def _red(change: np.ndarray) -> np.ndarray | None:
    """What a blush that reddens adds to the roots of a cheek, never light, and only part of what
    it takes: cheeks in strong light are paler than plain skin, and would be chalk; None for another
    colour."""
    lighter = float(change @ LUMINANCE)
    change = change - max(lighter, float(change.max()) / 2, 0.0) + _LIGHTEN * max(-lighter, 0.0)
    if change[0] - change[1] < max(_LEAST_RED, (change[1] - change[2]) * _OLIVE):
        return None
    return change


def _rosy(change: np.ndarray) -> np.ndarray:
    """What a blush adds to the roots of a cheek: a red one yellows less and is never quite pale."""
    red, green, blue = change.tolist()
    if blue > red:
        return change
    rose = max(_REDDENS - (red - green), 0.0) / float(_ROSE[0] - _ROSE[1]) * _ROSE
    if blue < green:
        blue = green + _YELLOWS * (blue - green)
    rosy: np.ndarray = np.array([red, green, blue]) + rose
    return rosy


def density(cheeks: Cheeks, shape: Mapping[str, float]) -> np.ndarray:
    """(40, 40) float32: how densely a blush lies on each node, 0..1."""
    plain = product(_KIND.first_rgb, _KIND.first_finish, _KIND.part)
    fields = FaceFields(cheeks.across[None], cheeks.down[None])
    (coat,) = _KIND.coats(fields, plain, _KIND.whole_shape(shape))
    dense = np.ones(1, np.float32) if coat.density is None else coat.density
    on_nodes: np.ndarray = np.broadcast_to(dense, (1, *cheeks.skin.shape))[0]
    return on_nodes
