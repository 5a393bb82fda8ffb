"""What `--lips`, `--eyes` and the options of other parts mean: COLOUR[:WORD...], or `none`.

A word is a finish, a zone, a share such as 80%, or a number of the kind's shape such as wing=0.3.
Commas separate layers: `--eyes '#5A3A2E:outer:80%,peachpuff:shimmer:lid'`.
"""

import re
from typing import Any

from makeup_video.pipeline.errors import LookError, UsageError, option
from makeup_video.pipeline.look.finishes import FINISHES, product
from makeup_video.pipeline.look.kinds import PARTS
from makeup_video.pipeline.look.kinds.kind import Dial, Kind
from makeup_video.pipeline.look.look import Layer, most_in_a_place
from makeup_video.pipeline.look.params import hex_of
from makeup_video.pipeline.look.words import (
    did_you_mean,
    finish_names,
    finish_of,
    is_none,
    like_a_colour,
    number_of,
    plain,
    rgb_of,
    slot_named,
)

COLOUR = "'#B4002E'"  # in examples with quotes: shells take an unquoted # for a comment
_BETWEEN_LAYERS = re.compile(r",(?![^(]*\))")  # but not the commas of rgb(180, 0, 46)


def parse_color(text: str, name: str = "color") -> tuple[int, int, int]:
    """Red, green, blue, 0..255, from '#B4002E', 'B02', 'dark red' or 'rgb(180, 0, 46)'.

    name: the option's, for messages.  Raises UsageError.
    """
    if not text.strip():
        raise UsageError(
            f"{option(name)} has no colour: quote one that begins with #, as in "
            f"{option(name, COLOUR)}"
        )
    rgb = rgb_of(text)
    if rgb is None:
        raise UsageError(
            f"{option(name)} must be a colour such as {COLOUR}, B4002E, darkred or "
            f"'rgb(180, 0, 46)', got {text!r}{like_a_colour(text)}"
        )
    return rgb


def parse_share(text: str, what: str) -> float:
    """A share from "0.8" or "80%".  what: the beginning of the message.  Raises UsageError."""
    number = number_of(text)
    if number is None or not 0 <= number <= 1:
        # 1.2 is no percentage: whoever types it means more than all
        is_percent = number is not None and 10 <= number <= 100 and "%" not in text
        meant = ""
        if is_percent:
            meant = f": did you mean {text.strip()}%?"
        elif number is not None and number > 1:
            meant = ": 1 (100%) is the most"
        raise UsageError(
            f"{what} must be a number in 0..1 or a percentage such as 80%, got {text!r}{meant}"
        )
    return number


def layers_of(part: str, text: str, finish: str | None = None) -> tuple[Layer, ...]:
    """The layers that an option's value means, none for `none`.

    part: a key of PARTS, the option's name.  finish: for layers that name no finish; None: the
    kind's first_finish.  Raises UsageError.
    """
    if is_none(text):
        return ()
    kind, texts = PARTS[part], _BETWEEN_LAYERS.split(text)
    meant = _meant(kind, texts)
    if len(texts) > kind.most and (meant or not kind.has_eyes):
        raise _too_many(kind, f"{len(texts)}: {text!r}{meant}")
    if meant:
        raise UsageError(f"{option(part)}: put words after colons{meant}")
    made = tuple(_layer(kind, one, finish) for one in texts)
    count, where = most_in_a_place([layer.shape for layer in made])
    if count > kind.most:
        raise _too_many(kind, f"{count}{where}: {text!r}")
    return made


def _too_many(kind: Kind, got: str) -> UsageError:
    most = "one colour" if kind.most == 1 else f"at most {kind.most} layers"
    return UsageError(f"{option(kind.part)} takes {most}, got {got}")


def _layer(kind: Kind, text: str, finish: str | None) -> Layer:
    colour, *words = text.split(":")
    rgb = rgb_of(colour)
    if rgb is None:
        if _is_word(kind, colour):
            raise UsageError(
                f"{option(kind.part)} begins with a colour, as in {COLOUR[:-1]}:{colour.strip()}', "
                f"got {text!r}"
            )
        if meant := _spaced(kind, colour):
            raise UsageError(f"{option(kind.part)}: put words after colons{meant}")
        rgb = parse_color(colour, kind.part)
    said: dict[str, Any] = {}
    shape: dict[str, Any] = {}
    for word in words:
        name, value = _meaning(kind, word)
        kept = shape if name in _names_of_dials(kind) else said
        if name in kept:
            called = "zone" if name == "slot" else name.replace("_", " ")
            raise UsageError(
                f"{option(kind.part)} gives the {called} twice: {text!r}; leave one out"
            )
        kept[name] = value
    chosen = said.get("finish") or finish or kind.first_finish
    return Layer(kind.name, product(rgb, chosen, kind.part), shape, said.get("strength", 1.0))


