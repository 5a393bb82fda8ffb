"""Fits layers of eye-shadow to the skin around the eyes of a photo.

The skin is laid flat (flat_eyes.py). Which layers, painted on the mean bare face, would look most
like it? Places and extents are tried one after the other, the one that helps most first; colours
follow by least squares, because films mix linearly in roots of light. Cells where bare faces differ
much, such as the lashes, count less.
"""

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache

import numpy as np
from makeup_video.pipeline.faces.net import read_array
from makeup_video.pipeline.look.finishes import nearest_finish, product
from makeup_video.pipeline.look.kinds import KINDS
from makeup_video.pipeline.look.look import Layer
from makeup_video.pipeline.look.params import GraphicsParams
from makeup_video.pipeline.reference.film import Film, bounded
from makeup_video.pipeline.reference.flat_eyes import density
from makeup_video.pipeline.reference.neutral_face import LUMINANCE, NeutralFace
from makeup_video.pipeline.reference.typical_skin import TypicalSkin

# What is tried, in the order of painting: of each place one shape, or none. The last lies below the
# eye.
_SHAPES: tuple[tuple[dict[str, object], ...], ...] = (
    (
        {"slot": "full"},
        {"slot": "full", "high": 2.0},
        {"slot": "full", "high": 2.0, "inner": 0.0, "outer": 1.4},
    ),
    ({"slot": "crease"},),
    (
        {"slot": "outer"},
        {"slot": "outer", "outer": 1.3, "low": -0.6},
        {"slot": "outer", "outer": 1.45, "low": -0.9, "inner": 0.75},
        {"slot": "outer", "outer": 1.3, "lift": 0.6},
    ),
    ({"slot": "lid"},),
    (
        {"slot": "under"},
        {"slot": "under", "outer": 1.25, "low": -0.45},
        {"slot": "under", "outer": 1.3, "low": -1.0},
    ),
)
# By how much a layer must lessen the mean squared error, in shares of skin.
_WORTH = 0.0002
_LEAST_GAIN = 1e-5
MOST_OPAQUE, LEAST_OPAQUE = 0.8, 0.3
# A product lighter than the skin is a sheer one: on darker skin it would look like chalk. A vivid
# one would not: it may be opaque where its least root lies so far below that of skin.
_LIGHT_OPAQUE, _VIVID_CONTRAST = 0.35, 0.15
_CONTRAST = 0.35  # of roots between a product and skin, from which on it is as opaque as it can be
_LIGHTER = 0.03  # of roots: a product that is not lighter than skin by more may be opaque
# Roots of bare eyes as shares of those measured: photos of makeup have more light there than most
# faces on which a look is painted.
_DEEPER = 0.95
_EVENED = 0.8  # how much of the light beyond bare eyes is taken for light, and not for makeup
_FAINTEST = 1e-6
_VIVID = 0.4  # how much more vivid a colour as light as bare eyes is painted than it is seen
# The probability from which all of the opacity is painted, and what share of it is painted of a
# shadow that is hardly likely.
_ALL_FROM, _UNLIKELY_SHARE = 0.3, 0.6
_NEARLY = 0.92
# Of the weights: what keeps a layer's colour near that of skin. Where its cells hardly tell the
# colour, or other layers cover them, it would be an extreme one.
_STIFF = 0.002
_OWN_HUE = 1.0  # of the photo's skin, as of TypicalSkin: brown stays brown on pale skin

# A product may not be greener or bluer than this percentile of what is seen where it is that dense;
# where that is green or blue itself, than so many times as much.
_DENSE, _COLDEST, _VIVIDER = 0.4, 10, 2.0
_DARKER = 3.0  # by how much it may be darker, in L*, than the same percentile of those cells
# By how much more a layer of one of these shapes hides, and shows of its own colour, than products
# do that lie all around the eye: least squares over bare faces painted in random colours.
_HIDES, _SHOWS = 1.13, 1.18

_Shape = dict[str, object]


