"""Names of files as seen from a folder."""

import os
from pathlib import Path


def seen_from(folder: Path, file: str) -> Path:
    """A file's path relative to a folder, or its full path where no relative path leads there.

    The latter happens on Windows for a file on another drive.
    """
    full = os.path.abspath(file)
    try:
        return Path(os.path.relpath(full, folder.absolute()))
    except ValueError:
        return Path(full)
