"""Checks the name of an input: it must be a file on this machine."""

import os
from pathlib import Path

from makeup_video.pipeline.errors import InputError
from makeup_video.pipeline.files.disk_errors import unreadable

ANY = "video or picture"


def local_file(path: str | os.PathLike[str], wanted: str = ANY) -> Path:
    """The path of an existing, non-empty, ordinary file; `wanted` names it in messages.

    Raises InputError with the reason.
    """
    if not os.fspath(path):
        raise InputError(f"the name of the {wanted} is empty: give a file on this machine")
    file = Path(path)
    try:
        if file.is_dir():
            many = ", or makeup-video batch, which paints them all" if wanted == ANY else ""
            raise InputError(f"{path} is a folder: give one {wanted} file{many}")
        if not file.exists():
            if "://" in str(path):
                raise InputError(f"{path} is an address: give a {wanted} file on this machine")
            if file.is_symlink():
                raise InputError(
                    f"{path} is a link to {os.readlink(file)}, which does not exist: give a "
                    f"{wanted} file on this machine"
                )
            raise InputError(f"{path} does not exist: give a {wanted} file on this machine")
        if not file.is_file():
            raise InputError(f"{path} is not an ordinary file: give a {wanted} file")
        with file.open("rb") as opened:
            empty = not opened.read(1)
    except InputError:
        raise
    except OSError as error:
        raise InputError(unreadable(path, error)) from error
    if empty:
        raise InputError(f"{path} is empty (0 bytes): give a {wanted} file")
    return file
