"""GraphicsParams -> the numbers of a product that no light changes.

kernels/product.cl makes of them the material that is painted. Every number here that is not physics
was set by eye, on the finishes and on photos of real makeup.
"""

import math
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from makeup_video.kernels.colour import (
    HLG,
    PQ,
    Coding,
    from_srgb_primaries,
    product_linear,
    to_srgb_primaries,
    to_xyz,
)
from makeup_video.kernels.material import ENVIRONMENT_PX
from makeup_video.pipeline.look.params import GraphicsParams

_SDR_CEILING, _HDR_CEILING = 1.0, 4.0  # in units of diffuse white
_MOST_GLOSS = 1e4  # as good as infinite
_GLINT = 0.6  # light of the synthetic highlight at gloss 1
_METAL = 1.0  # by what share that highlight is stronger on a metal
_OWN = 2.2  # gain of the skin's own highlights at gloss 1
_DENSEST = 0.6  # share of cells with a sparkle at shimmer 1: more would show the grid of cells
_SPARKLE = 1.8  # light of a sparkle
_DEEP = 0.5  # share of that light on a deep colour: a brighter sparkle would lose its hue
_PEARL = 0.3  # sheen of the sparkles that are too fine to be seen, at shimmer 1
# Luminance below which a product's highlight takes on its hue, and how much of the hue the deepest
# products' highlights have. A white haze on wine or plum would look like ash: in photos such shine
# is red or violet.
_DEEP_BELOW, _DEEPEST = 0.13, 0.7
_BLACK = 0.02  # linear light: a product whose brightest channel is below it has no hue to speak of
_PALE = 0.35  # luminance from which on a product may have silver sparkles
_LEAST_SILVER = 0.15  # share of its silver that a sparkle keeps on a black product
# Size of a sparkle's cell, of the eyes' distance: at shimmer_size 0, and what shimmer_size 1 adds.
_FINEST_CELL, _COARSER_CELL = 0.006, 0.022
# The largest such size, on the smallest faces with sparkles: larger ones would make of fine dust a
# few blobs in rows.
_COARSEST_CELL, _COARSEST_MORE = 0.03, 0.07
LUMINANCE: tuple[float, ...] = tuple(to_xyz(1)[1].tolist())


@dataclass(frozen=True, slots=True)
class Unlit:
    """The numbers of a product that neither light nor place changes; see COAT, kernels/product.py.

    lights: the colours that the scene's light multiplies, as red, green, blue each: of the product,
    its highlight, its sheen, its sparkles.
    """

    lights: tuple[tuple[float, ...], ...]
    own_highlights: float
    lobe: float
    fresnel_front: float
    fresnel_rim: float
    room: float
    shimmer: float


@lru_cache(maxsize=512)
def unlit(params: GraphicsParams) -> Unlit:
    """A product before any light falls on it, at its full strength."""
    mixed = _mixed(params)
    gloss = min(params.gloss, _MOST_GLOSS)
    shown = min(1.0, params.opacity + params.gloss + params.reflection)
    pearl = _PEARL * params.shimmer * shown
    return Unlit(
        lights=(
            mixed.product,
            tuple([part * gloss for part in mixed.glint]),
            tuple([part * pearl for part in mixed.tint]),
            tuple([part * _SPARKLE * shown for part in mixed.sparkle]),
        ),
        own_highlights=_OWN * gloss * params.gloss_detail,
        lobe=(0.14 + 0.7 * params.gloss_roughness) ** 2,
        fresnel_front=0.7 * (1 - params.fresnel) + 0.1,
        fresnel_rim=5.0 * params.fresnel,
        room=(ENVIRONMENT_PX - 2) / 2 * (1 - 0.5 * params.environment_blur),
        shimmer=_DENSEST * params.shimmer,
    )


def ceiling_of(coding: Coding) -> float:
    """The brightest light that is painted, in units of diffuse white."""
    return _HDR_CEILING if coding.transfer in (PQ, HLG) else _SDR_CEILING


def sparing(spared: float) -> tuple[float, float]:
    """Return dark_gain and dark_offset of MATERIAL.

    spared: pixels darker than this share of the broad light around them stay bare (lashes, the dark
    of a mouth) where the product would lighten them; from twice that share on they are fully
    painted. 0 paints everything.
    """
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
    """A product's colours before any light falls on it, as red, green, blue: of the product itself,
    of its sheen, of its sparkles, and of its highlight at gloss 1."""

    product: tuple[float, ...]
    tint: tuple[float, ...]
    sparkle: tuple[float, ...]
    glint: tuple[float, ...]


@lru_cache
def _mixed(params: GraphicsParams) -> _Mixed:
    product = product_linear((params.red, params.green, params.blue), Coding())
    brightest = float(product.max())
    hue = product / max(brightest, _BLACK)
    # white light on a deep colour would turn violet into lilac, and black into salt
    luminance = float(product @ LUMINANCE)
    pale = min(luminance / _PALE, 1.0) ** 2
    silver = (1 - params.shimmer_tint) * (_LEAST_SILVER + (1 - _LEAST_SILVER) * pale)
    # a broad highlight is a weaker one: the same light over more of the surface
    sheen = 1 / (1 + 6 * params.gloss_roughness**2)
    tint = hue + silver * (1 - hue)
    metallic = params.shimmer * params.shimmer_tint
    # metals colour what they mirror, and mirror more of it; black colours nothing
    own_hue = hue + max(1 - brightest / _BLACK, 0.0)
    mirrored = 1 + metallic * (hue - 1)
    mirrored = np.minimum(mirrored, 1 + hue_in_highlight(luminance) * (own_hue - 1))
    mirrored *= 1 + _METAL * metallic
    glint = mirrored * _GLINT * sheen * (1 - params.gloss_detail)
    sparkle = (_DEEP + (1 - _DEEP) * pale) * tint
    return _Mixed(*(tuple(light.tolist()) for light in (product, tint, sparkle, glint)))


def hue_in_highlight(luminance: float) -> float:
    """How much of its own hue the highlight of a product of this luminance has, 0..1."""
    return _DEEPEST * (1 - min(luminance / _DEEP_BELOW, 1.0))


@lru_cache
def film_matrices(primaries: int) -> tuple[tuple[float, ...], tuple[float, ...]]:
    """The matrices from these primaries to sRGB's, in which films are mixed, and back, by rows."""
    to, back = to_srgb_primaries(primaries), from_srgb_primaries(primaries)
    return tuple(to.ravel().tolist()), tuple(back.ravel().tolist())
