"""`makeup-video inspect IN -o OVERLAY`: what the face nets see."""

import traceback
from pathlib import Path
from typing import Annotated

import typer
from makeup_video.cli.apply import check_side_file, parse_time
from makeup_video.cli.say import say


def inspect(
    source: Annotated[str, typer.Argument(metavar="IN", help="A video or a picture.")],
    output: Annotated[
        str, typer.Option("-o", "--output", metavar="OVERLAY", help="Where to write the drawing.")
    ],
    points: Annotated[
        str | None, typer.Option("--json", metavar="FILE", help="Write all points as JSON.")
    ] = None,
    start: Annotated[str | None, typer.Option(help="Begin here, as in apply.")] = None,
    end: Annotated[str | None, typer.Option(help="End here.")] = None,
    overwrite: Annotated[bool, typer.Option("-y", "--yes", help="Overwrite OVERLAY.")] = False,
    quiet: Annotated[bool, typer.Option("-q", "--quiet", help="Print errors only.")] = False,
    debug: Annotated[bool, typer.Option("--debug", help="Show tracebacks.")] = False,
) -> None:
    """Draw the points, lip mask, number and scores of every face on a picture or a video."""
    from makeup_video.cli.progress import show_progress
    from makeup_video.pipeline import MakeupVideoError, Settings
    from makeup_video.pipeline.inspect import inspect_video

    try:
        settings = Settings(
            start_seconds=None if start is None else parse_time(start, "--start"),
            end_seconds=None if end is None else parse_time(end, "--end"),
            overwrite=overwrite,
        )
        if points is not None:
            check_side_file("--json", Path(points), source, output)
        with show_progress(quiet) as on_progress:
            done = inspect_video(source, output, points, settings, on_progress)
    except MakeupVideoError as error:
        if debug:
            traceback.print_exc()
        say(f"{type(error).__name__}: {error}")
        raise typer.Exit(error.exit_code) from None
    if not quiet:
        for line in done.warnings():
            say(line)
        say(f"{done.summary()}; {_faces(done.faces, done.frames_with_face)}")


def _faces(faces: int | None, frames: int | None) -> str:
    return f"faces: {faces}, in {frames} frame{'' if frames == 1 else 's'}"