def fit_shadows(
    neutral: NeutralFace, seen: np.ndarray | None, lid: GraphicsParams, probability: float = 1.0
) -> list[Layer]:
    """The layers of eye-shadow of a face, in the order of painting; none for an eye that is not
    seen, or that looks like a bare one.

    seen: as of flat_eyes.  lid: the product on the lid as the net reads it, whose finish the lid's
    layer has; the others are matte.  probability: that eye-shadow is worn; the less likely, the
    sheerer.
    """
    if seen is None:
        return []
    shine = lid.opacity, lid.gloss, lid.gloss_roughness, lid.reflection
    finish = nearest_finish(*shine, "eyes", shimmers=False)
    skin = TypicalSkin.of(neutral, _OWN_HUE)
    seen, most = _shaded(skin.roots(seen)), skin.most()
    chosen = _choose(seen, most)
    chosen, opacities, roots = _without_white(seen, chosen, most)
    share = _UNLIKELY_SHARE + (1 - _UNLIKELY_SHARE) * min(probability / _ALL_FROM, 1)
    worn = [_as_seen(skin, root, seen, shape) for shape, root in zip(chosen, roots, strict=True)]
    return [
        _layer(shape, skin.codes(skin.roots_of(lab)), round(share * opacity, 3), finish)
        for shape, lab, opacity in zip(
            chosen, _no_warmer(skin, worn, chosen), opacities, strict=True
        )
    ]


def _no_warmer(
    skin: TypicalSkin, worn: Sequence[np.ndarray], shapes: Sequence[_Shape]
) -> list[np.ndarray]:
    """CIELAB of the products, (3,) each, below the eye no redder or yellower than those above or,
    without any, than skin: many lower lids are red by themselves, and so are rims of glasses."""
    above = [lab for lab, shape in zip(worn, shapes, strict=True) if shape["slot"] != "under"]
    warmest = np.max(above or [skin.lab(np.ones(3))], axis=0)
    return [
        np.append(lab[0], np.minimum(lab[1:], warmest[1:])) if shape["slot"] == "under" else lab
        for lab, shape in zip(worn, shapes, strict=True)
    ]


def _shaded(seen: np.ndarray) -> np.ndarray:
    """Roots (27, 48, 3): less light of the same hue where they are lighter than bare eyes, and soft
    colours more vivid.

    Soft light from the front fills the hollow of the eye. As a product this light would be a pale
    veil, in which the colour that is worn is lost. Dark colours stay as they are.
    """
    bare = _bare_eyes()[0].bare
    share = np.sqrt((bare**2 @ LUMINANCE) / np.maximum(seen**2 @ LUMINANCE, _FAINTEST))[..., None]
    as_light = bare / share
    vivid = as_light + (1 + _VIVID * np.minimum(1 / share, 1) ** 4) * (seen - as_light)
    shaded: np.ndarray = np.maximum(vivid * np.minimum(share, 1) ** _EVENED, 0)
    return shaded


def _as_seen(skin: TypicalSkin, root: np.ndarray, seen: np.ndarray, shape: _Shape) -> np.ndarray:
    """CIELAB of a product, (3,), no greener or bluer than any part of it is seen, hardly darker.

    Film lets warm skin through, so the product that would make it a dark brown is blue. On skin
    that is less warm, it would look blue; so where what is seen is yellow on the whole, and no
    redder than skin, the product is as yellow. By the same calculation the product of a soft grey
    is black, and beyond the outer corner, where it ends, it would be a black spot.
    """
    there = skin.lab(seen[density(_plain(shape)) > _DENSE])
    darkest, *coldest = np.percentile(there, _COLDEST, axis=0)
    worn = skin.lab(root)
    worn[0] = max(worn[0], darkest - _DARKER)
    worn[1:] = np.maximum(worn[1:], np.minimum(coldest, _VIVIDER * np.array(coldest)))
    _, red, yellow = there.mean(0)
    if yellow > 0 and red < skin.lab(np.ones(3))[1]:  # brown, or grey; not purple
        worn[2] = max(worn[2], yellow)
    return worn


def _choose(seen: np.ndarray, most: np.ndarray) -> list[_Shape]:
    """The shapes of the layers that are worth it, in the order of painting."""
    film, weights = _bare_eyes()
    chosen: list[_Shape | None] = [None] * len(_SHAPES)
    least = float(((seen - film.bare) ** 2 * weights[..., None]).sum())
    while True:
        tried = [
            (_error(seen, other, most), other)
            for place, shapes in enumerate(_SHAPES)
            for shape in (None, *shapes)
            if (other := [*chosen[:place], shape, *chosen[place + 1 :]]) != chosen
            and len(_worn(other)) <= KINDS["eyeshadow"].most
        ]
        error, best = min(tried, key=lambda one: one[0])
        if error > least - _LEAST_GAIN:
            return _worn(chosen)
        least, chosen = error, best


