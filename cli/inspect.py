"""`makeup-video inspect IN -o OVERLAY`: what the face nets see."""

from typing import Annotated

import typer
from makeup_video.cli.look_options import parse_time
from makeup_video.cli.outcome import tell, told_in_one_line


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
    overwrite: Annotated[
        bool, typer.Option("-y", "--yes", help="Overwrite what exists: OVERLAY, FILE.")
    ] = False,
    quiet: Annotated[bool, typer.Option("-q", "--quiet", help="Print errors only.")] = False,
    debug: Annotated[bool, typer.Option("--debug", help="Show tracebacks.")] = False,
) -> None:
    """Draw the points, lip mask, number and scores of every face on a picture or a video."""
    from makeup_video.cli.main import nothing_is_left_to_stop
    from makeup_video.cli.progress import show_progress
    from makeup_video.pipeline import Settings, inspect_video

    with told_in_one_line(output, debug):
        settings = Settings(
            start_seconds=None if start is None else parse_time(start, "--start"),
            end_seconds=None if end is None else parse_time(end, "--end"),
            overwrite=overwrite,
            on_whole=nothing_is_left_to_stop,
        )
        with show_progress(quiet) as on_progress:
            done = inspect_video(source, output, points, settings, on_progress)
    tell(done, quiet, f"; {_faces(done.faces, done.frames_with_face)}")


def _faces(faces: int | None, frames: int | None) -> str:
    return f"faces: {faces}, in {frames} frame{'' if frames == 1 else 's'}"
