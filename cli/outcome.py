"""How every command ends: the lines on stderr and the documented exit code."""

import traceback
from collections.abc import Generator, Iterable, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import typer
from makeup_video.cli.console import log, log_stopped
from makeup_video.cli.options import DEFAULT, PROGRAM

if TYPE_CHECKING:
    from makeup_video.pipeline import MakeupVideoError, Report, SeveralFacesError

# Options whose names differ from those of Python by more than a hyphen.
_NAMES = {
    "start_seconds": "--start",
    "end_seconds": "--end",
    "overwrite": "-y",
    "face": "--ref-face",
    "rate": "--fps",
    "url": "--stream",
    "minutes": "--length",
    "split_minutes": "--split",
}
_MOST_NAMES = 3  # in one line
# What to do with a photo of several people in commands without --ref-face.
_WITHOUT_CHOICE = {
    "demo": ", or leave --ref out, and drop the photo on the page, where a face is clicked",
    "bench": f", or save the look of one face by {PROGRAM} estimate PHOTO --ref-face NUMBER -o "
    "look.json, and give --look look.json",
}


@contextmanager
def report_errors(
    command: str, outputs: Sequence[str] = (), debug: bool = False, loads_more: bool = False
) -> Generator[None, None, None]:
    """Turn every error of the pipeline into one line and its exit code.

    command: a usage error points to the help page of this command.  outputs: after Ctrl-C the line
    names those part files of these outputs that exist.  debug: print the traceback, too.
    loads_more: the block first loads many modules, and calls `seek_garbage` itself after that.
    """
    from makeup_video.pipeline import MakeupVideoError, SeveralFacesError, StoppedError
    from makeup_video.pipeline.engine.machine import seek_garbage

    if not loads_more:
        seek_garbage()
    try:
        yield
    except StoppedError:
        parts = [part for output in outputs if (part := _part_of(Path(output))).exists()]
        hold = "holds" if len(parts) == 1 else "hold"
        there = f"; {join_words(map(str, parts))} {hold} what was done" if parts else ""
        log_stopped(f"stopped{there}")
        raise typer.Exit(StoppedError.exit_code) from None
    except MakeupVideoError as error:
        if debug:
            traceback.print_exc()
        if isinstance(error, SeveralFacesError):
            error.extend(after=_choice_of(error, command))
        log(error_line(error, command))
        raise typer.Exit(error.exit_code) from None


def error_line(error: "MakeupVideoError", command: str) -> str:
    """The line for an error of the pipeline; a usage error points to the command's help page."""
    from makeup_video.pipeline import UsageError

    text = error_text(error)
    return with_help_pages(text, [command]) if isinstance(error, UsageError) else text


def error_text(error: "MakeupVideoError") -> str:
    """An error of the pipeline in one line, with options as the user types them."""
    return f"{type(error).__name__}: {error.spelled(option_of_command)}"


def with_help_pages(text: str, commands: Sequence[str]) -> str:
    """A message, followed by the command lines that print the help of these commands."""
    sentence = text if text.endswith((".", "?", "!")) else f"{text}."
    return f"{sentence} See {join_words([f'{as_typed(name)} --help' for name in commands])}."


def as_typed(command: str) -> str:
    """A command as the user types it: the default command needs no name."""
    return PROGRAM if command == DEFAULT else f"{PROGRAM} {command}"


def join_words(words: Iterable[str], before_last: str = "and") -> str:
    """Join words for a sentence: "a", "a and b", "a, b and c"."""
    *first, last = words
    return f"{', '.join(first)} {before_last} {last}" if first else last


def some_of(names: Sequence[str]) -> str:
    """At most three names in words: "nude, plum and 38 more"."""
    if len(names) <= _MOST_NAMES:
        return join_words(names)
    return f"{', '.join(names[: _MOST_NAMES - 1])} and {len(names) - _MOST_NAMES + 1} more"


def option_of_command(name: str, value: str | None) -> str:
    """An option as the user types it: `bit_depth`, "8" -> `--bit-depth 8`. A flag has no value."""
    flag = _NAMES.get(name, "--" + name.replace("_", "-"))
    return flag if value in (None, "True") else f"{flag} {value}"


def _choice_of(error: "SeveralFacesError", command: str) -> str:
    """The advice to choose one of several faces in a photo, and how to see their numbers."""
    import shlex

    from makeup_video.pipeline.reference.checks import face_list

    if advice := _WITHOUT_CHOICE.get(command):
        return advice
    advice = (
        ", or choose it with --ref-face NUMBER or --ref-face largest; there are "
        f"{face_list(error.faces)}"
    )
    if error.photo is not None and _can_inspect(Path(error.photo)):
        advice += f"; to see them: {PROGRAM} inspect {shlex.quote(error.photo)} -o seen.png"
    return advice


def _can_inspect(photo: Path) -> bool:
    """False for the kinds of photos that only `--ref` reads, such as AVIF."""
    from makeup_video.pipeline.errors import InputError
    from makeup_video.pipeline.images.picture_file import is_picture

    try:
        return is_picture(photo)
    except InputError:
        return False


def settle_kernels(quiet: bool) -> None:
    """Settle where compiled kernels are kept; log if they will be lost after this run."""
    from makeup_video.pipeline.render.opencl import lost_kernels

    line = lost_kernels()
    if line is not None and not quiet:
        log(line)


def print_summary(report: "Report", quiet: bool, more: str = "") -> None:
    """Log what was lost or changed, and then the summary.

    Raises typer.Exit with exit code 5 when the input was damaged; its warnings are logged even when
    quiet.
    """
    from makeup_video.pipeline.errors import EXIT_IN_PART

    for line in report.warnings():
        if not quiet or report.damaged:
            log(line)
    if not quiet:
        log(report.summary() + more)
    if report.damaged:
        raise typer.Exit(EXIT_IN_PART)


def _part_of(output: Path) -> Path:
    from makeup_video.pipeline.files.output_file import part_of

    return part_of(output)
