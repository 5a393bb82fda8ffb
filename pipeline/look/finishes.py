"""Finishes by their usual names: points of the 17-parameter space, without the colour."""

import math
from collections.abc import Mapping, Sequence

from makeup_video.pipeline.errors import UsageError
from makeup_video.pipeline.look.look import Look
from makeup_video.pipeline.look.params import GraphicsParams

REGIONS = ("lips", "eyes")

_SETTINGS = (
    "opacity", "gloss", "gloss_roughness", "reflection",
    "edge_softness", "texture_keep", "undertone", "gloss_detail", "fresnel", "environment_blur",
    "shimmer", "shimmer_size", "shimmer_tint", "light_adaptation",
)  # fmt: skip
# In the order of _SETTINGS. Eye-shadow is a powder: broader highlights, softer edges, no mirror.
_LIPS = {
    "matte":    (0.96, 0.00, 0.80, 0.00,  0.30, 0.45, 0.00, 0.20, 0.30, 0.80,  0.00, 0.50, 0.50, 1.0),
    "satin":    (0.92, 0.40, 0.45, 0.05,  0.35, 0.50, 0.05, 0.50, 0.50, 0.60,  0.00, 0.50, 0.50, 1.0),
    "sheer":    (0.40, 0.30, 0.50, 0.05,  0.60, 0.75, 0.40, 0.60, 0.50, 0.50,  0.00, 0.50, 0.50, 1.0),
    "gloss":    (0.94, 1.30, 0.20, 0.25,  0.40, 0.60, 0.10, 0.55, 0.70, 0.20,  0.00, 0.50, 0.50, 1.0),
    "metallic": (0.95, 1.25, 0.40, 0.30,  0.40, 0.45, 0.00, 0.40, 0.60, 0.40,  0.50, 0.10, 1.00, 1.0),
    "shimmer":  (0.75, 0.60, 0.40, 0.10,  0.50, 0.60, 0.15, 0.50, 0.50, 0.50,  0.60, 0.30, 0.40, 1.0),
}  # fmt: skip
_EYES = {
    "matte":    (0.70, 0.00, 0.95, 0.00,  0.60, 0.75, 0.10, 0.20, 0.20, 0.90,  0.00, 0.50, 0.50, 1.0),
    "satin":    (0.60, 0.20, 0.80, 0.00,  0.60, 0.80, 0.10, 0.40, 0.40, 0.80,  0.00, 0.50, 0.50, 1.0),
    "sheer":    (0.28, 0.10, 0.80, 0.00,  0.80, 0.90, 0.40, 0.40, 0.30, 0.80,  0.00, 0.50, 0.50, 1.0),
    "gloss":    (0.45, 0.90, 0.40, 0.10,  0.60, 0.80, 0.15, 0.40, 0.60, 0.50,  0.00, 0.50, 0.50, 1.0),
    "metallic": (0.80, 0.70, 0.60, 0.15,  0.60, 0.70, 0.05, 0.20, 0.60, 0.60,  0.60, 0.10, 1.00, 1.0),
    "shimmer":  (0.50, 0.40, 0.65, 0.05,  0.70, 0.75, 0.15, 0.30, 0.50, 0.60,  0.70, 0.30, 0.40, 1.0),
}  # fmt: skip

# What the finish and the opacity are called when a look is told in words.
_SHINES = {
    "matte": "matte", "satin": "satin", "sheer": "soft sheen", "gloss": "glossy",
    "metallic": "metallic", "shimmer": "shimmering",
}  # fmt: skip
_COVERS = ((0.85, "opaque"), (0.6, "medium cover"), (0.35, "fairly sheer"), (0.0, "very sheer"))


def _named(row: tuple[float, ...]) -> dict[str, float]:
    return dict(zip(_SETTINGS, row, strict=True))


# FINISHES["gloss"]["lips"]["opacity"]: everything of GraphicsParams but red, green, blue
FINISHES: Mapping[str, Mapping[str, Mapping[str, float]]] = {
    name: {"lips": _named(_LIPS[name]), "eyes": _named(_EYES[name])} for name in _LIPS
}


def nearest_finish(
    opacity: float,
    gloss: float,
    gloss_roughness: float,
    reflection: float,
    region: str = "lips",
    shimmers: bool = True,
) -> str:
    """The finish whose numbers are closest; shimmers: among those that shimmer, too."""
    here = opacity, math.sqrt(gloss), gloss_roughness, math.sqrt(reflection)

    def off(name: str) -> float:
        one = FINISHES[name][region]
        there = one["opacity"], math.sqrt(one["gloss"]), one["gloss_roughness"]
        return math.dist(here, (*there, math.sqrt(one["reflection"])))

    names = [name for name in FINISHES if shimmers or not FINISHES[name][region]["shimmer"]]
    return min(names, key=off)


def in_words(params: GraphicsParams, region: str = "lips") -> str:
    """How a product looks, colour aside: "glossy, fairly sheer"."""
    numbers = params.opacity, params.gloss, params.gloss_roughness, params.reflection
    finish = nearest_finish(*numbers, region, shimmers=params.shimmer > 0)
    covers = next(word for least, word in _COVERS if params.opacity >= least)
    return f"{_SHINES[finish]}, {covers}"


def look_in_words(look: Look) -> str:
    """All of it: "lips #B4002E, glossy, opaque; eyes bare"."""
    worn = {name: getattr(look, name) for name in REGIONS}
    told = (f"{n} {p.hex}, {in_words(p, n)}" if p else f"{n} bare" for n, p in worn.items())
    return "; ".join(told)


def product(rgb: Sequence[float], finish: str, region: str = "lips") -> GraphicsParams:
    """A product of a colour and a finish, for a region ("lips" or "eyes").

    rgb: red, green, blue as sRGB-encoded code values 0..255, the product's colour as under neutral
    light. finish: a name of FINISHES.  Raises UsageError for an unknown name, LookError for a
    number out of its range.
    """
    if finish not in FINISHES:
        raise UsageError(f"--finish must be one of {', '.join(FINISHES)}, got {finish!r}")
    if region not in REGIONS:
        raise UsageError(f"a region is one of {', '.join(REGIONS)}, got {region!r}")
    if len(rgb) != 3:
        raise UsageError(f"a colour is red, green and blue, got {len(rgb)} numbers")
    red, green, blue = rgb
    return GraphicsParams(red=red, green=green, blue=blue, **FINISHES[finish][region])
