"""The inputs of a batch: files, the videos and pictures of folders, and patterns."""

import glob
import os
from collections.abc import Sequence
from pathlib import Path

from makeup_video.pipeline.errors import InputError, UsageError
from makeup_video.pipeline.files.endings import PHOTOS, PICTURES, VIDEOS
from makeup_video.pipeline.files.local_file import local_file

# Pictures that are read only as the photo of a look.
_OF_LOOKS = tuple(end for end in PHOTOS if end not in PICTURES)
NOT_PAINTED = "AVIF, BMP and TIFF pictures"


def left_out_of(given: Sequence[str]) -> list[str]:
    """The pictures in the given folders that cannot be painted, such as TIFF."""
    folders = filter(os.path.isdir, given)
    return list(dict.fromkeys(file for one in folders for file in _in_folder(one, _OF_LOOKS)))


def inputs_of(given: Sequence[str], written: Sequence[Path] = ()) -> list[str]:
    """The input files, each once, in the order given; those of a folder are sorted by name.

    A folder stands for its videos and pictures, without those of folders in it. A pattern such as
    'clips/**/*.mp4' stands for every file that it matches. Of a file and links to it, the file
    counts. A link that leads nowhere counts, too, so that its job fails alone.
    written: outputs of this batch, which may lie in the same folder. From folders and patterns,
    neither these outputs nor parts of outputs become inputs.
    A file that is given by its name counts even if it does not exist, since its job then fails
    alone. An output of this batch that is given by its name counts only if no other files are
    given: a shell may have put the names of all files in the place of a pattern.
    Raises UsageError for a folder or a pattern without any file; InputError for a folder that
    cannot be read, and for an empty name.
    """
    outputs = {os.path.realpath(path) for path in written}
    found: dict[str, str] = {}
    for one in given:
        files = _files_of(one)
        inputs = files if files == [one] else [file for file in files if _is_input(file, outputs)]
        if not files or not (inputs or outputs):
            raise UsageError(_NOTHING_IN.format(one, _what(one)))
        for file in inputs:
            place = os.path.realpath(file)
            if place in found and os.path.islink(found[place]) and not os.path.islink(file):
                del found[place]  # the file itself is meant, with its own name and place
            found.setdefault(place, file)
    others = {place: file for place, file in found.items() if place not in outputs}
    return list((others or found).values())


def check_some_exist(inputs: Sequence[str], where: str = "") -> None:
    """Raises UsageError if no input exists, for example because a folder's name is mistyped.

    where: the row of a list that names the first input; empty for none.
    """
    if any(map(os.path.exists, inputs)):
        return
    if where:
        raise UsageError(f"{where}: {inputs[0]} does not exist: give files on this machine")
    raise UsageError(_NOTHING_IN.format(inputs[0], "does not exist"))


_NOTHING_IN = "{} {}: give files, a folder with videos or pictures, or a pattern such as '*.mp4'"


def _what(given: str) -> str:
    if not os.path.isdir(given):
        return "matches no file"
    if left_out_of([given]):
        return f"has no videos or pictures but {NOT_PAINTED}, which are not painted"
    return "has no videos or pictures"


def _files_of(given: str) -> list[str]:
    if os.path.isdir(given):
        return _in_folder(given, (*VIDEOS, *PICTURES))
    if not given:
        local_file(given)  # raises: the line of all commands for an empty name
    if os.path.lexists(given) or not glob.has_magic(given):
        return [given]
    return sorted(filter(_may_be_file, glob.glob(given, recursive=True)))


def _in_folder(folder: str, ends: Sequence[str]) -> list[str]:
    """The files with these extensions, by name. Raises InputError."""
    try:
        # a name that begins with a dot is hidden: macOS writes ._clip.mp4 beside clip.mp4
        return sorted(
            entry.path
            for entry in os.scandir(folder)
            if os.path.splitext(entry.name)[1].lower() in ends
            and _may_be_file(entry.path)
            and not entry.name.startswith(".")
        )
    except OSError as error:
        raise InputError(
            f"{folder} cannot be read: {error.strerror}; allow it, or give another folder"
        ) from error


def _may_be_file(path: str) -> bool:
    """True for a file and for a link that leads nowhere."""
    return os.path.isfile(path) or not os.path.exists(path)


def _is_input(file: str, outputs: set[str]) -> bool:
    is_part = os.path.splitext(os.path.splitext(file)[0])[1] == ".part"
    return not is_part and os.path.realpath(file) not in outputs
