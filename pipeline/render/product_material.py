"""GraphicsParams under the light of a scene -> the Material that the kernel paints.

`worn` is what no light changes. The rest is the numpy twin of kernels/product.cl.

Every number here that is not physics was set by eye, on the finishes and on photos of real makeup.
"""

import math
from dataclasses import dataclass
from functools import lru_cache

from makeup_video.kernels.colour import (
    HLG,
    PQ,
    Coding,
    from_srgb_primaries,
    product_linear,
    to_srgb_primaries,
    to_xyz,
)
from makeup_video.kernels.material import ENVIRONMENT_PX, LEAST_ROOM, Material
from makeup_video.kernels.product import (
    DARK,
    DISSOLVE,
    LARGEST_SPOT,
    LEAST_CELL_PX,
    LEAST_SPOT_PX,
    SPOT,
)
from makeup_video.pipeline.frames.affine import Affine
from makeup_video.pipeline.look.params import GraphicsParams
from makeup_video.pipeline.render.scene import SceneLight

_SDR_CEILING, _HDR_CEILING = 1.0, 4.0  # in units of diffuse white
_MOST_GLOSS = 1e4  # as good as infinite
_GLINT = 0.6  # light of the synthetic highlight at gloss 1
_METAL = 1.0  # how much more of it a metal has
_OWN = 2.2  # gain of the lips' own highlights at gloss 1
_DENSEST = 0.6  # share of cells with a sparkle at shimmer 1: with more they would show their grid
_SPARKLE = 1.8
_DEEP = 0.5  # of it on a deep colour: a brighter sparkle would lose its hue
_PEARL = 0.3  # sheen of the sparkles that are too fine to be seen, at shimmer 1
_BLACK = 0.02  # linear light: a product whose brightest channel is below it has no hue to speak of
_PALE = 0.35  # luminance from which on a product may have silver sparkles
_LEAST_SILVER = 0.15  # of silver sparkles that stays on a black product
_FINEST_CELL, _COARSER_CELL = 0.006, 0.022  # of the eyes' distance: of shimmer_size 0, and 1 adds
# The same on the smallest faces with sparkles: fine ones would be blobs there, few and in rows.
_COARSEST_CELL, _COARSEST_MORE = 0.03, 0.07
LUMINANCE: tuple[float, ...] = tuple(to_xyz(1)[1].tolist())


@dataclass(frozen=True, slots=True)
class SkinAxes:
    """How a region lies in the frame.

    turn: (2, 2) unit columns, the directions of the region's x and y axes in the frame.
    skin_px: px of the frame for one unit of the coordinates that stick to the skin (the distance of
    the eyes).
    """

    turn: tuple[tuple[float, float], tuple[float, float]]
    skin_px: float


def material(
    params: GraphicsParams,
    amount: float,
    light: SceneLight,
    axes: SkinAxes,
    coding: Coding,
    spared: float = 0.0,
    shade: float = 1.0,
    keep_highlights: float = 1.0,
) -> Material:
    """A product under a light, as the kernel paints it.

    amount: 0..1, scales all of the product (strength, intensity).
    spared: pixels darker than this share of the broad light around them stay bare (lashes, the dark
    of a mouth) where the product would lighten them; from twice that share on they are fully
    painted. 0 paints everything.
    shade: share of the light that falls on the region.
    keep_highlights: how much of the skin's own highlights stays on the product, 0..1.
    """
    whole = worn(params, amount, coding)
    share, ceiling = params.light_adaptation, whole.ceiling
    strength = light.strength_for_products * shade
    gain = [1 + share * (part * strength - 1) for part in _turned(light, whole.to_film)]
    cell, spot, seen = _cells(params, axes)
    fine = 1 - 0.5 * seen  # sparkles that are not seen one by one make a sheen
    (red, green, blue), (a, b), (c, d) = gain, *axes.turn
    dark_gain, dark_offset = sparing(spared)
    (r0, g0, b0), (r1, g1, b1), (r2, g2, b2), (r3, g3, b3) = whole.lights
    return Material(
        product=(_lit(r0, red, ceiling), _lit(g0, green, ceiling), _lit(b0, blue, ceiling)),
        glint=(red * (r1 + r2 * fine), green * (g1 + g2 * fine), blue * (b1 + b2 * fine)),
        sparkle=(red * r3 * seen, green * g3 * seen, blue * b3 * seen),
        luminance=LUMINANCE,
        opacity=whole.opacity,
        texture=params.texture_keep,
        undertone=params.undertone,
        keep_highlights=keep_highlights,
        own_highlights=whole.own_highlights,
        lobe=whole.lobe,
        half_way=_half_way(light, axes),
        reflection=whole.reflection,
        fresnel_front=whole.fresnel_front,
        fresnel_rim=whole.fresnel_rim,
        room=(whole.room * a, whole.room * b, whole.room * c, whole.room * d),
        shimmer=whole.shimmer,
        cells=1 / cell,
        spot=spot * spot,
        dark=DARK * max(strength, 0.1),
        dark_gain=dark_gain,
        dark_offset=dark_offset,
        to_film=whole.to_film,
        from_film=whole.from_film,
        ceiling=ceiling,
    )


