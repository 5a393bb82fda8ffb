"""A look from what a user chose: a ready look, a file or a photo, and options that change it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

from makeup_video.pipeline.errors import UsageError, option
from makeup_video.pipeline.look.finishes import parse_finish, product
from makeup_video.pipeline.look.kinds import KINDS, PARTS
from makeup_video.pipeline.look.look import Layer, Look
from makeup_video.pipeline.look.part_options import COLOUR, layers_of, parse_color, parse_share
from makeup_video.pipeline.look.words import (
    did_you_mean,
    part_names,
    part_of,
    slot_named,
)

DEFAULT_PARTS = tuple(PARTS)[:1]  # the parts that a colour without a look is for
PARTS_IN_WORDS = f"{', '.join(PARTS)} or several of them, such as {','.join(tuple(PARTS)[:2])}"
_SHADOW = KINDS["eyeshadow"]  # whose zone and strength have options of their own
_COLOUR = option("color", COLOUR)
_NOTHING = (
    f"no look given: add {option('ref', 'PHOTO')}, {option('look', 'NAME')}, "
    f"{option(DEFAULT_PARTS[0], COLOUR)}, or {option('look', 'none')} to paint nothing"
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Choice:
    """The options of the command that make a look, as they were typed; None: not given.

    base: the look of --look, empty for `none`, or the one read from --ref.
    worn: what the parts wear, by part: COLOUR[:WORD...], or `none`.
    """

    base: Look | None = None
    worn: Mapping[str, str] = field(default_factory=dict)
    color: str | None = None
    finish: str | None = None
    parts: str | None = None
    zone: str | None = None
    intensity: str | None = None
    strength: str | None = None


def choose_look(choice: Choice) -> Look:
    """The look that a choice means.

    A part's own option replaces all of its layers. `color` and `finish` change the other parts that
    `parts` names; without `parts` they change the lips and eyes that the base paints, else the
    lips. With `parts`, all parts that it does not name become bare, except parts with an option of
    their own.
    Raises UsageError or LookError, one line naming the option.
    """
    check_options(choice)
    rgb = None if choice.color is None else parse_color(choice.color)
    finish = None if choice.finish is None else parse_finish(choice.finish)
    if choice.base is None and rgb is None and not choice.worn:
        raise UsageError(_NOTHING if finish is None else _colourless(finish))
    base = choice.base or Look()
    for part, text in choice.worn.items():
        base = base.with_kind(PARTS[part].name, layers_of(part, text, finish))
    if choice.parts is None:
        kept, changed = _all_parts(base, rgb, finish, choice.worn)
    else:
        named = parse_parts(choice.parts)
        kept = tuple(part for part in PARTS if part in named or part in choice.worn)
        changed = tuple(part for part in named if part not in choice.worn)
    layers: list[Layer] = []
    for part in kept:
        if part not in changed:
            layers += base.of(PARTS[part].name)
        else:
            layers += _layers(base, part, rgb, finish)
    return _with_dials(Look(layers, base.strength), choice)


def _all_parts(
    base: Look, rgb: Sequence[float] | None, finish: str | None, worn: Mapping[str, str]
) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """The parts to paint, and which of them take the colour and the finish, when `parts` names
    none."""
    painted = tuple(part for part, kind in PARTS.items() if kind.name in base.kinds)
    changed = tuple(part for part in painted if PARTS[part].follows_color and part not in worn)
    if not changed and rgb is not None:
        if said := [part for part in DEFAULT_PARTS if part in worn]:
            raise UsageError(
                f"{option('color')} is for the {said[0]}, and so is {option(said[0])}: leave one "
                "of them out"
            )
        return (*painted, *DEFAULT_PARTS), DEFAULT_PARTS
    if not changed and finish is not None and not worn:
        if not painted:
            raise UsageError(_colourless(finish))
        raise UsageError(
            f"{option('finish', finish)} is for lips and eyes, and the look has neither: add "
            f"{option('parts', painted[0])}, or leave it out"
        )
    return painted, changed


def check_options(choice: Choice) -> None:
    """Check all that needs no base look. Raises UsageError as choose_look does."""
    if choice.color is not None:
        parse_color(choice.color)
    finish = None if choice.finish is None else parse_finish(choice.finish)
    for part, text in choice.worn.items():
        layers_of(part, text, finish)
    if choice.parts is not None:
        parse_parts(choice.parts)
    if choice.zone is not None:
        parse_zone(choice.zone)
    for name in ("strength", "intensity"):
        if (text := getattr(choice, name)) is not None:
            parse_share(text, option(name))


def parse_parts(text: str) -> tuple[str, ...]:
    """The parts named in 'lips,eyes', each once, in the registry's order. Raises UsageError."""
    parts = {word: part_of(word) for word in text.split(",")}
    for word, part in parts.items():
        if part is None:
            raise UsageError(
                f"{option('parts')} must be {PARTS_IN_WORDS}, got {text!r}"
                f"{did_you_mean(word, part_names())}"
            )
    return tuple(part for part in PARTS if part in parts.values())


