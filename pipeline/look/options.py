"""A look from what a user chose: a look file or a photo, a colour, a finish, parts, dials."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

from makeup_video.pipeline.errors import LookError, UsageError, option
from makeup_video.pipeline.look.finishes import FINISHES, product
from makeup_video.pipeline.look.kinds import PARTS
from makeup_video.pipeline.look.look import ZONES, Layer, Look
from makeup_video.pipeline.look.params import rgb_of_hex

DEFAULT_FINISH = "satin"
DEFAULT_PARTS = tuple(PARTS)[:1]  # of a colour without a look
PARTS_IN_WORDS = f"{', '.join(PARTS)} or several of them, such as {','.join(tuple(PARTS)[:2])}"
_COLOUR = option("color", "'#B4002E'")
_NOTHING = (
    f"no look given: add {option('look', 'FILE.json')}, {_COLOUR}, {option('ref', 'PHOTO')}, or "
    f"{option('look', 'none')} to paint nothing"
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Choice:
    """The options of the command that make a look, as they were typed; None: not given.

    base: the look of --look, empty for `none`, or the one read from --ref.
    """

    base: Look | None = None
    color: str | None = None
    finish: str | None = None
    parts: str | None = None
    zone: str | None = None
    intensity: float | None = None
    strength: float | None = None


def choose_look(choice: Choice) -> Look:
    """The look that a choice means.

    Without a base, the colour paints the parts, or the lips. On top of a base, the colour replaces
    the base's colour, and the finish all but the colour, of the parts, or of lips and eyes where
    the base has them. Parts that are not chosen become bare.  Raises UsageError or LookError, one
    line naming the option.
    """
    check_options(choice)
    rgb = None if choice.color is None else parse_color(choice.color)
    if choice.base is None and rgb is None:
        raise UsageError(_NOTHING if choice.finish is None else _colourless(choice.finish))
    base = choice.base or Look()
    if choice.parts is None:
        kept, changed = _all_parts(base, rgb, choice.finish)
    else:
        kept = changed = parse_parts(choice.parts)
    layers = []
    for part in kept:
        change = (rgb, choice.finish) if part in changed else (None, None)
        layers += _layers(base, part, *change)
    return _with_dials(Look(layers, base.strength), choice)


def _all_parts(
    base: Look, rgb: Sequence[float] | None, finish: str | None
) -> tuple[tuple[str, ...], tuple[str, ...]]:
    """The parts to paint, and those of them that take the colour and the finish, where none were
    named."""
    worn = tuple(part for part, kind in PARTS.items() if kind.name in base.kinds)
    changed = tuple(part for part in worn if PARTS[part].follows_color)
    if not changed and rgb is not None:
        return (*worn, *DEFAULT_PARTS), DEFAULT_PARTS
    if not changed and finish is not None:
        raise UsageError(_colourless(finish))
    return worn, changed


def check_options(choice: Choice) -> None:
    """Check what needs no base. Raises UsageError as choose_look does."""
    if choice.color is not None:
        parse_color(choice.color)
    if choice.finish is not None and choice.finish not in FINISHES:
        raise UsageError(
            f"{option('finish')} must be one of {', '.join(FINISHES)}, got {choice.finish!r}"
        )
    if choice.parts is not None:
        parse_parts(choice.parts)
    if choice.zone is not None and choice.zone not in ZONES:
        raise UsageError(f"{option('zone')} must be one of {', '.join(ZONES)}, got {choice.zone!r}")
    for name in ("strength", "intensity"):
        value = getattr(choice, name)
        if value is not None:
            _checked(name, value)


def _checked(name: str, value: float) -> None:
    try:
        Look(**{name: value})
    except LookError as error:  # its message begins with the name
        raise UsageError(option(name) + str(error).removeprefix(name)) from None


def parse_color(text: str) -> tuple[int, int, int]:
    """Red, green, blue, 0..255, from '#B4002E', 'B4002E' or '#B02'. Raises UsageError."""
    rgb = rgb_of_hex(text)
    if rgb is None:
        raise UsageError(
            f"{option('color')} must be 3 or 6 hex digits such as '#B4002E' (quote the #), got "
            f"{text!r}"
        )
    return rgb


def parse_parts(text: str) -> tuple[str, ...]:
    """The parts named in 'lips,eyes', each once, in the registry's order. Raises UsageError."""
    names = [name.strip() for name in text.split(",")]
    if any(name not in PARTS for name in names):
        raise UsageError(f"{option('parts')} must be {PARTS_IN_WORDS}, got {text!r}")
    return tuple(name for name in PARTS if name in names)


def _layers(base: Look, part: str, rgb: Sequence[float] | None, finish: str | None) -> list[Layer]:
    """What a chosen part wears: its old layers in another colour or another finish, or a new
    one."""
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
        return replace(layer, product=product(colour, finish, part))
    red, green, blue = colour
    return replace(layer, product=replace(old, red=red, green=green, blue=blue))


def _with_dials(look: Look, choice: Choice) -> Look:
    """The look with the strength, and with the place and the strength of its eye-shadow."""
    if choice.strength is not None:
        look = replace(look, strength=choice.strength)
    shadows = look.of("eyeshadow")
    for name in ("zone", "intensity"):
        if getattr(choice, name) is not None and not shadows:
            flag = option(name)
            raise UsageError(
                f"{flag} is for eye-shadow, and no eyes are painted: add {option('parts', 'eyes')} "
                f"or {option('parts', ','.join(tuple(PARTS)[:2]))}, or leave {flag} out"
            )
    if choice.zone is not None and len(shadows) > 1:
        raise UsageError(
            f"{option('zone')} is for one eye-shadow, and the look has {len(shadows)}, each in a "
            f"place of its own: leave {option('zone')} out"
        )
    if choice.zone is not None:
        shadows = tuple(replace(layer, shape={"slot": choice.zone}) for layer in shadows)
    if choice.intensity is not None:
        shadows = tuple(replace(layer, strength=choice.intensity) for layer in shadows)
    return look.with_kind("eyeshadow", shadows)


def _colourless(finish: str) -> str:
    return (
        f"{option('finish', finish)} needs a colour: add {_COLOUR}, {option('ref', 'PHOTO')}, or "
        f"{option('look', 'FILE.json')} that has one"
    )
