"""Names of outputs made from a template such as out/{name}-{look}.mp4."""

import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from string import Formatter
from typing import NamedTuple

from makeup_video.pipeline.errors import UsageError, option

# What may stand in braces, and what it becomes.
FIELDS: Mapping[str, str] = {
    "name": "the input's name without its extension",
    "folder": "the name of the folder that the input lies in",
    "ext": "the input's extension without the dot, or jpg or mp4 for kinds that are only read",
    "look": "the look's name",
    "brand": "the brand of a catalogue's row",
    "product": "the product of a catalogue's row",
    "shade": "the shade of a catalogue's row",
}
OF_LOOKS = ("look", "brand", "product", "shade")  # fields that differ from look to look
# Characters that some file system does not allow in a name.
_NOT_IN_NAMES = re.compile(r'[\x00-\x1f\x7f/\\:*?"<>|]+')


class Origin(NamedTuple):
    """What an output is made of, for its name and for messages about the name.

    values: by field, for templates.  source: the input.  look: the look's name, or the file and
    line of its row.  row: the input's row in a list of jobs; empty for none.
    """

    values: Mapping[str, str]
    source: str
    look: str
    row: str = ""


class Template:
    """A template of output names.

    fields: the fields in it, in their order.  Raises UsageError for an unknown field, and for
    braces that hold no field: a brace that belongs to a name is written twice.
    """

    def __init__(self, text: str) -> None:
        if not text:
            raise UsageError("the name of the output is empty: give one")
        self.text = text
        self.fields: list[str] = []
        for field, detail, conversion in _fields_of(text):
            if field not in FIELDS or detail or conversion:
                shown = field + (f"!{conversion}" if conversion else "")
                shown += f":{detail}" if detail else ""
                raise UsageError(f"{option('output')} has {{{shown}}}: {_KNOWN}")
            self.fields.append(field)

    def fill(self, origin: Origin) -> Path:
        """The name of an output; characters in values that no file name can have become "-".

        Raises UsageError for a field whose value is missing or empty.
        """
        clean = {name: in_name(value) for name, value in origin.values.items()}
        for field in self.fields:
            if not clean.get(field):
                whose = origin.look or "the look" if field in OF_LOOKS else origin.source
                raise UsageError(
                    f"{option('output')} has {{{field}}}, {FIELDS[field]}, and {whose} has none: "
                    "choose another field"
                )
        return Path(self.text.format(**clean))

    @property
    def folder(self) -> Path:
        """The folder above all outputs: the part before the first folder with a field."""
        folder = Path(self.text).parent
        while _fields_of(str(folder)):
            folder = folder.parent
        return Path(str(folder).format())  # undoubles the braces of a name


def _fields_of(text: str) -> list[tuple[str, str, str]]:
    """Every field with its format and its conversion, as Python's templates have them."""
    try:
        parts = [
            (field, detail, conversion) for _, field, detail, conversion in Formatter().parse(text)
        ]
    except ValueError:
        raise UsageError(
            f"{option('output')} has a brace without its partner: {text!r}; {_KNOWN}"
        ) from None
    return [(field, detail or "", way or "") for field, detail, way in parts if field is not None]


def field_between(one: Origin, other: Origin) -> str | None:
    """The first field whose values distinguish two outputs; None where there is none."""
    for field in FIELDS:
        values = [in_name(origin.values.get(field, "")).casefold() for origin in (one, other)]
        if all(values) and values[0] != values[1]:
            return field
    return None


def in_name(text: str) -> str:
    """A text as part of a file name."""
    return _NOT_IN_NAMES.sub("-", text.strip()).strip(". ")


def _listed(names: Iterable[str]) -> str:
    return ", ".join("{" + name + "}" for name in names)


_KNOWN = f"the fields are {_listed(FIELDS)}; write a brace of the name itself twice"
