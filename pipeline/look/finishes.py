"""Finishes by their usual names: points of the 17-parameter space, without the colour."""

import math
from collections.abc import Mapping, Sequence

from makeup_video.pipeline.errors import UsageError, option
from makeup_video.pipeline.look.look import Look
from makeup_video.pipeline.look.params import GraphicsParams
from makeup_video.pipeline.look.regions import REGIONS

# What a finish and an opacity are called where a look is put into words. Every region has all
# finishes.
_SHINES = {
    "matte": "matte", "satin": "satin", "sheer": "soft sheen", "gloss": "glossy",
    "metallic": "metallic", "shimmer": "shimmering",
}  # fmt: skip
_COVERS = ((0.85, "opaque"), (0.6, "medium cover"), (0.35, "fairly sheer"), (0.0, "very sheer"))


# FINISHES["gloss"]["lips"]["opacity"]: everything of GraphicsParams but red, green, blue
FINISHES: Mapping[str, Mapping[str, Mapping[str, float]]] = {
    name: {region: info.finish(name) for region, info in REGIONS.items()} for name in _SHINES
}


def nearest_finish(
    opacity: float,
    gloss: float,
    gloss_roughness: float,
    reflection: float,
    region: str = "lips",
    shimmers: bool = True,
) -> str:
    """The finish whose numbers are closest; shimmers: False leaves out those that shimmer."""
    wanted = opacity, math.sqrt(gloss), gloss_roughness, math.sqrt(reflection)

    def distance(name: str) -> float:
        row = FINISHES[name][region]
        numbers = row["opacity"], math.sqrt(row["gloss"]), row["gloss_roughness"]
        return math.dist(wanted, (*numbers, math.sqrt(row["reflection"])))

    names = [name for name in FINISHES if shimmers or not FINISHES[name][region]["shimmer"]]
    return min(names, key=distance)


def in_words(params: GraphicsParams, region: str = "lips") -> str:
    """How a product looks, colour aside: "glossy, fairly sheer"."""
    numbers = params.opacity, params.gloss, params.gloss_roughness, params.reflection
    finish = nearest_finish(*numbers, region, shimmers=params.shimmer > 0)
    covers = next(word for least, word in _COVERS if params.opacity >= least)
    return f"{_SHINES[finish]}, {covers}"


def look_in_words(look: Look) -> str:
    """A look in one line: "lips #B4002E, glossy, opaque; eyes bare"."""
    worn = look.products
    return "; ".join(
        f"{name} {worn[name].hex}, {in_words(worn[name], name)}" if name in worn else f"{name} bare"
        for name in REGIONS
    )


def product(rgb: Sequence[float], finish: str, region: str = "lips") -> GraphicsParams:
    """A product of a colour and a finish, for a region: a key of REGIONS, "lips" or "eyes".

    rgb: red, green, blue as sRGB-encoded code values 0..255, the product's colour as under neutral
    light. finish: a name of FINISHES.  Raises UsageError for an unknown name, LookError for a
    number out of its range.
    """
    if finish not in FINISHES:
        raise UsageError(f"{option('finish')} must be one of {', '.join(FINISHES)}, got {finish!r}")
    if region not in REGIONS:
        raise UsageError(f"a region is one of {', '.join(REGIONS)}, got {region!r}")
    if len(rgb) != 3:
        raise UsageError(f"a colour is red, green and blue, got {len(rgb)} numbers")
    red, green, blue = rgb
    return GraphicsParams(red=red, green=green, blue=blue, **FINISHES[finish][region])