def parse_zone(text: str) -> str:
    """The zone of eyeshadow that "outer" or "outer corner" names. Raises UsageError."""
    slot = slot_named(text, _SHADOW)
    if slot is None:
        raise UsageError(
            f"{option('zone')} must be one of {', '.join(_SHADOW.slots)}, got {text!r}"
            f"{did_you_mean(text, _SHADOW.slots)}"
        )
    return slot


def _layers(base: Look, part: str, rgb: Sequence[float] | None, finish: str | None) -> list[Layer]:
    """The layers of a part that is changed: its old layers in another colour or another finish, or
    a new layer."""
    old = base.of(PARTS[part].name)
    if not old:
        if rgb is None:
            raise UsageError(
                f"{option('parts')} names the {part}, which the look leaves bare: add {_COLOUR}, "
                f"or leave {part} out"
            )
        return [Layer(PARTS[part].name, product(rgb, finish or PARTS[part].first_finish, part))]
    return [_changed(layer, part, rgb, finish) for layer in old]


def _changed(layer: Layer, part: str, rgb: Sequence[float] | None, finish: str | None) -> Layer:
    old = layer.product
    colour = rgb or (old.red, old.green, old.blue)
    if finish is not None:
        new = product(colour, finish, part)
        if layer.shape.get("map"):  # read from a photo: densities and opacity are one measurement
            new = replace(new, opacity=old.opacity)
        return replace(layer, product=new)
    red, green, blue = colour
    return replace(layer, product=replace(old, red=red, green=green, blue=blue))


def _with_dials(look: Look, choice: Choice) -> Look:
    """The look with the strength, and with the zone and the strength of its eyeshadow."""
    if choice.strength is not None:
        look = replace(look, strength=parse_share(choice.strength, option("strength")))
    shadows = look.of(_SHADOW.name)
    for name in ("zone", "intensity"):
        if getattr(choice, name) is not None and not shadows:
            flag = option(name)
            raise UsageError(
                f"{flag} is for eyeshadow, and no eyes are painted: add "
                f"{option(_SHADOW.part, COLOUR)}, or leave {flag} out"
            )
    if choice.zone is not None and len(shadows) > 1:
        raise UsageError(
            f"{option('zone')} is for one eyeshadow, and the look has {len(shadows)}, each in a "
            f"place of its own: leave {option('zone')} out"
        )
    if choice.zone is not None:
        (layer,), zone = shadows, parse_zone(choice.zone)
        eye = {name: value for name, value in layer.shape.items() if name == "eye"}
        shadows = (replace(layer, shape={"slot": zone, **eye}),)
    if choice.intensity is not None:
        shadows = _scaled(shadows, parse_share(choice.intensity, option("intensity")))
    return look.with_kind(_SHADOW.name, shadows)


def _scaled(layers: Sequence[Layer], strength: float) -> tuple[Layer, ...]:
    """Layers with other strengths: the strongest layer gets `strength`, the others keep their
    proportion to it."""
    most = max(layer.strength for layer in layers)
    return tuple(
        replace(layer, strength=strength * (layer.strength / most if most else 1))
        for layer in layers
    )


def _colourless(finish: str) -> str:
    return (
        f"{option('finish', finish)} needs a colour: add {_COLOUR}, {option('ref', 'PHOTO')}, or "
        f"a look that has one ({option('look', 'NAME')})"
    )
