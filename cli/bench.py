"""`makeup-video bench`: compares the cost of the product with the bare codec's, in one run."""

import json
from pathlib import Path
from typing import Annotated, Any

import typer
from makeup_video.cli.console import ResultText, child_stderr, print_result
from makeup_video.cli.options import (
    MEASUREMENTS,
    OUTPUT,
    VIDEO,
    Debug,
    PrintJson,
    RefPhoto,
    SavedLook,
)
from makeup_video.cli.outcome import report_errors

EXAMPLES = (
    "makeup-video bench",
    "makeup-video bench talk.mp4 --sizes 720p --rounds 3",
    "makeup-video bench --live --length 10",
    "makeup-video bench --against old/bin/python",
)


def bench(
    clip: Annotated[
        str | None,
        typer.Argument(metavar="[CLIP]", help="A video; default in a clone: our sample."),
    ] = None,
    ref: RefPhoto = None,
    look: SavedLook = None,
    sizes: Annotated[
        str,
        typer.Option(metavar="SIZES", help="Heights to scale CLIP to.", rich_help_panel=VIDEO),
    ] = "720p,1080p",
    seconds: Annotated[
        float,
        typer.Option(
            metavar="S",
            help="Length of the video: CLIP is played forwards and backwards.",
            rich_help_panel=VIDEO,
        ),
    ] = 20.0,
    as_is: Annotated[
        bool,
        typer.Option(
            "--as-is",
            help="Only scale CLIP; do not crop its one face to half the height.",
            rich_help_panel=VIDEO,
        ),
    ] = False,
    rounds: Annotated[
        int,
        typer.Option(
            metavar="N",
            help="How often each variant runs; medians are printed.",
            rich_help_panel=MEASUREMENTS,
        ),
    ] = 5,
    renderer: Annotated[
        bool,
        typer.Option(
            help="Measure painting by itself, and the theoretical minimum.",
            rich_help_panel=MEASUREMENTS,
        ),
    ] = True,
    faces: Annotated[
        bool,
        typer.Option(
            "--faces", help="Also measure 1, 2, 4 and 8 faces.", rich_help_panel=MEASUREMENTS
        ),
    ] = False,
    threads: Annotated[
        bool,
        typer.Option("--threads", help="Also measure other threads.", rich_help_panel=MEASUREMENTS),
    ] = False,
    looks: Annotated[
        int,
        typer.Option(
            metavar="N",
            help="Also compare one run that paints N looks with N separate runs.",
            rich_help_panel=MEASUREMENTS,
        ),
    ] = 0,
    length: Annotated[
        float,
        typer.Option(
            "--length",
            metavar="MINUTES",
            help="Also measure a video of this length; with --live: the minutes of the live run.",
            rich_help_panel=MEASUREMENTS,
        ),
    ] = 0.0,
    live: Annotated[
        bool,
        typer.Option(
            "--live",
            help="Measure only the live run: the latency of its pictures on a page.",
            rich_help_panel=MEASUREMENTS,
        ),
    ] = False,
    chromium: Annotated[
        bool,
        typer.Option(
            "--chromium",
            help="With --live: measure the page in Chromium, too. Needs playwright.",
            rich_help_panel=MEASUREMENTS,
        ),
    ] = False,
    against: Annotated[
        str | None,
        typer.Option(
            metavar="PYTHON",
            help="Compare only this version with the one installed in another Python, in turn.",
            rich_help_panel=MEASUREMENTS,
        ),
    ] = None,
    as_json: PrintJson = False,
    plot: Annotated[
        str | None,
        typer.Option(
            metavar="PNG",
            help="Draw the results: needs makeup-video[plot].",
            rich_help_panel=OUTPUT,
        ),
    ] = None,
    debug: Debug = False,
) -> None:
    """Measure the product beside a bare decode-and-encode loop: speed, CPU, memory, start."""
    from tempfile import TemporaryDirectory

    from makeup_video.cli.progress import show_steps

    with report_errors("bench", debug=debug):
        from makeup_video.benchmark import suite

        heights = suite.heights_of(sizes)
        extras = suite.Extras(
            renderer=renderer,
            faces=faces,
            threads=threads,
            minutes=length,
            looks=looks,
            chromium=chromium,
        )
        suite.check_options(seconds, rounds, extras, live=live, plot=plot, against=against)
        suite.check_sources(look, ref)
        source = suite.sample_clip(clip)
        other = None if against is None else suite.other_version(against)
        with (
            TemporaryDirectory(prefix="makeup-video-bench-") as folder,
            show_steps() as log_step,
        ):
            from makeup_video.benchmark.harness import Bench

            log_step("reading the look")
            painted, photo = suite.sample_look(look, ref)
            measured = Bench(
                source,
                Path(folder),
                painted,
                seconds=seconds,
                rounds=rounds,
                as_is=as_is,
                log=log_step,
                photo=photo,
                child_stderr=child_stderr(),
                look_file=Path(look) if look is not None and Path(look).is_file() else None,
            )
            results = suite.run_suite(measured, heights, extras, live=live, against=other)
        _show(results, plot, as_json)


def _show(results: dict[str, Any], plot: str | None, as_json: bool) -> None:
    """Draw the results if a plot is wanted, and print them."""
    if plot is not None:
        from makeup_video.benchmark.plots import draw

        draw(results, Path(plot))
    if as_json:
        print_result(json.dumps(results, indent=2) + "\n")
        return
    from makeup_video.benchmark.tables import draw_tables

    text = ResultText()
    draw_tables(results, text)
    print_result(text.getvalue())