def _without_white(
    seen: np.ndarray, shapes: list[_Shape], most: np.ndarray
) -> tuple[list[_Shape], list[float], np.ndarray]:
    """The shapes, their opacities and their roots, (N, 3), without those that would have to be
    white: their skin is in strong light, and white on other skin would be a grey veil."""
    while True:
        _, roots = _fit(seen, shapes, [MOST_OPAQUE] * len(shapes), most)
        opacities = [_opacity(shape, root) for shape, root in zip(shapes, roots, strict=True)]
        _, roots = _fit(seen, shapes, opacities, most)
        white = (roots >= _NEARLY * most).sum(1) >= 2
        if not white.any():
            return shapes, opacities, roots
        first = int(white.argmax())
        shapes = [*shapes[:first], *shapes[first + 1 :]]


def _worn(shapes: Sequence[_Shape | None]) -> list[_Shape]:
    return [shape for shape in shapes if shape is not None]


def _error(seen: np.ndarray, shapes: Sequence[_Shape | None], most: np.ndarray) -> float:
    """The mean squared error of the best colours, and what the layers cost."""
    worn = _worn(shapes)
    error, _ = _fit(seen, worn, [MOST_OPAQUE] * len(worn), most)
    return error + _WORTH * len(worn)


def _fit(
    seen: np.ndarray, shapes: Sequence[_Shape], opacities: Sequence[float], most: np.ndarray
) -> tuple[float, np.ndarray]:
    """The mean squared error, by the weights of the cells, and the products' roots, (N, 3)."""
    film, weights = _bare_eyes()
    shown: list[np.ndarray] = []
    through = np.ones_like(film.cover)
    for shape, opacity in zip(reversed(shapes), reversed(opacities), strict=True):
        here = opacity * density(_plain(shape))
        shown.insert(0, here * film.response * through)
        through = through * (1 - here * film.cover)
    rest = (seen - film.bare * through[..., None])[_counts()]
    if not shapes:
        return float((weights[_counts()][:, None] * rest**2).sum()), np.zeros((0, 3))
    parts = np.stack([part[_counts()] for part in shown], axis=1)
    weighted = parts * weights[_counts()][:, None]
    normal = parts.T @ weighted + _STIFF * np.eye(len(shapes))
    roots = bounded(normal, weighted.T @ rest + _STIFF, most)
    off = rest - parts @ roots
    return float((weights[_counts()][:, None] * off**2).sum()), roots


def _opacity(shape: _Shape, roots: np.ndarray) -> float:
    """How opaque a product is: it is the sheerer, the less it differs from skin."""
    film, weights = _bare_eyes()
    share = density(_plain(shape)) * weights
    pure = film.response[..., None] / np.maximum(film.cover, 0.05)[..., None] * roots
    off = ((pure - film.bare) * share[..., None]).sum((0, 1)) / max(float(share.sum()), 1e-9)
    most = MOST_OPAQUE
    if off @ LUMINANCE > _LIGHTER:
        vivid = min(max(-float(off.min()) / _VIVID_CONTRAST, 0), 1)
        most = _LIGHT_OPAQUE + vivid * (MOST_OPAQUE - _LIGHT_OPAQUE)
    wanted = MOST_OPAQUE * float(np.linalg.norm(off)) / _CONTRAST
    return round(min(max(wanted, LEAST_OPAQUE), most), 3)


def _layer(shape: _Shape, rgb: tuple[float, float, float], opacity: float, finish: str) -> Layer:
    worn = product(rgb, finish if shape["slot"] == "lid" else "matte", "eyes")
    return Layer("eyeshadow", replace(worn, opacity=opacity), shape)


@lru_cache(maxsize=32)
def _plain_layer(shape: tuple[tuple[str, object], ...]) -> Layer:
    return Layer("eyeshadow", product((0, 0, 0), "matte", "eyes"), dict(shape))


def _plain(shape: _Shape) -> Layer:
    """A layer of that shape, the same object each time."""
    return _plain_layer(tuple(shape.items()))


@lru_cache(maxsize=1)
def _bare_eyes() -> tuple[Film, np.ndarray]:
    """Bare eyes, laid flat, and what each cell counts: (27, 48), the sum is 1."""
    numbers = read_array("bare_eyes.npy").astype(np.float32)
    bare, hides, shows = numbers[..., :3], numbers[..., 3], numbers[..., 4]
    film = Film(_DEEPER * bare, _HIDES * hides, _SHOWS * shows)
    return film, numbers[..., 5] / numbers[..., 5].sum()


@lru_cache(maxsize=1)
def _counts() -> np.ndarray:
    """(27, 48) bool: the cells that count at all."""
    _, weights = _bare_eyes()
    there: np.ndarray = weights > weights.max() / 100
    return there