@dataclass(frozen=True, slots=True)
class Worn:
    """What of a Material no light and no place changes.

    lights: what light multiplies, each as red, green, blue: the product, its highlight, its sheen,
    its sparkles.
    """

    lights: tuple[tuple[float, ...], ...]
    opacity: float
    own_highlights: float
    lobe: float
    reflection: float
    fresnel_front: float
    fresnel_rim: float
    room: float
    shimmer: float
    to_film: tuple[float, ...]
    from_film: tuple[float, ...]
    ceiling: float


@lru_cache(maxsize=512)
def worn(params: GraphicsParams, amount: float, coding: Coding) -> Worn:
    """A product before any light falls on it; amount: see `material`."""
    mixed = _mixed(params)
    to_film, from_film = film_matrices(coding.primaries)
    gloss = min(params.gloss, _MOST_GLOSS) * amount
    shown = min(1.0, params.opacity + params.gloss + params.reflection) * amount
    pearl = _PEARL * params.shimmer * shown
    return Worn(
        lights=(
            mixed.product,
            tuple([part * gloss for part in mixed.glint]),
            tuple([part * pearl for part in mixed.tint]),
            tuple([part * _SPARKLE * shown for part in mixed.sparkle]),
        ),
        opacity=params.opacity * amount,
        own_highlights=_OWN * gloss * params.gloss_detail,
        lobe=(0.14 + 0.7 * params.gloss_roughness) ** 2,
        reflection=params.reflection * amount,
        fresnel_front=0.7 * (1 - params.fresnel) + 0.1,
        fresnel_rim=5.0 * params.fresnel,
        room=(ENVIRONMENT_PX - 2) / 2 * (1 - 0.5 * params.environment_blur),
        shimmer=_DENSEST * params.shimmer,
        to_film=to_film,
        from_film=from_film,
        ceiling=ceiling_of(coding),
    )


def ceiling_of(coding: Coding) -> float:
    """The brightest light that is painted."""
    return _HDR_CEILING if coding.transfer in (PQ, HLG) else _SDR_CEILING


def sparing(spared: float) -> tuple[float, float]:
    """dark_gain and dark_offset of a Material; spared: see `material`."""
    return (1 / spared, -1.0) if spared else (0.0, 1.0)


def least_cell(params: GraphicsParams) -> tuple[float, int]:
    """Size of a sparkle's cell on a large face, and how often it may be doubled on a small one."""
    if not params.shimmer:
        return _FINEST_CELL, 0
    cell = _FINEST_CELL + _COARSER_CELL * params.shimmer_size
    coarsest = _COARSEST_CELL + _COARSEST_MORE * params.shimmer_size
    return cell, max(math.floor(math.log2(coarsest / cell)), 0)


