"""The inputs of a batch: files, the videos and pictures of folders, and patterns."""

import glob
import os
from collections.abc import Sequence
from pathlib import Path

from makeup_video.pipeline.errors import InputError, UsageError

# What a folder's files are taken for; other files of a folder are left alone.
_ENDS = frozenset((
    ".mp4", ".m4v", ".mov", ".mkv", ".webm", ".avi", ".mpg", ".mpeg", ".ts", ".mts", ".m2ts",
    ".flv", ".asf", ".wmv", ".3gp", ".ogv", ".mxf", ".gif", ".jpg", ".jpeg", ".png", ".webp",
    ".heic", ".heif",
))  # fmt: skip


def inputs_of(given: Sequence[str], written: Sequence[Path] = ()) -> list[str]:
    """The files that are meant, each once, in the order given; those of a folder by name.

    A folder means its videos and pictures, not those of folders in it. A pattern such as
    'clips/**/*.mp4' means every file that it matches. Of a file and links to it the file counts; a
    link that leads nowhere counts, too, so that its job fails alone.
    written: outputs of this batch, which may lie in the same folder; they are no inputs, and
    neither are parts of outputs. A file that is given by its name counts even if it does not exist,
    since its job then fails alone; and so does an output of this batch, unless other files are
    given, too: a shell may have put the names of all files in the place of a pattern.
    Raises UsageError for a folder or a pattern without any file, and where nothing given exists and
    no output was written before; InputError for a folder that cannot be read.
    """
    outputs = {os.path.realpath(path) for path in written}
    found: dict[str, str] = {}
    for one in given:
        files = _files_of(one)
        if not files:
            raise UsageError(_NOTHING_IN.format(one, _what(one)))
        if files != [one]:
            files = [file for file in files if _is_input(file, outputs)]
        for file in files:
            place = os.path.realpath(file)
            if place in found and os.path.islink(found[place]) and not os.path.islink(file):
                del found[place]  # the file itself is meant, with its own name and place
            found.setdefault(place, file)
    others = {place: file for place, file in found.items() if place not in outputs}
    found = others or found
    if not outputs and not any(map(os.path.lexists, found)):
        missing = next(iter(found.values()))
        raise UsageError(_NOTHING_IN.format(missing, "does not exist"))
    return list(found.values())


_NOTHING_IN = "{} {}: give files, a folder with videos or pictures, or a pattern such as '*.mp4'"


def _what(given: str) -> str:
    return "has no videos or pictures" if os.path.isdir(given) else "matches no file"


def _files_of(given: str) -> list[str]:
    if os.path.isdir(given):
        try:
            # a name that begins with a dot is hidden: macOS writes ._clip.mp4 beside clip.mp4
            files = sorted(
                entry.path
                for entry in os.scandir(given)
                if _may_be_file(entry.path) and not entry.name.startswith(".")
            )
        except OSError as error:
            raise InputError(
                f"{given} cannot be read: {error.strerror}; allow it, or give another folder"
            ) from error
        return [file for file in files if os.path.splitext(file)[1].lower() in _ENDS]
    if os.path.lexists(given) or not glob.has_magic(given):
        return [given]
    return sorted(filter(_may_be_file, glob.glob(given, recursive=True)))


def _may_be_file(path: str) -> bool:
    """True for a file and for a link that leads nowhere."""
    return os.path.isfile(path) or not os.path.exists(path)


def _is_input(file: str, outputs: set[str]) -> bool:
    is_part = os.path.splitext(os.path.splitext(file)[0])[1] == ".part"
    return not is_part and os.path.realpath(file) not in outputs
