"""Argument types for argparse: paths of a command's inputs, which must exist."""

import argparse
from collections.abc import Callable
from pathlib import Path


def existing(text: str) -> Path:
    """The path of an existing file or folder. Raises ArgumentTypeError if there is none."""
    path = Path(text)
    if not path.exists():
        raise argparse.ArgumentTypeError(f"there is no {path}: name a file or folder that exists")
    return path


def made_by(command: str) -> Callable[[str], Path]:
    """The argument type for a path that another training command writes.

    command: that command's module below `makeup_video.training`. Give defaults as strings, because
    argparse checks strings alone.
    """

    def made(text: str) -> Path:
        path = Path(text)
        if not path.exists():
            raise argparse.ArgumentTypeError(
                f"there is no {path}: run python -m makeup_video.training.{command} first, or "
                "name a file that it has made"
            )
        return path

    return made
