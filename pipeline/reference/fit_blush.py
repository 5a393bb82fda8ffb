"""Fits a blush to the cheeks of a photo: the shape and colour that would make bare cheeks look most
like them."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
from makeup_video.kernels.colour import to_xyz
from makeup_video.pipeline.look.finishes import product
from makeup_video.pipeline.look.kinds import KINDS
from makeup_video.pipeline.look.kinds.fields import FaceFields
from makeup_video.pipeline.look.look import Layer
from makeup_video.pipeline.reference.cheeks import COVER, RESPONSE, Cheeks
from makeup_video.pipeline.reference.neutral_face import NeutralFace
from makeup_video.pipeline.reference.typical_skin import TypicalSkin

_OPACITY = 0.5
_LEAST_RED = 0.03  # by how much more red than green it leaves, in roots of shares of skin
# By how much more blue than red it leaves a cheek that is no lighter than that: no light does both.
_LEAST_BLUE, _MOST_LIT = 0.2, 0.03
_DARKER = 0.02  # by how much a blue blush darkens at least
_LUMINANCE = to_xyz(1)[1]  # of linear R, G, B of sRGB
_OLIVE = 0.5  # less red than this for what it yellows would be an olive cheek
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
    """(3,) roots of the product, by weighted least squares over the nodes."""
    film, weights = cheeks.film(), cheeks.made_up()
    dense = _OPACITY * density(cheeks, shape)
    added = dense * film.response
    weight = float((weights * added * added).sum())
    if weight < _LEAST_WEIGHT:
        return None
    rest = cheeks.roots - film.bare * (1 - dense * film.cover)[..., None]
    seen: np.ndarray = np.einsum("hw,hwc->c", weights * added, rest) / weight
    bare = np.einsum("hw,hwc->c", weights * dense, film.bare) / float((weights * dense).sum())
    return _as_blush(seen, bare, most)


def _as_blush(roots: np.ndarray, bare: np.ndarray, most: np.ndarray) -> np.ndarray | None:
    """A colour that reddens, or is clearly blue or violet, and never lightens; None for others.

    Cheeks in strong light are paler than plain skin; painted as they are, they would be chalk.
    """
    change = RESPONSE * roots - COVER * bare
    lighter = float(change @ _LUMINANCE)
    if lighter <= _MOST_LIT and change[2] > max(float(change[0]) + _LEAST_BLUE, 0.0):
        change = change - max(lighter + _DARKER, 0.0)
    else:
        change = change - max(lighter, float(change.max()) / 2, 0.0)
        if change[0] - change[1] < max(_LEAST_RED, (change[1] - change[2]) * _OLIVE):
            return None
    within: np.ndarray = np.clip((COVER * bare + change) / RESPONSE, 0, most)
    return within


def density(cheeks: Cheeks, shape: Mapping[str, float]) -> np.ndarray:
    """(40, 40) float32: how densely a blush lies on each node, 0..1."""
    plain = product(_KIND.first_rgb, _KIND.first_finish, _KIND.part)
    fields = FaceFields(cheeks.across[None], cheeks.down[None])
    (coat,) = _KIND.coats(fields, plain, _KIND.whole_shape(shape))
    dense = np.ones(1, np.float32) if coat.density is None else coat.density
    on_nodes: np.ndarray = np.broadcast_to(dense, (1, *cheeks.skin.shape))[0]
    return on_nodes
