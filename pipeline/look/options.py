"""A look from what a user chose: a look file or a photo, a colour, a finish, parts, dials."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any, cast

from makeup_video.pipeline.errors import LookError, UsageError, option
from makeup_video.pipeline.look.finishes import FINISHES, product
from makeup_video.pipeline.look.look import Look
from makeup_video.pipeline.look.params import GraphicsParams, rgb_of_hex
from makeup_video.pipeline.look.regions import REGIONS

DEFAULT_FINISH = "satin"
DEFAULT_PARTS = tuple(REGIONS)[:1]  # of a colour without a look
PARTS = f"{', '.join(REGIONS)} or {','.join(REGIONS)}"  # what parse_parts reads, in words
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
    the base's colour, and the finish all but the colour, of the parts, or of all parts that the
    base has. Parts that are not chosen become bare.  Raises UsageError or LookError, one line
    naming the option.
    """
    check_options(choice)
    rgb = None if choice.color is None else parse_color(choice.color)
    parts = None if choice.parts is None else parse_parts(choice.parts)
    if choice.base is None and rgb is None:
        raise UsageError(_NOTHING if choice.finish is None else _colourless(choice.finish))
    base = choice.base or Look()
    if parts is None:
        parts = tuple(base.products)
        if not parts and rgb is not None:
            parts = DEFAULT_PARTS
        if not parts and choice.finish is not None:
            raise UsageError(_colourless(choice.finish))
    products = {
        name: _product(name, getattr(base, name), rgb, choice.finish) if name in parts else None
        for name in REGIONS
    }
    look: Look = replace(base, **cast(dict[str, Any], products))
    return _with_dials(look, choice)


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
    _set_dials(Look(), _dials(choice))


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
    """The regions named in 'lips,eyes', each once, in the registry's order. Raises UsageError."""
    names = [name.strip() for name in text.split(",")]
    if any(name not in REGIONS for name in names):
        raise UsageError(f"{option('parts')} must be {PARTS}, got {text!r}")
    return tuple(name for name in REGIONS if name in names)


def _product(
    name: str, old: GraphicsParams | None, rgb: Sequence[float] | None, finish: str | None
) -> GraphicsParams:
    """What a chosen region wears: the old product in another colour or another finish, or a new
    one."""
    if old is None:
        if rgb is None:
            raise UsageError(
                f"{option('parts')} names the {name}, which the look leaves bare: add {_COLOUR}, "
                f"or leave {name} out"
            )
        return product(rgb, finish or DEFAULT_FINISH, name)
    colour = rgb or (old.red, old.green, old.blue)
    if finish is not None:
        return product(colour, finish, name)
    return replace(old, red=colour[0], green=colour[1], blue=colour[2])


def _with_dials(look: Look, choice: Choice) -> Look:
    dials = _dials(choice)
    for region in REGIONS.values():
        for dial in region.dials:
            if dial.name in dials and region.name not in look.products:
                flag = option(dial.name)
                raise UsageError(
                    f"{flag} is for {region.product.lower()}, and no {region.name} are painted: "
                    f"add {option('parts', region.name)} or {option('parts', ','.join(REGIONS))}, "
                    f"or leave {flag} out"
                )
    return _set_dials(look, dials)


def _dials(choice: Choice) -> dict[str, Any]:
    names = ["strength", *(dial.name for region in REGIONS.values() for dial in region.dials)]
    values = {name: getattr(choice, name, None) for name in names}
    return {name: value for name, value in values.items() if value is not None}


def _set_dials(look: Look, dials: dict[str, Any]) -> Look:
    for name, value in dials.items():
        try:
            look = replace(look, **{name: value})
        except LookError as error:  # its message begins with the name
            raise UsageError(option(name) + str(error).removeprefix(name)) from None
    return look


def _colourless(finish: str) -> str:
    return (
        f"{option('finish', finish)} needs a colour: add {_COLOUR}, {option('ref', 'PHOTO')}, or "
        f"{option('look', 'FILE.json')} that has one"
    )
