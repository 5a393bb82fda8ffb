"""Lines for people, on stderr, and results, on stdout."""

import io
import os
import re
import sys

_lines = 0
_own_stderr: int | None = None
# What could move the cursor, colour the terminal, begin a line or turn the reading direction; and
# halves of characters, which stand for bytes of file names that are not UTF-8.
_RAW = re.compile("[\x00-\x1f\x7f-\x9f\u2028-\u202e\u2066-\u2069\ud800-\udfff]")


def printable(text: str) -> str:
    """One line that a terminal shows as it is: other characters become escapes such as \\x1b."""
    return _RAW.sub(lambda found: found[0].encode("unicode_escape").decode(), text)


def keep_stderr_to_ourselves() -> None:
    """From now on what C libraries print on stderr goes nowhere; what Python prints still arrives.

    libpng, libjpeg, LLVM and others print what our one line says, or what is no concern of the
    user's. They know file descriptor 2 alone, so Python's stderr moves to a copy of it: for every
    thread, at any time, and no line of ours is lost.
    """
    global _own_stderr
    if sys.stderr is None:  # closed: the output's file must not get number 2, and their lines
        _hush()
        return
    before = sys.__stderr__
    if before is None or sys.stderr is not before or _own_stderr is not None:
        return
    before.flush()
    _own_stderr = os.dup(2)
    sys.stderr = open(  # noqa: SIM115  # for as long as the process lasts
        _own_stderr, "w", buffering=1, encoding=before.encoding, errors=before.errors
    )
    _hush()


def _hush() -> None:
    nowhere = os.open(os.devnull, os.O_WRONLY)
    if nowhere != 2:
        os.dup2(nowhere, 2)
        os.close(nowhere)


def stderr_of_children() -> int | None:
    """What `subprocess` is to give to a process whose lines are ours too."""
    return _own_stderr


def has_said() -> bool:
    """True once a line was said, so that an ending is told once and not twice."""
    return _lines > 0


def say(text: str) -> None:
    """Print one line on stderr, made printable. When nobody listens any more, the work goes on all the same."""
    global _lines
    _lines += 1
    if sys.stderr is None:
        return
    try:
        print(printable(text), file=sys.stderr, flush=True)
    except (OSError, ValueError):
        # so that Python does not fail on it once more when it exits
        sys.stderr = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115


def put(text: str) -> None:
    """Print results on stdout, escaped where its encoding lacks a character.

    Who stops reading has read enough. Raises OutputError when stdout cannot be written.
    """
    if sys.stdout is None:
        return
    try:
        if isinstance(sys.stdout, io.TextIOWrapper):
            sys.stdout.reconfigure(errors="backslashreplace")
        sys.stdout.write(text)
        sys.stdout.flush()
    except OSError as error:
        # what is still buffered must not fail once more when Python exits
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        if not isinstance(error, BrokenPipeError):
            from makeup_video.pipeline.errors import OutputError

            raise OutputError(f"stdout cannot be written: {error.strerror}") from error
