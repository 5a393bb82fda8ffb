"""Fits layers of eyeshadow to the skin around the eyes of a photo.

The skin is laid flat (flat_eyes.py), and effects of light rather than makeup are removed. Then the
colours of usual places (first_shadows.py) are spread as the photo shows them (spread_shadows.py),
so each layer has a density map.
"""

import math
from dataclasses import replace

import numpy as np
from makeup_video.pipeline.look.ciede2000 import lab_of_linear
from makeup_video.pipeline.look.finishes import product
from makeup_video.pipeline.look.kinds.density_map import heights, places_across, to_text
from makeup_video.pipeline.look.look import Layer
from makeup_video.pipeline.look.params import GraphicsParams
from makeup_video.pipeline.reference.first_shadows import first_shadows
from makeup_video.pipeline.reference.flat_eyes import flat_places
from makeup_video.pipeline.reference.neutral_face import LUMINANCE, NeutralFace
from makeup_video.pipeline.reference.product_film import likely_share, ramp
from makeup_video.pipeline.reference.shadow_cells import (
    columns_seen,
    on_map,
    shadow_cells,
    slot_of,
)
from makeup_video.pipeline.reference.spread_shadows import Spread, spread
from makeup_video.pipeline.reference.typical_skin import TypicalSkin

# Where a number below has two limits, an effect begins at the first and is complete at the second,
# unless its own comment says otherwise.
_EVENED = 0.8  # how much of the light beyond that of bare eyes counts as light, not as makeup
_VIVID = 0.4  # a colour as light as bare eyes is painted this much more vivid than it is seen
# The probability of eyeshadow between whose limits _VIVID takes effect for warm colours: many bare
# lids are warm, and would become orange.
_SURE = 0.7, 0.95
# In a wholly warm colour, red exceeds green, and green exceeds blue, by this share of the colour's
# distance from bare eyes.
_WARM_HUE = 0.25
_FAINTEST = 1e-6
_PALE = 78.0, 82.0  # L* between which skin becomes pale
_VIVID_FROM = 34.0  # a colour that differs this much from skin, in a* and b*, is vivid
_SOFTER = 12.0  # a colour that differs by this much less is wholly soft
_RED = 8.0  # a colour whose a* exceeds the skin's by this is wholly red
_CALMER = 0.25  # how much less vivid soft reds and browns become beside pale skin
_LESS_YELLOW = 0.3  # soft colours lose this share of their yellow beyond skin: browns were orange
_OWN_HUE = 1.0  # share of the photo's skin hue, as of TypicalSkin: brown stays brown on pale skin
# Below the eye nothing is redder or yellower than this percentile of the lid, which counts up to
# the height _LID_TO.
_WARMEST_PERCENTILE = 75
_LID_TO = 1.4
# Red below the eye stays if this percentile of its a* exceeds that bound by so much. Of bare faces
# 95 % have less than the first limit.
_REDDEST_PERCENTILE, _WORN_BELOW = 90, (6.0, 13.0)
# Cells darker than this share of skin's L* do not count: shadow and lashes are red by themselves.
_SHADE = 0.55
# Beside green, blue and grey lids, red is skin. So red stays only as far as the lid's a*, and then
# its b*, exceed those of skin.
_WARM_LID = (4.0, 10.0), (-3.0, 1.5)
_WARM = 1.0, 1.15  # red divided by blue between which light becomes warm
_DENSE = 0.5  # a product lies in the cells with more than this share of its highest density
# This percentile of a* and of b* over the cells where a product lies is the colour of its "cold
# cells".
_COLD_PERCENTILE = 25
# In warm light no product is colder than this percentile of its cells. If even its cold cells are
# greener or bluer than grey, it may be so many times as cold as they are.
_COLDEST_PERCENTILE = 5
_COLDER = 4.0
_SURELY_WARM = 4.0  # from this a* and b* in the photo's light on, cold cells are a strict bound
# The b* of a product is at least the b* of its cold cells in the photo's light, if below 0, times
# the first, minus the second.
_BLUER, _BLUER_BY = 2.5, 8.0
_ALL_FROM = 0.3  # from this probability of eyeshadow on, all of the opacity is painted
_UNLIKELY_SHARE = 0.6  # share of the opacity that a hardly likely eyeshadow gets
# Black, grey and dark brown have at most this share of skin's luminance, and this chroma.
_DARK, _BLACK_CHROMA = 0.25, 30.0
# Soft reds beside them differ less than the first from skin in a* and b*, and more than the second
# in a*.
_SOFT_CHROMA, _REDDISH = 45.0, 4.0
# If there is more black than the first share of such a red, the second share of its difference is
# kept.
_MUCH_BLACK, _CALM_RIM = 0.5, 0.6
# The least luminance of powder, since its surface reflects light, too. Without this, a black lid
# that shuts would look like a hole.
_BLACK = 0.0116
# Up to this share of typical skin's luminance a product stays matte: shine on it looks like dust.
_MATTE = 0.25
# The luminance of the inner end of the lid and of the skin beside it, as a share of the photo's
# skin: up to the first no shimmer is painted, from the second on all that was measured. Of three
# places that were tried, this one tells best: where it is light, judges preferred shimmer.
_LIGHT_INSIDE = 0.36, 0.42
_INSIDE, _LID = 0.35, (0.3, 1.0)  # the place: distance from the inner corner, and heights
# Colours like brow hair, which fade out above the crease.
_HAIR_DARK = 0.125, 0.25  # shares of skin's luminance: wholly as dark as hair, and not at all
_HAIR_COLD = -15.0  # b* of the bluest of these colours
_HAIR_GREEN = -10.0  # a* of the greenest
_HAIR_VIVID = 35.0  # chroma of the most vivid
_BROW = 1.1, 1.7  # the heights between which they fade out
_MOST_GLOSS = 1.8  # gloss of an eyeshadow with a shimmer of 1
_SPARKLES = 1.4  # sparkles for a shimmer of 1, but never more than the finish "shimmer" has
_SHEEN = 0.07  # share by which a shimmer of 1 darkens the roots, since its sheen adds light
_HARDLY = 0.05  # a layer of at most this opacity is not worth painting
_HARDLY_SHIMMERS = 0.075  # a layer of at most this shimmer is matte


