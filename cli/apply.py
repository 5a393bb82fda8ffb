"""`makeup-video IN --ref PHOTO -o OUT`: the main job."""

from collections.abc import Generator
from contextlib import ExitStack, contextmanager
from dataclasses import replace
from fractions import Fraction
from math import isfinite
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from makeup_video.cli.look_options import LookOptions
from makeup_video.cli.options import (
    OUTPUT,
    RUN,
    Debug,
    End,
    Overwrite,
    Quiet,
    Source,
    Start,
    parse_time,
    with_options,
)
from makeup_video.cli.outcome import print_summary, report_errors

if TYPE_CHECKING:
    from makeup_video.pipeline.media.sidecar import JsonFile

EXAMPLES = (
    "makeup-video in.mp4 --ref look.jpg -o out.mp4",
    "makeup-video in.mp4 --ref look.jpg --lips '#C0392B:gloss' -o out.mp4",
    "makeup-video in.mp4 --look cat-eye --strength 80% -o out.mp4",
    "makeup-video in.mp4 --eyes 'sienna:outer,tan:shimmer:lid' -o out.mp4",
    "makeup-video photo.jpg --lips darkred --compare -o out.png",
)


@with_options
def apply(
    source: Source,
    look: LookOptions,
    output: Annotated[
        str,
        typer.Option(
            "-o",
            "--output",
            metavar="OUT",
            help="Where to write the result.",
            rich_help_panel=OUTPUT,
        ),
    ],
    overwrite: Overwrite = False,
    compare: Annotated[
        bool,
        typer.Option(
            "--compare", help="Show before and after side by side.", rich_help_panel=OUTPUT
        ),
    ] = False,
    start: Start = None,
    end: End = None,
    codec: Annotated[
        str | None,
        typer.Option(
            metavar="NAME",
            help="{codecs}; default: what suits IN and OUT.",
            rich_help_panel=OUTPUT,
        ),
    ] = None,
    crf: Annotated[
        int | None,
        typer.Option(
            metavar="N",
            help="Quality: lower is better and larger; default: by codec.",
            rich_help_panel=OUTPUT,
        ),
    ] = None,
    preset: Annotated[
        str | None,
        typer.Option(
            metavar="NAME",
            help="The encoder's speed preset; default: by codec.",
            rich_help_panel=OUTPUT,
        ),
    ] = None,
    bit_depth: Annotated[
        int | None,
        typer.Option(
            metavar="BITS",
            help="8, 10 or 12; default: that of IN, but 8 in H.264.",
            rich_help_panel=OUTPUT,
        ),
    ] = None,
    sdr: Annotated[
        bool,
        typer.Option(
            "--sdr", help="Turn HDR (PQ, HLG) into SDR, for every screen.", rich_help_panel=OUTPUT
        ),
    ] = False,
    split: Annotated[
        float | None,
        typer.Option(
            metavar="MINUTES",
            help="Paint segments of this length, each in its own process.",
            rich_help_panel=RUN,
        ),
    ] = None,
    jobs: Annotated[
        int | None,
        typer.Option(
            metavar="N",
            help="Segments painted at once; default: half the cores.",
            rich_help_panel=RUN,
        ),
    ] = None,
    strict: Annotated[
        bool,
        typer.Option(
            "--strict",
            help="Fail rather than drop or convert anything unasked.",
            rich_help_panel=OUTPUT,
        ),
    ] = False,
    save_look: Annotated[
        str | None,
        typer.Option(
            metavar="FILE", help="Write the look that is painted as JSON.", rich_help_panel=OUTPUT
        ),
    ] = None,
    report: Annotated[
        str | None,
        typer.Option(
            metavar="FILE", help="Write counts and times as JSON.", rich_help_panel=OUTPUT
        ),
    ] = None,
    quiet: Quiet = False,
    debug: Debug = False,
) -> None:
    """Paint the makeup of a look on every frame of a video; everything else stays as it was."""
    # the pipeline takes a third of a second to import: not for --help
    from makeup_video.cli.main import mark_output_whole
    from makeup_video.cli.progress import show_progress
    from makeup_video.pipeline import Settings, UsageError, process_video
    from makeup_video.pipeline.look.options import check_options, choose_look

    with report_errors("apply", output, debug):
        if split is not None and not isfinite(split):
            raise UsageError(f"--split must be a number of minutes, got {split}")
        settings = Settings(
            codec=codec,
            crf=crf,
            preset=preset,
            start_seconds=parse_time(start, "--start"),
            end_seconds=parse_time(end, "--end"),
            overwrite=overwrite,
            strict=strict,
            bit_depth=bit_depth,
            sdr=sdr,
            faces=look.faces,
            compare=compare,
            split_minutes=None if split is None else Fraction(split),
            jobs=jobs,
            device=look.device,
            on_whole=mark_output_whole,
        )
        choice = look.choice()
        check_options(choice)
        with _sidecars(source, output, look.files, report, save_look, overwrite) as files:
            painted = choose_look(replace(choice, base=look.base_look(quiet)))
            with show_progress(quiet) as on_progress:
                done = process_video(source, output, painted, settings, on_progress)
            for file, values in zip(files, (done.to_dict(), painted.to_dict()), strict=True):
                if file is not None:
                    file.write(values)
    print_summary(done, quiet)


@contextmanager
def _sidecars(
    source: str,
    output: str,
    inputs: list[str],
    report: str | None,
    save_look: str | None,
    overwrite: bool,
) -> "Generator[tuple[JsonFile | None, JsonFile | None], None, None]":
    """Open the report and the look file; OUT and both of them are checked before any is begun.

    inputs: files beside `source` that this run reads.  Raises UsageError, OutputError.
    """
    from makeup_video.pipeline.files.output_file import check_place, keep_apart
    from makeup_video.pipeline.media.input_file import local_file
    from makeup_video.pipeline.media.sidecar import LookFile, ReportFile

    check_place(output, local_file(source), overwrite=overwrite)
    for file in inputs:
        keep_apart(Path(output), Path(file))
    with ExitStack() as stack:

        def opened(
            kind: "type[JsonFile]", path: str | None, other: str | None
        ) -> "JsonFile | None":
            if path is None:
                return None
            others = inputs if other is None else [*inputs, other]
            return stack.enter_context(kind(path, source, output, *others, overwrite=overwrite))

        yield opened(ReportFile, report, save_look), opened(LookFile, save_look, report)
