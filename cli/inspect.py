"""`makeup-video inspect IN -o OVERLAY`: what the face nets find."""

from typing import Annotated

import typer
from makeup_video.cli.options import (
    OUTPUT,
    Debug,
    End,
    Overwrite,
    Quiet,
    Source,
    Start,
    parse_time,
)
from makeup_video.cli.outcome import print_summary, report_errors

EXAMPLES = (
    "makeup-video inspect photo.jpg -o faces.png",
    "makeup-video inspect in.mp4 -o faces.mp4 --json faces.json",
)


def inspect(
    source: Source,
    output: Annotated[
        str,
        typer.Option(
            "-o",
            "--output",
            metavar="OVERLAY",
            help="Where to write the drawing.",
            rich_help_panel=OUTPUT,
        ),
    ],
    points: Annotated[
        str | None,
        typer.Option(
            "--json", metavar="FILE", help="Write all points as JSON.", rich_help_panel=OUTPUT
        ),
    ] = None,
    overwrite: Overwrite = False,
    start: Start = None,
    end: End = None,
    quiet: Quiet = False,
    debug: Debug = False,
) -> None:
    """Draw the points, lip mask, number and scores of every face on a picture or a video."""
    from makeup_video.cli.main import mark_output_whole
    from makeup_video.cli.progress import show_progress
    from makeup_video.pipeline import Settings, inspect_video

    with report_errors("inspect", [output], debug):
        settings = Settings(
            start_seconds=parse_time(start, "--start"),
            end_seconds=parse_time(end, "--end"),
            overwrite=overwrite,
            on_whole=mark_output_whole,
        )
        with show_progress(quiet) as on_progress:
            report = inspect_video(source, output, points, settings, on_progress)
    print_summary(report, quiet, f"; {_count_faces(report.faces, report.frames_with_face)}")


def _count_faces(faces: int | None, frames: int | None) -> str:
    return f"faces: {faces}, in {frames} frame{'' if frames == 1 else 's'}"
