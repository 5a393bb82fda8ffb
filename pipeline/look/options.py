"""Puts a look together from what a user chose: a look file, a colour, a finish, parts, dials."""

from collections.abc import Sequence
from dataclasses import dataclass, fields, replace
from typing import Any

from makeup_video.pipeline.errors import LookError, UsageError
from makeup_video.pipeline.look.finishes import FINISHES, REGIONS, product
from makeup_video.pipeline.look.look import Look
from makeup_video.pipeline.look.params import GraphicsParams, rgb_of_hex

DEFAULT_FINISH = "satin"
_NOTHING = (
    "no look given: add --look FILE.json, --color '#B4002E', --ref PHOTO, or --look none to paint "
    "nothing"
)


@dataclass(frozen=True, slots=True, kw_only=True)
class Choice:
    """What was said on the command line; None: not said.

    base: the look of --look, empty for `none`, or the one read from --ref.  The others are the options of the same names, as
    they were typed.
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

    Without --look or --ref, --color paints the lips, or the --parts. On top of a look, --color replaces the
    colour, --finish all but the colour, of the --parts, which are else all parts that the look has;
    parts left out of --parts become bare.  Raises UsageError or LookError, one line naming the
    option.
    """
    check_options(choice)
    rgb = None if choice.color is None else parse_color(choice.color)
    parts = None if choice.parts is None else parse_parts(choice.parts)
    if choice.base is None and rgb is None:
        raise UsageError(_NOTHING if choice.finish is None else _colourless(choice.finish))
    base = choice.base or Look()
    if parts is None:
        parts = tuple(name for name in REGIONS if getattr(base, name) is not None)
        if not parts and rgb is not None:
            parts = ("lips",)
        if not parts and choice.finish is not None:
            raise UsageError(_colourless(choice.finish))
    regions: dict[str, Any] = {
        name: _region(name, getattr(base, name), rgb, choice.finish) if name in parts else None
        for name in REGIONS
    }
    return _with_dials(replace(base, **regions), choice)


def check_options(choice: Choice) -> None:
    """What can be told of the options before there is a base. Raises UsageError as choose_look does."""
    if choice.color is not None:
        parse_color(choice.color)
    if choice.finish is not None and choice.finish not in FINISHES:
        raise UsageError(f"--finish must be one of {', '.join(FINISHES)}, got {choice.finish!r}")
    if choice.parts is not None:
        parse_parts(choice.parts)
    _dialled(Look(), _dials(choice))


def parse_color(text: str) -> tuple[int, int, int]:
    """Red, green, blue, 0..255, from '#B4002E', 'B4002E' or '#B02'. Raises UsageError."""
    rgb = rgb_of_hex(text)
    if rgb is None:
        raise UsageError(
            f"--color must be 3 or 6 hex digits such as '#B4002E' (quote the #), got {text!r}"
        )
    return rgb


def parse_parts(text: str) -> tuple[str, ...]:
    """The regions named in 'lips,eyes', each once. Raises UsageError."""
    names = [name.strip() for name in text.split(",")]
    if any(name not in REGIONS for name in names):
        raise UsageError(f"--parts must be {', '.join(REGIONS)} or lips,eyes, got {text!r}")
    return tuple(name for name in REGIONS if name in names)


def _region(
    name: str, old: GraphicsParams | None, rgb: Sequence[float] | None, finish: str | None
) -> GraphicsParams:
    """The region painted: what it was, with another colour or another finish."""
    if old is None:
        if rgb is None:
            raise UsageError(
                f"--parts names the {name}, which the look leaves bare: add --color '#B4002E', or "
                f"leave {name} out"
            )
        return product(rgb, finish or DEFAULT_FINISH, name)
    colour = rgb or (old.red, old.green, old.blue)
    if finish is not None:
        return product(colour, finish, name)
    return replace(old, red=colour[0], green=colour[1], blue=colour[2])


def _with_dials(look: Look, choice: Choice) -> Look:
    dials = _dials(choice)
    for name in ("zone", "intensity"):
        if name in dials and look.eyes is None:
            raise UsageError(
                f"--{name} is for eye-shadow, and no eyes are painted: add --parts eyes or "
                f"--parts lips,eyes, or leave --{name} out"
            )
    return _dialled(look, dials)


def _dials(choice: Choice) -> dict[str, Any]:
    return {
        spec.name: value
        for spec in fields(Choice)
        if spec.name in ("zone", "intensity", "strength")
        and (value := getattr(choice, spec.name)) is not None
    }


def _dialled(look: Look, dials: dict[str, Any]) -> Look:
    try:
        return replace(look, **dials)
    except LookError as error:
        raise UsageError(f"--{error}") from None


def _colourless(finish: str) -> str:
    return (
        f"--finish {finish} needs a colour: add --color '#B4002E', --ref PHOTO, or --look FILE.json "
        "that has one"
    )