def fit_shadows(
    neutral: NeutralFace,
    seen: np.ndarray | None,
    probability: float = 1.0,
    lined: bool = True,
    winged: bool = False,
    shimmer: float = 0.0,
) -> list[Layer]:
    """The layers of eyeshadow of a face, in the order of painting.

    The list is empty when no eye is seen, or the eyes look bare.
    seen: from mean_eye.
    probability: that eyeshadow is worn; the less likely, the sheerer it is painted.
    lined: whether eyeliner is worn, too.  winged: whether the eyeliner surely has a wing.
    shimmer: 0..1, from lid_shimmer.
    """
    if seen is None:
        return []
    skin = TypicalSkin.of(neutral, _OWN_HUE)
    cells = replace(shadow_cells(), reach=shadow_cells().reach * columns_seen(seen))
    shown = _calm(skin.roots(on_map(seen)), skin, neutral.skin)
    shown = _no_redder_below(_shaded(shown, cells.film.bare, probability), skin)
    first = first_shadows(shown, cells, skin.most())
    found = spread(shown, cells, *first, skin.most(), lined, winged)
    labs_in_photo = lab_of_linear(on_map(seen) ** 2 * neutral.skin * neutral.light)
    found = replace(found, roots=_no_colder(found, shown, labs_in_photo, skin, neutral.light))
    found = replace(found, roots=_no_bluer(found, labs_in_photo, skin))
    found = replace(found, densities=_without_brows(found, skin))
    found = replace(found, roots=_calm_beside_black(found, skin))
    share = likely_share(probability, _ALL_FROM, _UNLIKELY_SHARE)
    return _layers(found, skin, shimmer * ramp(_light_inside(seen), _LIGHT_INSIDE), share)


