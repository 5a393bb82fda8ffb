"""Checks that an argument of a public function is the path of a file."""

import os

GIVE_NAME = "give the name of a file"


def check_path(argument: str, path: object, how: str = GIVE_NAME) -> str:
    """The path as text.

    argument: the argument's name in the message.  how: what to give instead of a wrong type; bytes
    have their own advice.
    Raises TypeError unless the path is a str, or a Path or the like that holds text.
    """
    text = os.fspath(path) if isinstance(path, str | bytes | os.PathLike) else None
    if isinstance(text, str):
        return text
    if text is not None:
        how = "os.fsdecode decodes it"
    raise TypeError(f"{argument} must be a str or a Path, got {type(path).__name__}: {how}")
