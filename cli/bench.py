"""`makeup-video bench`: what the product costs beside the bare codec, in one run."""

import json
import tempfile
from pathlib import Path
from typing import Annotated

import typer
from makeup_video.benchmark.suite import measure, more, sample_clip, sample_look
from makeup_video.cli.console import put, stderr_of_children
from makeup_video.cli.outcome import told_in_one_line


def bench(
    clip: Annotated[
        str | None, typer.Argument(metavar="CLIP", help="A video; default: our sample.")
    ] = None,
    sizes: Annotated[str, typer.Option(help="Heights to scale it to.")] = "720p,1080p",
    seconds: Annotated[
        float, typer.Option(help="Length of the film; it is played to and fro until then.")
    ] = 20.0,
    rounds: Annotated[int, typer.Option(help="How often each is run; medians count.")] = 5,
    look: Annotated[
        str | None, typer.Option(metavar="FILE", help="The look that is painted (JSON).")
    ] = None,
    ref: Annotated[
        str | None, typer.Option(metavar="PHOTO", help="Or a photo of it; default: our sample.")
    ] = None,
    as_is: Annotated[
        bool,
        typer.Option("--as-is", help="Only scale CLIP, don't bring its face to half the height."),
    ] = False,
    faces: Annotated[bool, typer.Option("--faces", help="Also 1, 2, 4 and 8 faces.")] = False,
    threads: Annotated[bool, typer.Option("--threads", help="Also other threads.")] = False,
    length: Annotated[
        float, typer.Option("--length", metavar="MINUTES", help="Also a film so long.")
    ] = 0.0,
    live: Annotated[
        bool, typer.Option("--live", help="Only the live run: how late its pictures reach a page.")
    ] = False,
    renderer: Annotated[
        bool, typer.Option(help="Measure what painting costs by itself, and the floor.")
    ] = True,
    as_json: Annotated[bool, typer.Option("--json", help="Print JSON.")] = False,
    plot: Annotated[
        str | None, typer.Option(metavar="PNG", help="Draw it: needs makeup-video[plot].")
    ] = None,
) -> None:
    """Measure the product beside a bare decode-and-encode loop: speed, CPU, memory, start."""
    from makeup_video.cli.progress import show_steps
    from makeup_video.pipeline import UsageError

    with told_in_one_line():
        heights = heights_of(sizes)
        _check(seconds, rounds, length)
        if live and (faces or threads or plot is not None):
            raise UsageError("--live is measured alone: leave out --faces, --threads and --plot")
        if plot is not None:
            from makeup_video.benchmark.plots import check_plot_path, draw

            check_plot_path(plot)
        with (
            tempfile.TemporaryDirectory(prefix="makeup-video-bench-") as name,
            show_steps() as told,
        ):
            from makeup_video.benchmark.harness import Bench

            source = sample_clip(clip)
            told("reading the look")
            worn, photo = sample_look(look, ref)
            made = Bench(
                source, Path(name), worn, seconds, rounds, as_is, told, photo, stderr_of_children()
            )
            if live:
                from makeup_video.benchmark.live import measure_live

                results = {"live": measure_live(made, heights, length)}
            else:
                results = measure(made, heights, renderer=renderer)
                results |= more(made, heights[0], faces=faces, threads=threads, minutes=length)
        if plot is not None:
            draw(results, Path(plot))
        if as_json:
            put(json.dumps(results, indent=2) + "\n")
            return
    from makeup_video.benchmark.tables import print_tables

    print_tables(results)


def heights_of(sizes: str) -> list[int]:
    """Of "720p,1080p". Raises UsageError."""
    from makeup_video.pipeline import UsageError

    parts = [part.removesuffix("p") for part in sizes.split(",")]
    heights = [int(part) for part in parts if part.isascii() and part.isdecimal() and len(part) < 5]
    if len(heights) != len(parts) or any(not 2 <= h <= 4320 or h % 2 for h in heights):
        raise UsageError(f"--sizes must be even heights such as 720p,1080p, got {sizes!r}")
    return heights


def _check(seconds: float, rounds: int, minutes: float) -> None:
    from makeup_video.pipeline import UsageError

    if not (0.5 <= seconds <= 3600 and rounds >= 1):
        raise UsageError(
            f"--seconds must be 0.5 to 3600 and --rounds at least 1, got {seconds:g} and {rounds}"
        )
    if not 0 <= minutes <= 600:
        raise UsageError(f"--length must be 0 to 600 minutes, got {minutes:g}")