def _calm(seen: np.ndarray, skin: TypicalSkin, own: np.ndarray) -> np.ndarray:
    """Roots (27, 24, 3) with calmer soft colours: all less yellow, and some less vivid.

    The latter are soft reds and browns beside pale skin. Typical skin is darker, and a colour that
    differs from it by as much in CIELAB is more vivid: rose-brown became orange. Vivid colours do
    not change.  own: (3,) linear, the photo's skin.
    """
    lab, plain, light = skin.lab(seen), skin.lab(np.ones(3)), float(lab_of_linear(own)[0])
    pale = ramp(light, _PALE)
    hue = lab[..., 1:] - plain[1:]
    red = np.clip(hue[..., :1] / _RED, 0, 1)
    hue -= pale * _softness(hue) * red * _CALMER * hue
    hue[..., 1:] -= _LESS_YELLOW * _softness(hue) * np.maximum(hue[..., 1:], 0)
    lab[..., 1:] = plain[1:] + hue
    return skin.roots_of(lab)


def _softness(hue: np.ndarray) -> np.ndarray:
    """(..., 1): 1 for soft colours, 0 for vivid ones.

    hue: (..., 2), how the colours differ from skin in a* and b*.
    """
    soft: np.ndarray = np.clip(
        (_VIVID_FROM - np.linalg.norm(hue, axis=-1, keepdims=True)) / _SOFTER, 0, 1
    )
    return soft


def _shaded(seen: np.ndarray, bare: np.ndarray, probability: float) -> np.ndarray:
    """Roots (27, 24, 3), darker in the same hue where lighter than bare eyes, and more vivid.

    Soft light from the front fills the hollow of the eye. If it counted as a product, it would be a
    pale veil, in which the colour that is worn is lost. Colours become more vivid unless they are
    warm and eyeshadow is not certain. Dark colours hardly change.
    """
    share = np.sqrt((bare**2 @ LUMINANCE) / np.maximum(seen**2 @ LUMINANCE, _FAINTEST))[..., None]
    as_light = bare / share
    off, unsure = seen - as_light, 1 - ramp(probability, _SURE)
    more = _VIVID * (1 - unsure * _warmth(off)) * np.minimum(1 / share, 1) ** 4
    vivid = as_light + (1 + more) * off
    shaded: np.ndarray = np.maximum(vivid * np.minimum(share, 1) ** _EVENED, 0)
    return shaded


def _warmth(off: np.ndarray) -> np.ndarray:
    """(..., 1), 0..1: how warm, like orange or brown, differences of roots (..., 3) are."""
    steps = (off[..., :-1] - off[..., 1:]) / np.maximum(
        _WARM_HUE * np.linalg.norm(off, axis=-1, keepdims=True), _FAINTEST
    )
    warmth: np.ndarray = np.clip(steps, 0, 1).prod(-1, keepdims=True)
    return warmth


def _no_redder_below(seen: np.ndarray, skin: TypicalSkin) -> np.ndarray:
    """Roots (27, 24, 3), which below the eye are limited in red and yellow.

    The limit is most of the lid, or skin where the lid has less: many lower lids are red by
    themselves, and so are rims of glasses. Clearly redder places beside a warm lid are makeup, and
    stay.
    """
    above, across = heights(True), places_across()
    lab, plain = skin.lab(seen), skin.lab(np.ones(3))
    lit = np.maximum(lab[..., :1], _FAINTEST) / plain[0]  # the darker, the less of a hue is meant
    lid = (lab / lit)[: len(above)][np.ix_(above < _LID_TO, (across > 0) & (across < 1))]
    warmest = np.percentile(lid.reshape(-1, 3), _WARMEST_PERCENTILE, axis=0)
    below, lit = lab[len(above) :], lit[len(above) :]
    most = np.maximum(warmest, plain)[1:]
    redder = np.where(lit[..., 0] > _SHADE, below[..., 1] / lit[..., 0] - most[0], 0)
    redder = redder[:, (across > 0.1) & (across < 1.15)]
    is_worn = ramp(float(np.percentile(redder, _REDDEST_PERCENTILE)), _WORN_BELOW)
    for off, warm in zip((warmest - plain)[1:].tolist(), _WARM_LID, strict=True):
        is_worn *= ramp(off, warm)
    bounded = np.minimum(below[..., 1:], most * np.minimum(lit, 1))
    below[..., 1:] = bounded + is_worn * (below[..., 1:] - bounded)
    return np.concatenate([seen[: len(above)], skin.roots_of(below)])


