"""Log lines on stderr, results on stdout."""

import io
import os
import re
import sys

_said_stopped = False
_own_stderr: int | None = None
# Characters that move the cursor, colour the terminal, begin a line or turn the reading direction;
# what has no width; and lone surrogates, which stand for bytes of file names that are not UTF-8.
# The joiners (U+200C, U+200D) are parts of words and emoji. web/upload.py has the same list: this
# module cannot share it, since it must load first, even when memory is short.
_RAW = re.compile(
    "[\x00-\x1f\x7f-\x9f\u061c\u200b\u200e\u200f\u2028-\u202e\u2060\u2066-\u2069\ufeff\ud800-\udfff]"
)


def printable(text: str) -> str:
    """One line that a terminal shows as it is: other characters become escapes such as \\x1b."""
    return _RAW.sub(lambda found: found[0].encode("unicode_escape").decode(), text)


def silence_libraries() -> None:
    """Send what C libraries print on stderr to the null device; Python's stderr still works.

    libpng, libjpeg, LLVM and others repeat what our error line says, or print what does not concern
    the user. They know only file descriptor 2, so Python's stderr moves to a copy of it. This holds
    for every thread until the process ends.
    """
    global _own_stderr
    if sys.stderr is None:  # closed: the output file must not get descriptor 2, and their lines
        _redirect_stderr_to_null()
        return
    before = sys.__stderr__
    if before is None or sys.stderr is not before or _own_stderr is not None:
        return
    before.flush()
    _own_stderr = os.dup(2)
    sys.stderr = open(  # noqa: SIM115  # stays open as long as the process lasts
        _own_stderr, "w", buffering=1, encoding=before.encoding, errors=before.errors
    )
    _redirect_stderr_to_null()


def _redirect_stderr_to_null() -> None:
    null = os.open(os.devnull, os.O_WRONLY)
    if null != 2:
        os.dup2(null, 2)
        os.close(null)


def child_stderr() -> int | None:
    """The file descriptor for the stderr of child processes; None: they inherit descriptor 2."""
    return _own_stderr


def log_stopped(text: str = "stopped") -> None:
    """Log that Ctrl-C ended the run, and note that this was said."""
    global _said_stopped
    _said_stopped = True
    log(text)


def ensure_stopped_is_logged() -> None:
    """Log that Ctrl-C ended the run, unless a line has said so already."""
    if not _said_stopped:
        log_stopped()


def log(text: str) -> None:
    """Print one line on stderr, made printable. A closed stderr is no error: the work goes on."""
    if sys.stderr is None:
        return
    try:
        print(printable(text), file=sys.stderr, flush=True)
    except (OSError, ValueError):
        # otherwise Python would fail on it once more at exit
        sys.stderr = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115


class ResultText(io.StringIO):
    """Text for `print_result` that rich draws: colours and boxes only where stdout has them."""

    @property
    def encoding(self) -> str:  # type: ignore[override]
        return getattr(sys.stdout, "encoding", None) or "utf-8"

    def isatty(self) -> bool:
        return sys.stdout is not None and sys.stdout.isatty()


def print_result(text: str) -> None:
    """Print on stdout, escaped where its encoding lacks a character.

    A reader that closes the pipe early is no error. Raises OutputError when stdout cannot be
    written.
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
            from makeup_video.pipeline.files.disk_errors import unwritable

            raise OutputError(unwritable("stdout", error, "send it to a file")) from error