@dataclass(frozen=True, slots=True)
class _Mixed:
    """A product's colours before any light falls on it, as red, green, blue: its own, that of its
    sheen, that of its sparkles, and that of its highlight at gloss 1."""

    product: tuple[float, ...]
    tint: tuple[float, ...]
    sparkle: tuple[float, ...]
    glint: tuple[float, ...]


@lru_cache
def _mixed(params: GraphicsParams) -> _Mixed:
    product = product_linear((params.red, params.green, params.blue), Coding())
    hue = product / max(float(product.max()), _BLACK)
    # white light on a deep colour would turn violet into lilac, and black into salt
    pale = min(float(product @ LUMINANCE) / _PALE, 1.0) ** 2
    silver = (1 - params.shimmer_tint) * (_LEAST_SILVER + (1 - _LEAST_SILVER) * pale)
    # a broad highlight is a weaker one: the same light over more of the surface
    sheen = 1 / (1 + 6 * params.gloss_roughness**2)
    tint = hue + silver * (1 - hue)
    metallic = params.shimmer * params.shimmer_tint
    metal = 1 + metallic * (hue - 1)  # metals colour what they mirror, and mirror more of it
    metal *= 1 + _METAL * metallic
    glint = metal * _GLINT * sheen * (1 - params.gloss_detail)
    sparkle = (_DEEP + (1 - _DEEP) * pale) * tint
    return _Mixed(*(tuple(light.tolist()) for light in (product, tint, sparkle, glint)))


@lru_cache(maxsize=16)  # all layers on a face are in the same light
def _turned(light: SceneLight, rows: tuple[float, ...]) -> list[float]:
    """The light's colour in other primaries, 0 or more; rows: a (3, 3) matrix, row by row."""
    red, green, blue = light.colour.tolist()
    parts = (rows[i] * red + rows[i + 1] * green + rows[i + 2] * blue for i in (0, 3, 6))
    return [max(part, 0.0) for part in parts]


@lru_cache
def film_matrices(primaries: int) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """By rows, from these primaries to sRGB's, and back."""
    to, back = to_srgb_primaries(primaries), from_srgb_primaries(primaries)
    return tuple(to.ravel().tolist()), tuple(back.ravel().tolist())


def _lit(product: float, gain: float, ceiling: float) -> float:
    """A channel of a product under a light of that gain; strong light leaves a pale product room
    for its highlights."""
    below, above = product * min(gain, 1.0), product * max(gain - 1, 0.0)
    room = max(ceiling - below, 0.0) + LEAST_ROOM  # as `added` does
    return below + room * above / (room + above)


def _cells(params: GraphicsParams, axes: SkinAxes) -> tuple[float, float, float]:
    """Shimmer: size of a cell, radius of a sparkle in cells, how far sparkles are seen (0..1).

    On a small face the cells are two, four or eight times as large, so that a sparkle covers
    several pixels. Around the sizes where this number changes, sparkles fade out: otherwise all of
    them would jump at once.
    """
    cell, most_doublings = least_cell(params)
    if not params.shimmer:
        return cell, SPOT, 0.0
    wanted = math.ceil(math.log2(LEAST_CELL_PX / (cell * axes.skin_px)))
    doublings = max(min(wanted, most_doublings), 0)
    cell *= 2**doublings
    cell_px = cell * axes.skin_px
    beyond = cell_px / LEAST_CELL_PX - 1
    seen = min(max(beyond / DISSOLVE, 0.0), 1.0)
    if doublings:
        seen *= min(max((1 - beyond) / DISSOLVE, 0.0), 1.0)
    return cell, min(max(SPOT, LEAST_SPOT_PX / cell_px), LARGEST_SPOT), seen


def _half_way(light: SceneLight, axes: SkinAxes) -> tuple[float, float, float]:
    """Unit vector between the light and the viewer, in the region's axes, z to the viewer."""
    (a, b), (c, d) = axes.turn
    right, down, away = light.direction.tolist()
    (x, y), z = Affine(a, b, 0.0, c, d, 0.0).solve(right, down), 1 - away
    length = math.sqrt(x * x + y * y + z * z)
    return x / length, y / length, z / length