def _no_colder(
    found: Spread, seen: np.ndarray, labs_in_photo: np.ndarray, skin: TypicalSkin, light: np.ndarray
) -> np.ndarray:
    """The roots of the products, (N, 3), hardly greener or bluer than their cells look.

    Warm skin is partly taken for warm light. When that is divided out, black and brown turn blue.
    Two bounds prevent this. The first holds in warm photos. The second holds in every photo, for
    products that look redder and yellower than grey: they stay as red and yellow as they look.
    labs_in_photo: (27, 24, 3), the cells in CIELAB, in full light of the photo's own hue.
    """
    warm = ramp(float(light[0] / light[2]), _WARM)
    roots, labs = found.roots.copy(), skin.lab(seen)
    for root, density in zip(roots, found.densities, strict=True):
        there = density > _DENSE * density.max()
        if not there.any():
            continue
        lab = skin.lab(root)
        percentiles = _COLDEST_PERCENTILE, _COLD_PERCENTILE
        coldest, cold = np.percentile(labs[there], percentiles, axis=0)
        more = warm * np.maximum(np.minimum(coldest, _COLDER * cold) - lab, 0)
        looks = np.percentile(labs_in_photo[there], _COLD_PERCENTILE, axis=0)
        sure = min(max(float(looks[1:].min()) / _SURELY_WARM, 0), 1)
        if sure:
            as_dark = looks * min(lab[0] / looks[0], 1)  # in proportion to L*, so black stays black
            more = np.maximum(more, sure * (as_dark - lab))
        if more[1:].any():
            lab[1:] += more[1:]
            root[:] = skin.roots_of(lab)
    return roots


def _no_bluer(found: Spread, labs_in_photo: np.ndarray, skin: TypicalSkin) -> np.ndarray:
    """The roots of the products, (N, 3), no bluer than a bound from how their cells look.

    The bound holds in any light: otherwise black and white liner, and smoke, turned blue or teal.
    labs_in_photo: as for _no_colder.
    """
    roots = found.roots.copy()
    for root, density in zip(roots, found.densities, strict=True):
        there = density > _DENSE * density.max()
        if not there.any():
            continue
        lab, looks = skin.lab(root), np.percentile(labs_in_photo[there][:, 2], _COLD_PERCENTILE)
        bluest = _BLUER * min(float(looks), 0.0) - _BLUER_BY
        if lab[2] < bluest:
            if lab[2] < lab[1] < 0:
                lab[1] *= bluest / lab[2]  # otherwise teal would become green
            lab[2] = bluest
            root[:] = skin.roots_of(lab)
    return roots


def _without_brows(found: Spread, skin: TypicalSkin) -> np.ndarray:
    """(N, 27, 24): the densities, in which black, grey and brown fade out above the crease.

    Low brows and their shadow lie there, and looked like blotches of smoke.
    """
    above = heights(True)
    low, high = _BROW
    fades = np.clip((high - above) / (high - low), 0, 1)[:, None]
    densities = found.densities.copy()
    for root, density in zip(found.roots, densities, strict=True):
        _, a, b = skin.lab(root).tolist()
        if b > _HAIR_COLD and a > _HAIR_GREEN and math.hypot(a, b) < _HAIR_VIVID:
            first, last = _HAIR_DARK
            like_hair = np.clip((last - root**2 @ LUMINANCE) / (last - first), 0, 1)
            density[: len(above)] *= 1 - like_hair + like_hair * fades
    return densities


