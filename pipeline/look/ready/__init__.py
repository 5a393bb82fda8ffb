"""Looks that come with the package: `--look cat-eye`.

NAME.json holds the look's description in words and the look itself, as in a look file:

    {"words": "a black wing and nude lips", "look": {"version": 2, ...}}

The folder is the list: each further file adds a look.
"""

import os
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from makeup_video.pipeline.errors import LookError, option
from makeup_video.pipeline.files.endings import PHOTOS
from makeup_video.pipeline.look.look import Look
from makeup_video.pipeline.look.strict_json import read_json
from makeup_video.pipeline.look.words import did_you_mean, is_none, plain

_FOLDER = Path(__file__).parent


@dataclass(frozen=True, slots=True)
class ReadyLook:
    """A look with a name.

    words: its description, in one line.  path: the file of the package with both.
    """

    name: str
    words: str
    look: Look
    path: Path

    def to_dict(self) -> dict[str, Any]:
        """Name, words and look as JSON values."""
        return {"name": self.name, "words": self.words, "look": self.look.to_dict()}


@cache
def ready_looks() -> tuple[ReadyLook, ...]:
    """Every ready look, by name."""
    looks = []
    for path in sorted(_FOLDER.glob("*.json")):
        values = read_json(path.read_text(encoding="utf-8"))
        looks.append(ReadyLook(path.stem, values["words"], Look.from_dict(values["look"]), path))
    return tuple(looks)


def ready_look(name: str) -> ReadyLook:
    """The ready look with this name; case, spaces, hyphens and underscores do not matter.

    Raises LookError for an unknown name, TypeError for anything but text.
    """
    if not isinstance(name, str):
        raise TypeError(f"a ready look is given by its name, such as 'cat-eye', got {name!r}")
    found = _named(name)
    if found is None:
        raise LookError(f"there is no ready look {name!r}{_instead(name)}")
    return found


def is_file(name: str) -> bool:
    """Whether `load_look` reads a file for a name rather than a ready look: files come first."""
    return not is_none(name) and (_is_there(name) or _named(name) is None)


def load_look(name: str) -> Look:
    """The look of a look file, a ready look, or `none` for a bare look.

    Raises LookError; for a name that is none of these it lists the ready looks.
    """
    if is_none(name):
        return Look()
    if not is_file(name):
        return ready_look(name).look
    if name.lower().endswith(PHOTOS) and os.path.exists(name):
        raise LookError(f"{name} is a photo and no look file: use {option('ref', name)}")
    if _is_there(name) and os.path.isdir(name):
        raise LookError(
            f"{name} is a folder: give a look file in it, or {option('looks', name)} where several "
            "looks are painted"
        )
    if _is_there(name) or not name:
        return Look.load(name)
    if name.lower().endswith(".json"):
        raise LookError(
            f"{name} does not exist: give a look file, or the name of a ready look (`makeup-video "
            "looks`)"
        )
    raise LookError(f"there is no look file and no ready look {name!r}{_instead(name)}")


def _is_there(name: str) -> bool:
    """Whether a file has that name. A folder counts unless it is called like a ready look."""
    return os.path.lexists(name) and not (os.path.isdir(name) and _named(name))


def _named(name: str) -> ReadyLook | None:
    return next((one for one in ready_looks() if plain(one.name) == plain(name)), None)


def _instead(name: str) -> str:
    """The ready look that a name may mean, and all ready looks, as the end of a message."""
    names = [one.name for one in ready_looks()]
    meant = did_you_mean(name, names)
    begins = f"{meant} Ready" if meant else "; ready"
    return f"{begins} looks are {', '.join(names)}"