def _meant(kind: Kind, texts: list[str]) -> str:
    """ ": did you mean 'red:matte'?" where commas or spaces stand for colons, ": did you mean
    'rgb(180, 0, 46)'?" where only its numbers are given, else nothing."""
    first, *rest = texts
    numbers = f"rgb({', '.join(one.strip() for one in texts)})"
    are_colours = len(texts) <= kind.most and all(rgb_of(one) is not None for one in texts)
    if are_colours:  # asked first: 000000 is a share, too
        return ""
    if len(texts) == 3 and all(one.strip().isdigit() for one in texts) and rgb_of(numbers):
        return f": did you mean '{numbers}'?"
    if rest and rgb_of(first) is not None and all(_is_word(kind, one) for one in rest):
        return f": did you mean '{':'.join(one.strip() for one in texts)}'?"
    return ""


def _spaced(kind: Kind, text: str) -> str:
    """ ": did you mean 'dark red:matte'?" for words after spaces rather than colons."""
    words = text.split()
    for count in range(len(words) - 1, 0, -1):
        meant = _meant(kind, [" ".join(words[:count]), *words[count:]])
        if meant:
            return meant
    return ""


def _is_word(kind: Kind, text: str) -> bool:
    """Whether a text is a finish, a zone, an eye or a share, which come after the colour."""
    number = number_of(text)
    is_share = number is not None and 0 <= number <= 1
    is_choice = slot_named(text, kind) or _choice_named(kind, text)
    return bool(finish_of(text) or is_choice or is_share)


def _names_of_dials(kind: Kind) -> list[str]:
    return [dial.name for dial in kind.dials]


def _meaning(kind: Kind, word: str) -> tuple[str, Any]:
    """What a word after the colour sets, and to what."""
    name, equals, value = word.partition("=")
    if equals:
        return _dial_value(kind, name, value)
    if number_of(word) is not None:
        return "strength", parse_share(word, f"{option(kind.part)}: the strength")
    if finish := finish_of(word):
        return "finish", finish
    if slot := slot_named(word, kind):
        return "slot", slot
    if chosen := _choice_named(kind, word):
        return chosen
    if (dial := _dial_named(kind, word)) and not dial.is_map:
        raise UsageError(
            f"{option(kind.part)}: {word.strip()} needs a value, as in {_example(dial)}"
        )
    choices = [dial for dial in kind.dials if dial.choices]
    others = "".join(
        f", {'an' if dial.name == 'eye' else 'a'} {dial.title.lower()} ({', '.join(dial.choices)})"
        for dial in choices
    )
    known = [*finish_names(), *(one for dial in choices for one in dial.choices)]
    raise UsageError(
        f"{option(kind.part)}: {word!r} is no finish ({', '.join(FINISHES)}){others}, "
        f"strength (80%) or NAME=VALUE of its shape{did_you_mean(word, known)}"
    )


def _dial_named(kind: Kind, name: str) -> Dial | None:
    return next((dial for dial in kind.dials if plain(dial.name) == plain(name)), None)


def _choice_named(kind: Kind, word: str) -> tuple[str, str] | None:
    """The dial and the choice that a word names, such as `eye` and "left"; not for zones."""
    dials = [dial for dial in kind.dials if dial.name != "slot"]
    choices = [(dial.name, one) for dial in dials for one in dial.choices]
    return next((pair for pair in choices if plain(pair[1]) == plain(word)), None)


def _example(dial: Dial) -> str:
    """A value of a dial as it is typed: "wing=0.5"."""
    if dial.is_colour:
        return f"{dial.name}=maroon"
    return f"{dial.name}={dial.choices[0] if dial.choices else f'{dial.high / 2:g}'}"


def _dial_value(kind: Kind, name: str, value: str) -> tuple[str, Any]:
    dial = _dial_named(kind, name)
    if dial is None:
        names = _names_of_dials(kind)
        raise UsageError(
            f"{option(kind.part)} has no {name.strip()!r}; its shape has {', '.join(names)}"
            f"{did_you_mean(name, names)}"
        )
    return dial.name, _checked(kind, dial, value.strip())


def _checked(kind: Kind, dial: Dial, text: str) -> Any:
    value: Any = text
    if dial.choices:
        known = slot_named(text, kind) if dial.name == "slot" else None
        value = known or next((one for one in dial.choices if plain(one) == plain(text)), text)
    elif dial.is_colour:
        rgb = rgb_of(text)
        value = text if rgb is None else hex_of(rgb)
    else:
        number = number_of(text)
        value = text if number is None else number
    try:
        dial.check(value, dial.name)
    except LookError as error:  # its message begins with the name
        raise UsageError(f"{option(kind.part)}: {error}") from None
    return value
