"""Several looks of one video: the progress, and the lines at the end."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import typer
from makeup_video.cli.console import log
from makeup_video.cli.outcome import error_text, some_of

if TYPE_CHECKING:
    from makeup_video.pipeline import Report
    from makeup_video.pipeline.offline.looks import LooksProgress
    from makeup_video.pipeline.offline.report import Outcome


def titled(on_progress: Any, source: str, names: Mapping[Path, str]) -> "LooksProgress | None":
    """A progress callback for process_looks, which gives `on_progress` the looks as a title.

    on_progress: the callback that shows progress; None gives None.  names: the name of the look of
    each output.
    """
    if on_progress is None:
        return None
    video = Path(source).name

    def tick(outputs: Sequence[Path], *figures: Any) -> None:
        on_progress(*figures, title=f"{video}: {some_of([names[one] for one in outputs])}")

    return tick


def print_outcomes(outcomes: "Sequence[tuple[str, Outcome]]", source: str, quiet: bool) -> None:
    """Log the size, the warnings or the error of every output; warnings of all outputs only once.

    Raises typer.Exit with exit code 5 when the input was damaged or some looks failed, or with the
    exit code of the first error when all looks failed.
    """
    from makeup_video.pipeline import MakeupVideoError
    from makeup_video.pipeline.errors import EXIT_IN_PART

    reports = [(name, one) for name, one in outcomes if not isinstance(one, MakeupVideoError)]
    errors = [(name, one) for name, one in outcomes if isinstance(one, MakeupVideoError)]
    _print_warnings([one for _, one in reports], quiet)
    for name, report in reports:
        if not quiet:
            log(f"{name}: {report.size_in_words}")
    for name, error in errors:
        log(f"{name}: {error_text(error)}")
    if reports and not quiet:
        # each look of a pass has the seconds of the whole pass, which count once
        seconds = sum({one.seconds for _, one in reports})
        log(f"{len(reports)} of {len(outcomes)} looks of {source} in {seconds:.1f} s")
    if not reports:
        raise typer.Exit(errors[0][1].exit_code)
    if errors or any(one.damaged for _, one in reports):
        raise typer.Exit(EXIT_IN_PART)


def _print_warnings(reports: "Sequence[Report]", quiet: bool) -> None:
    reports = [report for report in reports if report.damaged or not quiet]
    lines = [report.warnings() for report in reports]
    common = [line for line in lines[0] if all(line in one for one in lines)] if lines else []
    for line in common:
        log(line)
    for report, own in zip(reports, lines, strict=True):
        for line in own:
            if line not in common:
                log(f"{report.output}: {line}")
