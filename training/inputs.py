"""Types of arguments that name the inputs of a command."""

import argparse
from collections.abc import Callable
from pathlib import Path


def existing(text: str) -> Path:
    """The path of a file or folder that is there. Raises ArgumentTypeError."""
    path = Path(text)
    if not path.exists():
        raise argparse.ArgumentTypeError(f"there is no {path}: name a file or folder that exists")
    return path


def made_by(command: str) -> Callable[[str], Path]:
    """The type of a path that another command of training writes.

    command: its module below `makeup_video.training`. Defaults are texts, which argparse checks as
    well.
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
