"""The skin around the eyes as the cells of a density map.

For each cell this tells how bare faces look there, how a product shows, and whether eyeshadow may
lie there.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from makeup_video.pipeline.faces.net import read_array
from makeup_video.pipeline.look.finishes import product
from makeup_video.pipeline.look.kinds import KINDS
from makeup_video.pipeline.look.kinds.density_map import heights, places_across
from makeup_video.pipeline.look.kinds.ramps import fall, rise
from makeup_video.pipeline.look.look import Layer
from makeup_video.pipeline.reference.flat_eyes import density, flat_places, is_seen
from makeup_video.pipeline.reference.product_film import ProductFilm

# The measured roots of bare eyes are multiplied by this: photos of makeup have more light around
# the eyes than most faces on which a look is painted.
_DEEPER = 0.95
# How many times as much skin a layer of one shape hides, and how many times as much of its own
# colour it shows, as a product all around the eye. By least squares over bare faces that were
# painted in random colours.
_HIDES, _SHOWS = 1.13, 1.18
# A product that is lighter than skin by more than the first, in roots, counts as pale. It does not
# if it is vivid: its least root lies below that of skin by more than the second.
LIGHTER, VIVID = 0.03, 0.15
# Where eyeshadow may lie: across from the inner corner outwards, and by height from below the eye
# to the brow. Each end has a place, where half of the colour may be makeup, and a width over which
# this share fades.
_INNER, _OUTER = (0.0, 0.35), (1.4, 0.5)
_LOWER, _UPPER = (-0.85, 0.6), (1.9, 0.6)
_ENDS = 0.27  # eyeshadow ends this far beside the columns that are seen, in widths of the eye


@dataclass(frozen=True, slots=True, eq=False)
class Cells:
    """What is known of the cells of a density map before a photo is seen.

    film: bare faces, and how a product of opacity 1 shows on them, in each cell.
    weights: (27, 24), how much each cell counts, at most 1: little where bare faces differ much,
    such as at the lashes.
    reach: (27, 24), how much of a cell's colour may be makeup, 0..1.
    """

    film: ProductFilm
    weights: np.ndarray
    reach: np.ndarray


@lru_cache(maxsize=1)
def shadow_cells() -> Cells:
    """The cells, which are the same for every face."""
    numbers = on_map(read_array("bare_eyes.npy").astype(np.float32))
    bare, hides, shows = numbers[..., :3], numbers[..., 3], numbers[..., 4]
    film = ProductFilm(_DEEPER * bare, _HIDES * hides, _SHOWS * shows)
    height, across = np.concatenate([heights(True), heights(False)]), places_across()
    reach = np.outer(
        rise(height, *_LOWER) * fall(height, *_UPPER), rise(across, *_INNER) * fall(across, *_OUTER)
    )
    weights = numbers[..., 5]
    return Cells(film, weights / weights.max(), reach)


def on_map(flat: np.ndarray) -> np.ndarray:
    """Flat eyes (27, 48, ...) -> the cells of a map, (27, 24, ...)."""
    across, _ = flat_places()
    near = np.abs(across[:, None] - places_across()) / np.diff(places_across()).mean()
    weights = np.maximum(1 - near, 0).astype(np.float32)
    shown: np.ndarray = np.moveaxis(np.tensordot(flat, weights / weights.sum(0), (1, 0)), -1, 1)
    return shown


def columns_seen(flat: np.ndarray) -> np.ndarray:
    """(24,): 1 for the columns of a map that flat eyes (27, 48, 3) show.

    Other columns have less, down to 0, the further they lie from those.
    """
    across, _ = flat_places()
    there = across[is_seen(flat)]
    away = np.abs(places_across()[:, None] - there).min(1, initial=1)
    share: np.ndarray = np.clip(1 - away / _ENDS, 0, 1).astype(np.float32)
    return share


def density_of(shape: Mapping[str, object]) -> np.ndarray:
    """(27, 24), 0..1: how densely a shape of eyeshadow lies on the cells."""
    return _density(tuple(shape.items()))


@lru_cache(maxsize=32)
def _density(shape: tuple[tuple[str, object], ...]) -> np.ndarray:
    return on_map(density(Layer("eyeshadow", product((0, 0, 0), "matte", "eyes"), dict(shape))))


def slot_of(found: np.ndarray) -> str:
    """The slot whose usual shape is most like a density (27, 24).

    Likeness is the sum of the smaller of both densities over the sum of the larger.
    """
    alike = {}
    for slot in KINDS["eyeshadow"].slots:
        usual = density_of({"slot": slot})
        larger = max(float(np.maximum(found, usual).sum()), 1e-6)
        alike[slot] = float(np.minimum(found, usual).sum()) / larger
    return max(alike, key=alike.__getitem__)
