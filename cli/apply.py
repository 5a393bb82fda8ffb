"""`makeup-video IN --look LOOK -o OUT`: the main job."""

import re
from contextlib import AbstractContextManager, nullcontext
from fractions import Fraction
from typing import TYPE_CHECKING, Annotated

import typer
from makeup_video.cli.ending import tell, told_in_one_line

if TYPE_CHECKING:
    from makeup_video.pipeline import Look, Settings
    from makeup_video.pipeline.side_file import ReportFile


def apply(
    source: Annotated[str, typer.Argument(metavar="IN", help="A video or a picture.")],
    output: Annotated[
        str, typer.Option("-o", "--output", metavar="OUT", help="Where to write the result.")
    ],
    look: Annotated[
        str | None, typer.Option(help="A look file (JSON), or 'none' to paint nothing.")
    ] = None,
    ref: Annotated[str | None, typer.Option(help="A photo of the makeup to paint.")] = None,
    codec: Annotated[
        str | None,
        typer.Option(help="h264, hevc, av1, vp9, ffv1 or prores; default: what suits IN and OUT."),
    ] = None,
    crf: Annotated[
        int | None, typer.Option(help="Quality: lower is better and larger; default by codec.")
    ] = None,
    preset: Annotated[
        str | None, typer.Option(help="The encoder's speed preset; default by codec.")
    ] = None,
    start: Annotated[
        str | None, typer.Option(help="Begin here: seconds, or [hh:]mm:ss[.fraction].")
    ] = None,
    end: Annotated[
        str | None, typer.Option(help="End here, counted from the same beginning.")
    ] = None,
    overwrite: Annotated[
        bool, typer.Option("-y", "--yes", help="Overwrite what exists: OUT, the report.")
    ] = False,
    strict: Annotated[
        bool, typer.Option("--strict", help="Fail rather than drop or convert a track.")
    ] = False,
    report: Annotated[
        str | None, typer.Option(metavar="FILE", help="Write counts and times as JSON.")
    ] = None,
    quiet: Annotated[bool, typer.Option("-q", "--quiet", help="Print errors only.")] = False,
    debug: Annotated[bool, typer.Option("--debug", help="Show tracebacks.")] = False,
) -> None:
    """Paint a look on every frame of IN and write OUT (the command to run without a name)."""
    # the pipeline takes a third of a second to import: not for --help
    from makeup_video.cli.progress import show_progress
    from makeup_video.pipeline import process_video

    with told_in_one_line(output, debug):
        settings = _settings(codec, crf, preset, start, end, overwrite, strict)
        painted = _look(look, ref)
        with _report_file(report, source, output, look, overwrite) as file:
            with show_progress(quiet) as on_progress:
                done = process_video(source, output, painted, settings, on_progress)
            if file is not None:
                file.write(done.to_dict())
    tell(done, quiet)


def _settings(
    codec: str | None,
    crf: int | None,
    preset: str | None,
    start: str | None,
    end: str | None,
    overwrite: bool,
    strict: bool,
) -> "Settings":
    from makeup_video.pipeline import Settings

    return Settings(
        codec=codec,
        crf=crf,
        preset=preset,
        start_seconds=None if start is None else parse_time(start, "--start"),
        end_seconds=None if end is None else parse_time(end, "--end"),
        overwrite=overwrite,
        strict=strict,
    )


def parse_time(text: str, option: str) -> Fraction:
    """Seconds, exact, from '12.5', '1:02.5' or '0:01:02.5'. Raises UsageError."""
    from makeup_video.pipeline import UsageError

    if not re.fullmatch(r"(\d{1,9}:){0,2}\d{1,9}(\.\d{1,9})?", text, re.ASCII):
        raise UsageError(f"{option} must be seconds or [hh:]mm:ss[.fraction], got {text!r}")
    values = [Fraction(part) for part in text.split(":")]
    if any(value >= 60 for value in values[1:]):
        raise UsageError(f"{option} has a part of 60 or more after a colon: {text!r}")
    return sum((v * 60**i for i, v in enumerate(reversed(values))), Fraction(0))


def _look(look: str | None, ref: str | None) -> "Look":
    from makeup_video.pipeline import Look, UsageError

    if ref is not None:
        raise UsageError(
            "--ref: this version cannot read a look from a photo yet; give --look FILE or none"
        )
    if look is None:
        raise UsageError("no look given: add --look FILE.json, or --look none to paint nothing")
    return Look() if look == "none" else Look.load(look)


def _report_file(
    path: str | None, source: str, output: str, look: str | None, overwrite: bool
) -> "AbstractContextManager[ReportFile | None]":
    from makeup_video.pipeline.side_file import ReportFile

    if path is None:
        return nullcontext()
    others = [] if look is None or look == "none" else [look]
    return ReportFile(path, source, output, *others, overwrite=overwrite)
