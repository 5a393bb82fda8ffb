"""Log lines on stderr, results on stdout."""

import io
import os
import re
import sys

_said_stopped = False
_own_stderr: int | None = None
# Characters that move the cursor, colour the terminal, begin a line or turn the reading direction;
# characters without width; and lone surrogates, which stand for bytes of file names that are not
# UTF-8. The joiners (U+200C, U+200D) are not listed, since words and emoji contain them.
# web/upload.py has the same list. This module cannot import that one, since it must load first,
# even when memory is short.
_RAW = re.compile(
    "[\x00-\x1f\x7f-\x9f\u061c\u200b\u200e\u200f\u2028-\u202e\u2060\u2066-\u2069\ufeff\ud800-\udfff]"
)


def printable(text: str) -> str:
    """A text as one line that is safe to print: other characters become escapes such as \\x1b."""
    return _RAW.sub(lambda found: found[0].encode("unicode_escape").decode(), text)


def silence_libraries() -> None:
    """Send what C libraries print on stderr to the null device; Python's stderr still works.

    libpng, libjpeg, LLVM and others repeat what our error line says, or print what does not concern
    the user. They write to file descriptor 2, so Python's stderr moves to a copy of the descriptor.
    This holds for every thread until the process ends.
    """
    global _own_stderr
    # stderr is closed: otherwise the output file could get descriptor 2 and the libraries' lines
    if sys.stderr is None:
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
        # otherwise Python would fail again at exit, when it flushes stderr
        sys.stderr = open(os.devnull, "w", encoding="utf-8")  # noqa: SIM115


class ResultText(io.StringIO):
    """Text for `print_result` that rich draws, with colours and boxes if stdout can show them."""

    @property
    def encoding(self) -> str:  # type: ignore[override]
        return getattr(sys.stdout, "encoding", None) or "utf-8"

    def isatty(self) -> bool:
        return sys.stdout is not None and sys.stdout.isatty()


def print_result(text: str) -> None:
    """Print on stdout; characters that its encoding lacks are escaped.

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
        # otherwise the text that is still buffered would fail again when Python exits
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        if not isinstance(error, BrokenPipeError):
            from makeup_video.pipeline.errors import OutputError
            from makeup_video.pipeline.files.disk_errors import unwritable

            raise OutputError(unwritable("stdout", error, "send it to a file")) from error
