"""`makeup-video`: starts fast, says one line, ends with a documented exit code."""

# Next to nothing is imported before `main` listens to Ctrl-C.
import os
import signal
import sys

from makeup_video.cli.console import has_said, keep_stderr_to_ourselves, say

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any, NoReturn

_LAST_SECONDS = 1.0
_STOPPED = 130
_NO_MEMORY = (
    "std::bad_alloc",
    "failed to map segment",
    "can't start new thread",
    "cannot allocate memory",
    "failed to allocate",
    "insufficient memory",
    "out_of_host_memory",
    "mem_object_allocation_failure",
)
_came: list[int] = []  # signals to stop
_whole: list[int] = []  # outputs that are whole


def main() -> None:
    """Run the command line; whatever goes wrong is one line and never a traceback."""
    _whole.clear()
    try:
        if "--debug" not in sys.argv:
            keep_stderr_to_ourselves()
        # a supervisor's SIGTERM and a closed terminal stop a run as Ctrl-C does: cleanly, with a
        # playable part file
        _on_stop(_interrupt)
        # Typer takes a tenth of a second: Ctrl-C in that time is handled here too
        from makeup_video.cli.app import app

        code = app(standalone_mode=False) or 0
        if code == _STOPPED and not has_said():
            raise KeyboardInterrupt  # Typer turned it into a bare exit code
    except KeyboardInterrupt:
        say("stopped")
        code = _STOPPED
    except Exception as error:  # noqa: BLE001  # the last resort: no user sees a traceback
        if _came:  # a C module that was being loaded made another error of Ctrl-C
            code = _STOPPED
            if not has_said():
                say("stopped")
        else:
            code = _explain(error)
    _end(code)


def nothing_is_left_to_stop() -> None:
    """The output is whole and gets its name now: a later Ctrl-C comes too late.

    The run then ends with the exit code and the files that it would have without Ctrl-C. Any thread
    may call this.
    """
    _whole.append(1)


def _interrupt(*_: object) -> None:
    if _whole:
        return
    _came.append(1)
    raise KeyboardInterrupt


def _on_stop(handler: "Any") -> None:
    from makeup_video.pipeline.engine.signals import stop_signals

    for number in stop_signals():
        signal.signal(number, handler)


def _end(code: int) -> "NoReturn":
    """All is said and done. One more Ctrl-C must not spoil the exit code, and a photo that takes its time
    to be read, for a page that is gone, must not keep the process."""
    import contextlib
    import threading
    import time

    _on_stop(signal.SIG_IGN)
    until = time.monotonic() + _LAST_SECONDS
    for thread in threading.enumerate():
        if thread is not threading.current_thread():
            thread.join(max(0.0, until - time.monotonic()))
    # Python would wait for a thread, or pull its memory from under it. And when Ctrl-C came within `exec`,
    # as while dataclasses are made, it would end by the signal whatever the code is.
    if code == _STOPPED or threading.active_count() > 1:
        # what Python's own exit would have removed
        if cache := sys.modules.get("makeup_video.kernels.cache"):
            cache.give_back()
        if parts := sys.modules.get("makeup_video.pipeline.files.part_file"):
            parts.remove_empty()
        with contextlib.suppress(OSError, ValueError, AttributeError):  # nobody listens any more
            sys.stdout.flush()
        os._exit(code)
    raise SystemExit(code)


def _explain(error: Exception) -> int:
    """Say what went wrong in one line; the exit code for it."""
    if type(error).__name__ == "NoArgsIsHelpError":
        error.show()  # type: ignore[attr-defined]  # the help text, for a bare `makeup-video`
        return 2
    if hasattr(error, "format_message"):  # Typer's own errors, about options
        say(f"UsageError: {' '.join(error.format_message().split())} See makeup-video --help.")
        return 2
    if "--debug" in sys.argv:
        import traceback

        traceback.print_exc()
    if type(error).__name__ == "TooLittleMemoryError":
        say(f"TooLittleMemoryError: {error}")
        return 1
    if _is_want_of_memory(error):
        say(
            "TooLittleMemoryError: there is not enough memory for this: close other programs, or "
            "raise the limit (ulimit -v, the container's)"
        )
        return 1
    say(
        f"makeup-video: internal error: {type(error).__name__}: {error}. "
        "Run again with --debug and report it."
    )
    return 1


def _is_want_of_memory(error: Exception) -> bool:
    """Libraries say it in their own words, the loader of C modules, threads and C++ among them."""
    text = str(error).lower()
    return isinstance(error, MemoryError) or any(words in text for words in _NO_MEMORY)
