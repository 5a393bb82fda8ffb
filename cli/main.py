"""`makeup-video`: starts fast, reports errors in one line, ends with a documented exit code."""

# Next to nothing is imported before `main` handles Ctrl-C.
import gc
import os
import signal
import sys

from makeup_video.cli.console import ensure_stopped_is_logged, log, silence_libraries

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any, NoReturn

_THREADS_END_SECONDS = 1.0
_STOPPED = 130
_UNWRITTEN = 4
_COMPLETE = "_MAKEUP_VIDEO_COMPLETE"  # set by a shell that completes a line
_came: list[int] = []  # an entry for each signal to stop
_whole: list[int] = []  # an entry for each output that is whole


def main() -> None:
    """Run the command line; every error is one line, and only --debug shows a traceback."""
    _whole.clear()
    try:
        if "--debug" not in sys.argv:
            silence_libraries()
        # a supervisor's SIGTERM and a closed terminal stop a run as Ctrl-C does: cleanly, with a
        # playable part file
        _handle_stop_signals(_interrupt)
        gc.disable()  # while modules are loaded: see `seek_garbage`
        # otherwise numpy starts threads that spin while they wait; our small matrices need none
        os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
        # `_report_error` needs this module, and there may be no memory to load it later
        import makeup_video.pipeline.engine.out_of_memory  # noqa: F401

        # importing Typer takes a tenth of a second: Ctrl-C in that time is handled here, too
        from makeup_video.cli.app import app

        if _came:  # a callback of Python's import system has swallowed the exception
            raise KeyboardInterrupt
        code = app(prog_name="makeup-video", standalone_mode=False) or 0
        if code == _STOPPED:
            ensure_stopped_is_logged()  # where Typer turned Ctrl-C into a bare exit code
    except KeyboardInterrupt:
        ensure_stopped_is_logged()
        code = _STOPPED
    except Exception as error:  # noqa: BLE001  # the last resort: no user sees a traceback
        if _came:  # a C module that was being loaded turned Ctrl-C into another error
            ensure_stopped_is_logged()
            code = _STOPPED
        else:
            code = _report_error(error)
    _exit(code)


def mark_output_whole() -> None:
    """Note that the output is whole and gets its name now: a later Ctrl-C comes too late.

    The run then ends with the exit code and the files that it would have without Ctrl-C. Any thread
    may call this.
    """
    _whole.append(1)


def _interrupt(*_: object) -> None:
    if _whole:
        return
    _came.append(1)
    raise KeyboardInterrupt


def _handle_stop_signals(handler: "Any") -> None:
    """Set the handler of each signal that ends a run, except those ignored at start (nohup)."""
    from makeup_video.pipeline.engine.signals import stop_signals

    for number in stop_signals():
        signal.signal(number, handler)


def _exit(code: int) -> "NoReturn":
    """End the process with this exit code, whatever its threads still do.

    One more Ctrl-C must not change the exit code, and a thread that still reads a photo for a
    closed page must not keep the process alive.
    """
    import contextlib
    import threading
    import time

    _handle_stop_signals(signal.SIG_IGN)
    deadline = time.monotonic() + _THREADS_END_SECONDS
    for thread in threading.enumerate():
        if thread is not threading.current_thread():
            thread.join(max(0.0, deadline - time.monotonic()))
    # Python's own exit is avoided. It would wait for a thread, or free memory that the thread uses,
    # and it takes 0.12 s to free all objects. After a Ctrl-C within `exec`, as while a dataclass is
    # made, it would even end by the signal, whatever the exit code is. So the files that Python's
    # exit would remove are removed here.
    if cache := sys.modules.get("makeup_video.kernels.cache"):
        cache.give_back()
    if parts := sys.modules.get("makeup_video.pipeline.files.part_file"):
        parts.remove_empty()
    for stream in (sys.stdout, sys.stderr):
        with contextlib.suppress(OSError, ValueError, AttributeError):  # the stream is closed
            stream.flush()
    os._exit(code)


def _report_error(error: Exception) -> int:
    """Log the error in one line, and return its exit code."""
    if type(error).__name__ == "NoArgsIsHelpError":
        error.show()  # type: ignore[attr-defined]  # the help text, for a bare `makeup-video`
        return 2
    if hasattr(error, "format_message"):  # Typer's own errors, about options
        from makeup_video.cli.usage import usage_line

        log(f"UsageError: {usage_line(error)}")
        return 2
    if "--debug" in sys.argv:
        import traceback

        traceback.print_exc()
    # compared by name, since memory may be too short for an import; a help page raises OutputError
    if (name := type(error).__name__) in ("TooLittleMemoryError", "OutputError"):
        log(f"{name}: {error}")
        return int(error.exit_code)  # type: ignore[attr-defined]
    if line := _completion_line(error):
        log(f"OutputError: {line}")
        return _UNWRITTEN
    from makeup_video.pipeline.engine.out_of_memory import is_out_of_memory

    if is_out_of_memory(error):
        log(
            "TooLittleMemoryError: there is not enough memory for this: close other programs, or "
            "raise the limit (ulimit -v, the container's)"
        )
        return 1
    log(
        f"makeup-video: internal error: {type(error).__name__}: {error}. "
        "Run again with --debug and report it."
    )
    return 1


def _completion_line(error: Exception) -> str:
    """The message when Typer cannot write a shell's completion; "" for any other error."""
    is_install = "--install-completion" in sys.argv
    if not (is_install or "--show-completion" in sys.argv or _COMPLETE in os.environ):
        return ""
    advice = "; --show-completion prints the lines instead"
    if isinstance(error, OSError) and error.filename is None:
        what = "stdout or the shell's startup file" if is_install else "stdout"
        return f"{what} cannot be written: {error.strerror}"
    if isinstance(error, OSError):
        return f"{error.filename} cannot be written: {error.strerror}{advice}"
    if is_install:  # there is no home folder, or a .bashrc is not UTF-8
        return f"the completion cannot be installed: {error}{advice}"
    return ""
