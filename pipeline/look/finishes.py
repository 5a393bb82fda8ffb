"""Finishes by their usual names: points of the 17-parameter space, without the colour."""

import math
from collections.abc import Collection, Mapping, Sequence

from makeup_video.pipeline.errors import UsageError, option
from makeup_video.pipeline.look.kinds import KINDS, PARTS
from makeup_video.pipeline.look.kinds.kind import BOTH_EYES
from makeup_video.pipeline.look.look import Layer, Look
from makeup_video.pipeline.look.params import GraphicsParams
from makeup_video.pipeline.look.words import (
    did_you_mean,
    finish_names,
    finish_of,
    like_a_colour,
    rgb_of,
)

# The words for a finish and for an opacity, where a look is put into words. Every kind of makeup
# has all finishes.
_SHINES = {
    "matte": "matte", "satin": "satin", "sheer": "sheer", "gloss": "glossy",
    "metallic": "metallic", "shimmer": "shimmering",
}  # fmt: skip
_COVERS = (
    (0.85, "opaque"), (0.6, "medium coverage"), (0.35, "light coverage"),
    (0.0, "very light coverage"),
)  # fmt: skip
_SHEER_TO = 0.6  # opacity from which on no product is called sheer
_HARDLY_SPARKLES = 0.1  # shimmer above which a product is called metallic or shimmering
_BY_ROOT = "gloss", "reflection"  # numbers whose square roots are compared


# Parts that a look in words names even when they are bare.
_ALWAYS_NAMED = ("lips", "eyes")
# FINISHES["gloss"]["lips"]["opacity"], by finish and part: all of GraphicsParams but the colour
FINISHES: Mapping[str, Mapping[str, Mapping[str, float]]] = {
    name: {part: kind.finish(name) for part, kind in PARTS.items()} for name in _SHINES
}


def nearest_finish(
    opacity: float,
    gloss: float,
    gloss_roughness: float,
    reflection: float,
    part: str = "lips",
    shimmers: bool = True,
) -> str:
    """The finish whose numbers are closest.  shimmers: False leaves out finishes that shimmer."""
    numbers = {
        "opacity": opacity, "gloss": gloss, "gloss_roughness": gloss_roughness,
        "reflection": reflection,
    }  # fmt: skip
    names = [name for name in FINISHES if shimmers or not FINISHES[name][part]["shimmer"]]
    return _closest(names, numbers, part)


def _closest(names: Sequence[str], numbers: Mapping[str, float], part: str) -> str:
    """The finish, of these names, whose numbers are closest to the given numbers."""

    def on_scale(row: Mapping[str, float]) -> list[float]:
        return [math.sqrt(row[key]) if key in _BY_ROOT else row[key] for key in numbers]

    return min(names, key=lambda name: math.dist(on_scale(numbers), on_scale(FINISHES[name][part])))


def in_words(params: GraphicsParams, part: str = "lips") -> str:
    """How a product looks, colour aside: "glossy, light coverage"."""
    covers = next(word for least, word in _COVERS if params.opacity >= least)
    return f"{_SHINES[_finish_seen(params, part)]}, {covers}"


def _finish_seen(params: GraphicsParams, part: str) -> str:
    """The finish that a product looks like. Reflection does not count, since gloss that mirrors
    nothing is gloss as well. A product that covers well is not sheer, and a product with sparkles
    is metallic or shimmers."""
    names = [
        name
        for name, parts in FINISHES.items()
        if (params.shimmer > _HARDLY_SPARKLES) == (parts[part]["shimmer"] > 0)
        and (name != "sheer" or params.opacity < _SHEER_TO)
    ]
    seen = ("opacity", "gloss", "gloss_roughness")
    return _closest(names, {key: getattr(params, key) for key in seen}, part)


def look_in_words(look: Look, *, with_bare: bool = True) -> str:
    """A look in one line: "lips #B4002E, glossy, opaque; eyes bare; all at 50%".

    with_bare: name lips and eyes even if they are bare; without it a bare look is "nothing".
    """
    parts = [
        f"{kind.part} {part_in_words(look, kind.name) or 'bare'}"
        for kind in KINDS.values()
        if look.of(kind.name) or (with_bare and kind.part in _ALWAYS_NAMED)
    ]
    if not parts:
        return "nothing"
    if look.strength < 1:
        parts.append(f"all at {look.strength:.0%}")
    return "; ".join(parts)


def part_in_words(look: Look, kind: str) -> str:
    """The layers of one kind: "#5A3A2E (lid), matte, opaque + #C08A5A (crease), matte, opaque";
    empty for no layer."""
    layers = look.of(kind)
    return " + ".join(layer_in_words(layer, with_place=len(layers) > 1) for layer in layers)


def layer_in_words(layer: Layer, with_place: bool = False) -> str:
    """One layer: "#B4002E, glossy, opaque", "#5A3A2E (outer, 80%), matte, opaque"."""
    place = place_in_words(layer, with_place)
    colour = f"{layer.product.hex} ({place})" if place else layer.product.hex
    return f"{colour}, {in_words(layer.product, KINDS[layer.kind].part)}"


def place_in_words(layer: Layer, with_place: bool = False) -> str:
    """Where a layer lies and how strong it is, such as "brow bone, left eye, 80%"; the usual place,
    both eyes and full strength are left out.

    with_place: name the usual place, too, for looks with several layers of the kind.
    """
    slot, usual = layer.whole_shape.get("slot"), KINDS[layer.kind].whole_shape({}).get("slot")
    place = slot.replace("_", " ") if slot and (with_place or slot != usual) else ""
    eye = layer.shape.get("eye", BOTH_EYES)
    eye = "" if eye == BOTH_EYES else f"{eye} eye"
    share = f"{layer.strength:.0%}" if layer.strength < 1 else ""
    return ", ".join(filter(None, (place, eye, share)))


def parse_finish(text: str) -> str:
    """The finish that "gloss", "Glossy" or "shiny" names. Raises UsageError."""
    finish = finish_of(text)
    if finish is None:
        raise UsageError(
            f"{option('finish')} must be one of {', '.join(FINISHES)}, got {text!r}"
            f"{did_you_mean(text, finish_names())}"
        )
    return finish


def product(colour: Collection[float] | str, finish: str, part: str = "lips") -> GraphicsParams:
    """A product of a colour and a finish, for a part of a look: a key of PARTS, such as "lips".

    colour: in neutral light: "#B4002E", a name of CSS, or red, green and blue as sRGB-encoded code
    values 0..255.  finish: a name of FINISHES, or another word for a finish, such as "glossy".
    Raises UsageError for an unknown name, LookError for a number out of its range, TypeError for
    another type.
    """
    if not isinstance(finish, str):
        raise TypeError(f"a finish is a name such as 'gloss', got {finish!r}")
    known = parse_finish(finish)
    if part not in PARTS:
        raise UsageError(f"a part is one of {', '.join(PARTS)}, got {part!r}")
    wanted = "a colour is '#B4002E', a name such as 'darkred', or red, green and blue"
    is_ordered = hasattr(colour, "__getitem__") and hasattr(colour, "__len__")
    if not is_ordered or isinstance(colour, Mapping):
        raise TypeError(f"{wanted}, got {colour!r}")
    rgb = rgb_of(colour) if isinstance(colour, str) else colour
    if rgb is None:
        raise UsageError(f"{wanted}, got {colour!r}{like_a_colour(str(colour))}")
    if len(rgb) != 3:
        raise UsageError(f"a colour is red, green and blue, got {len(rgb)} numbers")
    red, green, blue = rgb
    return GraphicsParams(red=red, green=green, blue=blue, **FINISHES[known][part])
