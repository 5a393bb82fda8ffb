"""Several looks of one video: names of outputs, progress, and what is said at the end."""

import contextlib
import errno
import os
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any, Self

import typer
from makeup_video.cli.console import log
from makeup_video.cli.looks_options import WantedLook
from makeup_video.cli.outcome import error_text, join_words

if TYPE_CHECKING:
    from makeup_video.pipeline import Report
    from makeup_video.pipeline.files.template import Template
    from makeup_video.pipeline.offline.looks import LooksProgress
    from makeup_video.pipeline.offline.report import Outcome

_MOST_NAMES = 3  # of looks in a line


def name_outputs(output: str, source: str, looks: Sequence[WantedLook]) -> list[str]:
    """The name of the output of each look.

    A name without braces is taken as it is. Raises UsageError for a template that does not fit, and
    for outputs of one name.
    """
    from makeup_video.pipeline.files.output_file import check_apart
    from makeup_video.pipeline.files.template import Origin

    if len(looks) == 1 and not {"{", "}"} & set(output):
        return [output]
    template = template_for(output, len(looks))
    fields = fields_of(Path(source))
    origins = [Origin(fields | look.fields, source, look.called) for look in looks]
    outputs = [template.fill(origin) for origin in origins]
    check_apart(outputs, origins)
    return list(map(os.fspath, outputs))


def template_for(output: str, looks: int) -> "Template":
    """The template of outputs. Raises UsageError for one that gives several looks one name."""
    from makeup_video.pipeline import UsageError
    from makeup_video.pipeline.files.template import OF_LOOKS, Template

    template = Template(output)
    if looks > 1 and not set(OF_LOOKS) & set(template.fields):
        raise UsageError(
            f"{looks} looks need a name each: put {{look}} in -o, as in "
            f"-o {_with_look(output)!r}, got {output}"
        )
    return template


def fields_of(path: Path) -> dict[str, str]:
    """What a template of outputs may hold of an input."""
    folder = path.absolute().parent.name
    return {"name": path.stem, "folder": folder, "ext": _written_as(path)}


def _written_as(path: Path) -> str:
    """The extension of the output for an input: HEIC is read, and never written."""
    end = path.suffix.lower().removeprefix(".")
    return "jpg" if end in ("heic", "heif") else end


def _with_look(output: str) -> str:
    path = Path(output)
    if output.endswith(("/", os.sep)) or os.path.isdir(path):
        return os.fspath(path / "{name}-{look}.mp4")
    return os.fspath(path.with_name(f"{path.stem}-{{look}}{path.suffix}")) if path.name else output


class NewFolders:
    """Makes folders of outputs whose names come from a template.

    Those that are empty when the block ends with an error are removed again.
    """

    def __init__(self) -> None:
        self._made: list[Path] = []

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: object, *exc: object) -> None:
        if kind is not None:
            for folder in reversed(self._made):
                with contextlib.suppress(OSError):
                    folder.rmdir()

    def make(self, outputs: Sequence[str]) -> None:
        """Make the folders of outputs. Raises OutputError."""
        from makeup_video.pipeline.files.output_file import write_errors

        for folder in dict.fromkeys(Path(output).parent for output in outputs):
            with write_errors(folder):
                missing = [one for one in (folder, *folder.parents) if not os.path.exists(one)]
                try:
                    folder.mkdir(parents=True, exist_ok=True)
                except OSError as error:
                    if error.errno != errno.ENAMETOOLONG:  # such an output fails alone
                        raise
                self._made += [one for one in reversed(missing) if os.path.exists(one)]


def titled(on_progress: Any, source: str, names: Mapping[Path, str]) -> "LooksProgress | None":
    """The callback of process_looks, for one that shows a title beside the frames.

    names: of the looks, by output.
    """
    if on_progress is None:
        return None
    film = Path(source).name

    def tick(outputs: Sequence[Path], *figures: Any) -> None:
        on_progress(*figures, title=f"{film}: {some_of([names[one] for one in outputs])}")

    return tick


def some_of(names: Sequence[str]) -> str:
    """At most three names in words: "nude, plum and 38 more"."""
    if len(names) <= _MOST_NAMES:
        return join_words(names)
    return f"{', '.join(names[: _MOST_NAMES - 1])} and {len(names) - _MOST_NAMES + 1} more"


def print_outcomes(outcomes: "Sequence[tuple[str, Outcome]]", source: str, quiet: bool) -> None:
    """Log every output and what is to be known of it; the warnings of all outputs only once.

    Raises typer.Exit: with exit code 5 when the input was damaged or some looks failed, with that
    of the first error when all did.
    """
    from makeup_video.pipeline import MakeupVideoError
    from makeup_video.pipeline.errors import EXIT_DAMAGED_INPUT

    reports = [(name, one) for name, one in outcomes if not isinstance(one, MakeupVideoError)]
    errors = [(name, one) for name, one in outcomes if isinstance(one, MakeupVideoError)]
    _print_warnings([one for _, one in reports], quiet)
    for name, report in reports:
        if not quiet:
            log(f"{name}: {report.size_in_words}")
    for name, error in errors:
        log(f"{name}: {error_text(error)}")
    if reports and not quiet:
        seconds = sum({one.seconds for _, one in reports})
        log(f"{len(reports)} of {len(outcomes)} looks of {source} in {seconds:.1f} s")
    if not reports:
        raise typer.Exit(errors[0][1].exit_code)
    if errors or any(one.damaged for _, one in reports):
        raise typer.Exit(EXIT_DAMAGED_INPUT)


def _print_warnings(reports: "Sequence[Report]", quiet: bool) -> None:
    lines = [report.warnings() for report in reports]
    if quiet and not any(report.damaged for report in reports):
        return
    common = [line for line in lines[0] if all(line in one for one in lines)] if lines else []
    for line in common:
        log(line)
    for report, own in zip(reports, lines, strict=True):
        for line in own:
            if line not in common:
                log(f"{report.output}: {line}")
