"""How every command ends: what it says, and the documented exit code."""

import traceback
from collections.abc import Generator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

import typer
from makeup_video.cli.console import say

if TYPE_CHECKING:
    from makeup_video.pipeline import Face, Report


@contextmanager
def told_in_one_line(output: str | None = None, debug: bool = False) -> Generator[None, None, None]:
    """Whatever the pipeline raises becomes one line and its exit code."""
    from makeup_video.pipeline import MakeupVideoError, SeveralFacesError, StoppedError

    try:
        yield
    except StoppedError:
        part = None if output is None else _part_of(Path(output))
        kept = f"; {part} holds what was done" if part is not None and part.exists() else ""
        say(f"stopped{kept}")
        raise typer.Exit(StoppedError.exit_code) from None
    except MakeupVideoError as error:
        if debug:
            traceback.print_exc()
        if isinstance(error, SeveralFacesError):
            error.extend(after=_choice_of(error.faces))
        say(f"{type(error).__name__}: {error.spelled(option_of_command)}")
        raise typer.Exit(error.exit_code) from None


# Options whose names differ from those of Python by more than a hyphen.
_NAMES = {
    "start_seconds": "--start",
    "end_seconds": "--end",
    "overwrite": "-y",
    "face": "--ref-face",
}


def option_of_command(name: str, value: str | None) -> str:
    """An option as it is typed: `bit_depth`, "8" -> `--bit-depth 8`; a flag that is to be set has no value."""
    flag = _NAMES.get(name, "--" + name.replace("_", "-"))
    return flag if value in (None, "True") else f"{flag} {value}"


def _choice_of(faces: "Sequence[Face]") -> str:
    """The advice to choose one of several faces in a photo."""
    from makeup_video.pipeline.reference.checks import face_list

    return (
        f", or choose it with --ref-face NUMBER or --ref-face largest; there are {face_list(faces)}"
    )


def tell(done: "Report", quiet: bool, more: str = "") -> None:
    """What was lost or changed, and the closing line; exit code 5 when the input was damaged."""
    from makeup_video.pipeline.errors import EXIT_DAMAGED_INPUT

    for line in done.warnings():
        if not quiet or done.damaged:
            say(line)
    if not quiet:
        say(done.summary() + more)
    if done.damaged:
        raise typer.Exit(EXIT_DAMAGED_INPUT)


def _part_of(output: Path) -> Path:
    from makeup_video.pipeline.files.output_file import part_of, target_of

    return part_of(target_of(output))