def _calm_beside_black(found: Spread, skin: TypicalSkin) -> np.ndarray:
    """The roots of the products, (N, 3); soft reds and browns beside much black are less vivid.

    At the border of black or grey there is shaded skin, which was painted as a red rim.
    """
    labs, plain = skin.lab(found.roots), skin.lab(np.ones(3))
    is_dark = found.roots**2 @ LUMINANCE < _DARK
    is_black = is_dark & (np.linalg.norm(labs[:, 1:], axis=1) < _BLACK_CHROMA)
    amounts = found.opacities * found.densities.sum((1, 2))
    off = labs[:, 1:] - plain[1:]
    calmed = ~is_dark & (off[:, 0] > _REDDISH) & (np.linalg.norm(off, axis=1) < _SOFT_CHROMA)
    calmed &= amounts[is_black].sum() > _MUCH_BLACK * amounts
    labs[calmed, 1:] = plain[1:] + _CALM_RIM * off[calmed]
    return np.where(calmed[:, None], skin.roots_of(labs), found.roots)


def _no_blacker(root: np.ndarray, opacity: float, skin: TypicalSkin) -> tuple[np.ndarray, float]:
    """The root (3,) of a product, made no darker than powder can be, and its new opacity.

    With that opacity, at most 1, the product darkens skin as much as before.
    """
    linear = root * root * skin.linear
    more = max(_BLACK - float(linear @ LUMINANCE), 0.0)
    if not more:
        return root, opacity
    lighter = np.sqrt((linear + more) / skin.linear)
    before, after = (1 - math.sqrt(float(one * one @ LUMINANCE)) for one in (root, lighter))
    return lighter, min(opacity * before / after, 1.0) if after > 0 else opacity


def _light_inside(seen: np.ndarray) -> float:
    """The median luminance around the inner end of the lid, as a share of skin's.

    seen: flat eyes, (27, 48, 3) roots.
    """
    above, from_corner = heights(True), np.abs(flat_places()[0])
    low, high = _LID
    there = np.ix_((above > low) & (above < high), from_corner < _INSIDE)
    return float(np.median((seen**2 @ LUMINANCE)[: len(above)][there]))


def _layers(found: Spread, skin: TypicalSkin, shimmer: float, share: float) -> list[Layer]:
    """Make layers of the colours, without those that would hardly show.

    shimmer: 0..1, for products above the eye that are not dark.  share: of each opacity that is
    painted.
    """
    layers = []
    for at, density in enumerate(found.densities):
        root, opacity = _no_blacker(found.roots[at], float(found.opacities[at]), skin)
        if opacity <= _HARDLY:
            continue
        slot = slot_of(density)
        shines = shimmer if root**2 @ LUMINANCE > _MATTE and slot != "under" else 0.0
        worn = shimmering(skin.codes(root * (1 - _SHEEN * shines)), shines)
        shape = {"slot": slot, "map": to_text(density)}
        layers.append(Layer("eyeshadow", replace(worn, opacity=round(share * opacity, 3)), shape))
    return layers


def shimmering(rgb: tuple[float, float, float], shimmer: float) -> GraphicsParams:
    """An eyeshadow of a colour, codes 0..255, with this much shimmer, 0..1.

    It is matte if the shimmer would hardly be seen.
    """
    if shimmer <= _HARDLY_SHIMMERS:
        return product(rgb, "matte", "eyes")
    worn = product(rgb, "shimmer", "eyes")
    return replace(
        worn,
        gloss=round(_MOST_GLOSS * shimmer, 3),
        reflection=round(worn.reflection * shimmer, 3),
        shimmer=round(min(_SPARKLES * shimmer, worn.shimmer), 3),
        shimmer_size=0.0,  # larger sparkles look like stray dots
    )
