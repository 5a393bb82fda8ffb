"""Fits layers of eyeshadow to the skin around the eyes of a photo.

The skin is laid flat (flat_eyes.py) and freed of what is light rather than makeup. The colours of
usual places (first_shadows.py) are then spread as they are seen (spread_shadows.py), so each layer
has a density map.
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

_EVENED = 0.8  # how much of the light beyond bare eyes is taken for light, and not for makeup
_VIVID = 0.4  # how much more vivid a colour as light as bare eyes is painted than it is seen
# Probability of eyeshadow from which on that holds for warm colours a little, and wholly: many bare
# lids are warm, and would be orange.
_SURE = 0.7, 0.95
# Of what sets a wholly warm colour apart from bare eyes, by which share red exceeds green, and
# green blue.
_WARM_HUE = 0.25
_FAINTEST = 1e-6
_PALE = 78.0, 82.0  # L* of skin from which on it is a little pale, and wholly
_VIVID_FROM = 34.0  # how far from skin, in a* and b*, a colour is vivid
_SOFTER = 12.0  # over which distance before that it becomes so
_RED = 8.0  # how much redder than skin a colour is wholly red, in a*
_CALMER = 0.25  # how much less vivid soft reds and browns become beside pale skin
_LESS_YELLOW = 0.3  # of what makes soft colours yellower than skin: browns came out orange
_OWN_HUE = 1.0  # of the photo's skin, as of TypicalSkin: brown stays brown on pale skin
# Below the eye nothing is redder or yellower than this percentile of the lid, up to that height.
_WARMEST_PERCENTILE = 75
_LID_TO = 1.4
# Red stays where this percentile of its a* exceeds that by so much: a little, and wholly. Of bare
# faces 95 % have less than the first.
_REDDEST_PERCENTILE, _WORN_BELOW = 90, (6.0, 13.0)
# Cells darker than this share of skin's L* do not count: shade and lashes are red by themselves.
_SHADE = 0.55
# Beside green, blue and grey lids red is skin: by how much the lid's a* and b* exceed those of
# skin for none of it to stay, and for all.
_WARM_LID = (4.0, 10.0), (-3.0, 1.5)
_WARM = 1.0, 1.15  # red as a share of blue in light that is a little warm, and wholly
_DENSE = 0.5  # share of a product's highest density from which on it lies in a cell
_COLD_PERCENTILE = 25  # of a* and b* of the cells where a product lies: the cold ones
# In warm light no product is colder than the coldest of the cells where it lies. Where even the
# cold ones are greener or bluer than grey, it may be so many times as cold as they.
_COLDEST_PERCENTILE = 5
_COLDER = 4.0
_SURELY_WARM = 4.0  # a* and b* of the cold ones in the photo's light from which they bound wholly
# The b* of a product is at least so many times that of its cold cells in the photo's light, less
# this.
_BLUER, _BLUER_BY = 2.5, 8.0
_ALL_FROM = 0.3  # probability of eyeshadow from which on all of the opacity is painted
_UNLIKELY_SHARE = 0.6  # what of it is painted where eyeshadow is hardly likely
# Black, grey and dark brown: up to which share of skin's luminance, and up to which chroma. Colours
# beside them are soft and red up to this difference from skin in a* and b*, and from this one in a*
# on. Where there is more black than this share of such a colour, this much of the difference
# is kept.
_DARK, _BLACK_CHROMA = 0.25, 30.0
_SOFT_CHROMA, _REDDISH = 45.0, 4.0
_MUCH_BLACK, _CALM_RIM = 0.5, 0.6
# The luminance that powder has at least, since its surface reflects light, too. Without it, a black
# lid that shuts is a hole.
_BLACK = 0.0116
# Share of typical skin's luminance up to which a product stays matte: shine on it looks like dust.
_MATTE = 0.25
# Luminance of the inner end of the lid and of the skin beside it, as a share of the photo's skin:
# up to the first no shimmer is painted, from the second one on all that was measured. Of three
# places that were tried, judges preferred rows with shimmer most clearly where this one is light.
_LIGHT_INSIDE = 0.36, 0.42
_INSIDE, _LID = 0.35, (0.3, 1.0)  # up to where it goes from the inner corner; between these heights
# Colours like brow hair, which fade out above the crease.
_HAIR_DARK = 0.125, 0.25  # shares of skin's luminance: wholly as dark as hair, and a little
_HAIR_COLD = -15.0  # b* of the bluest of them
_HAIR_GREEN = -10.0  # a* of the greenest
_HAIR_VIVID = 35.0  # chroma of the most vivid
_BROW = 1.1, 1.7  # the heights over which they fade out
_MOST_GLOSS = 1.8  # gloss of an eyeshadow with a shimmer of 1
_SPARKLES = 1.4  # sparkles for a shimmer of 1, but never more than the finish "shimmer" has
_SHEEN = 0.07  # share by which a shimmer of 1 darkens the roots, since its sheen adds light
_HARDLY = 0.05  # an opacity up to which a layer is not worth painting
_HARDLY_SHIMMERS = 0.075  # up to this shimmer a layer is matte


def fit_shadows(
    neutral: NeutralFace,
    seen: np.ndarray | None,
    probability: float = 1.0,
    lined: bool = True,
    winged: bool = False,
    shimmer: float = 0.0,
) -> list[Layer]:
    """The layers of eyeshadow of a face, in the order of painting; none for an eye that is not
    seen, or that looks like a bare one.

    seen: as of mean_eye.  probability: that eyeshadow is worn; the less likely, the sheerer.
    lined: whether eyeliner is worn, too.  winged: whether that surely has a wing.  shimmer: 0..1,
    as of lid_shimmer.
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
    """Roots (27, 24, 3) of which soft reds and browns beside pale skin are less vivid, and all soft
    colours less yellow.

    Typical skin is darker than pale skin, and what differs from it by as much in CIELAB is more
    vivid: rose-brown became orange. Vivid colours stay so.  own: (3,) linear, the photo's skin.
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
    """(..., 1): 1 for soft colours, 0 for vivid ones; hue: (..., 2), how they differ from skin."""
    soft: np.ndarray = np.clip(
        (_VIVID_FROM - np.linalg.norm(hue, axis=-1, keepdims=True)) / _SOFTER, 0, 1
    )
    return soft


def _shaded(seen: np.ndarray, bare: np.ndarray, probability: float) -> np.ndarray:
    """Roots (27, 24, 3): less light of the same hue where they are lighter than bare eyes, and soft
    colours more vivid, unless they are warm and eyeshadow is not certain.

    Soft light from the front fills the hollow of the eye. As a product this light would be a pale
    veil, in which the colour that is worn is lost. Dark colours stay as they are.
    """
    share = np.sqrt((bare**2 @ LUMINANCE) / np.maximum(seen**2 @ LUMINANCE, _FAINTEST))[..., None]
    as_light = bare / share
    off, unsure = seen - as_light, 1 - ramp(probability, _SURE)
    more = _VIVID * (1 - unsure * _warmth(off)) * np.minimum(1 / share, 1) ** 4
    vivid = as_light + (1 + more) * off
    shaded: np.ndarray = np.maximum(vivid * np.minimum(share, 1) ** _EVENED, 0)
    return shaded


def _warmth(off: np.ndarray) -> np.ndarray:
    """(..., 1), 0..1: how much of a warm hue, of orange or brown, differences of roots (..., 3)
    have."""
    steps = (off[..., :-1] - off[..., 1:]) / np.maximum(
        _WARM_HUE * np.linalg.norm(off, axis=-1, keepdims=True), _FAINTEST
    )
    warmth: np.ndarray = np.clip(steps, 0, 1).prod(-1, keepdims=True)
    return warmth


def _no_redder_below(seen: np.ndarray, skin: TypicalSkin) -> np.ndarray:
    """Roots (27, 24, 3), below the eye no redder or yellower than most of the lid and, where
    that is bare, than skin: many lower lids are red by themselves, and so are rims of glasses. What
    is clearly redder beside a warm lid is makeup, and stays."""
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
    """The roots of the products, (N, 3), hardly greener or bluer than they are seen where they lie.

    Some of what is taken for warm light is warm skin. Where that is divided out, black and brown
    turn blue. Two bounds are set against this: one in warm photos; the other in any photo, for
    products that look redder and yellower than grey, which stay as red and yellow as they look.
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
    """The roots of the products, (N, 3), bounded by what is seen where they lie in any light: black
    and white liner, and smoke, are no blue or teal.

    labs_in_photo: as of _no_colder.
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
                lab[1] *= bluest / lab[2]  # or teal would become green
            lab[2] = bluest
            root[:] = skin.roots_of(lab)
    return roots


def _without_brows(found: Spread, skin: TypicalSkin) -> np.ndarray:
    """(N, 27, 24): the densities, where those of black, grey and brown fade out above the crease:
    low brows and the shade below them, which looked like blotches of smoke, lie there."""
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
    """The roots of the products, (N, 3), where soft reds and browns beside much black or grey are
    less vivid: at its border black is skin in the shade, and was painted with a red rim."""
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
    """The root (3,) of a product that is no darker than powder, and the opacity with which it
    darkens skin as much, or at most 1."""
    linear = root * root * skin.linear
    more = max(_BLACK - float(linear @ LUMINANCE), 0.0)
    if not more:
        return root, opacity
    lighter = np.sqrt((linear + more) / skin.linear)
    before, after = (1 - math.sqrt(float(one * one @ LUMINANCE)) for one in (root, lighter))
    return lighter, min(opacity * before / after, 1.0) if after > 0 else opacity


def _light_inside(seen: np.ndarray) -> float:
    """Of flat eyes (27, 48, 3): the median luminance around the inner end of the lid, as a share of
    skin's."""
    above, from_corner = heights(True), np.abs(flat_places()[0])
    low, high = _LID
    there = np.ix_((above > low) & (above < high), from_corner < _INSIDE)
    return float(np.median((seen**2 @ LUMINANCE)[: len(above)][there]))


def _layers(found: Spread, skin: TypicalSkin, shimmer: float, share: float) -> list[Layer]:
    """shimmer: 0..1, of products above the eye that are not dark.  share: what is painted of each
    opacity."""
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
    """An eyeshadow of a colour, codes 0..255, with this much shimmer, 0..1; matte where so little
    would hardly be seen."""
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
