"""`makeup-video IN --ref PHOTO -o OUT`: the main job."""

from collections.abc import Generator
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer
from makeup_video.cli.console import log
from makeup_video.cli.looks_options import LooksOptions, WantedLook
from makeup_video.cli.options import (
    OUTPUT,
    RUN,
    ClusterOptions,
    Debug,
    Overwrite,
    Quiet,
    Source,
    with_options,
)
from makeup_video.cli.outcome import (
    error_text,
    join_words,
    print_summary,
    report_errors,
    settle_kernels,
)
from makeup_video.cli.output_options import OutputOptions

if TYPE_CHECKING:
    from makeup_video.pipeline import Look, Report, Settings
    from makeup_video.pipeline.files.sidecar import JsonFile
    from makeup_video.pipeline.offline.report import Outcome

EXAMPLES = (
    "makeup-video in.mp4 --ref look.jpg --lips '#C0392B:gloss' -o out.mp4",
    "makeup-video in.mp4 --look cat-eye --strength 80% -o out.mp4",
    "makeup-video in.mp4 --eyes 'sienna:outer,tan:shimmer:lid' -o out.mp4",
    "makeup-video photo.jpg --lips darkred --compare -o out.png",
    "makeup-video in.mp4 --look cat-eye --ref look.jpg -o 'out/{name}-{look}.mp4'",
)


@with_options
def apply(
    *,
    source: Source,
    look: LooksOptions,
    output: Annotated[
        str,
        typer.Option(
            "-o",
            "--output",
            metavar="OUT",
            help="Where to write the result. Several looks need {look} in the name; {name} is "
            "that of IN.",
            rich_help_panel=OUTPUT,
        ),
    ],
    overwrite: Overwrite = False,
    how: OutputOptions,
    split: Annotated[
        float | None,
        typer.Option(
            metavar="MINUTES",
            help="Paint segments of this length, each in its own process, and join them.",
            rich_help_panel=RUN,
        ),
    ] = None,
    jobs: Annotated[
        int | None,
        typer.Option(
            metavar="N",
            help="Segments painted at once; default: one for every two cores, of this machine or "
            "the cluster.",
            rich_help_panel=RUN,
        ),
    ] = None,
    cluster: ClusterOptions,
    save_look: Annotated[
        str | None,
        typer.Option(
            metavar="FILE",
            help="Write the painted look to a look file (JSON).",
            rich_help_panel=OUTPUT,
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
    """Paint a look on the faces of a video or a picture. Everything else stays as it was as far as
    the output's format can hold it: audio, timing, rotation, colour tags, subtitles, chapters.
    What the format cannot hold is reported in a line."""
    # the pipeline takes a third of a second to import: not for --help
    from makeup_video.cli.main import mark_output_whole
    from makeup_video.cli.many import print_outcomes
    from makeup_video.cli.output_names import NewFolders, name_outputs
    from makeup_video.pipeline import UsageError

    outputs: list[str] = []
    with report_errors("apply", outputs, debug, loads_more=True), NewFolders() as folders:
        settings = how.settings(
            look, overwrite=overwrite, split=split, jobs=jobs, on_whole=mark_output_whole
        )
        cluster.check()
        if cluster.ray is not None and split is None:
            raise UsageError(
                "--ray paints the segments of --split MINUTES: add it, or use makeup-video batch"
            )
        wanted = look.wanted(quiet)
        run = _Run(source, look.files, look.takes_off, report, save_look, quiet)
        outputs += name_outputs(output, source, wanted)
        if outputs != [output]:  # OUT was a template
            folders.make(outputs)
        if len(outputs) == 1:
            done = _paint_one(run, outputs[0], wanted[0], settings, cluster)
        else:
            outcomes = _paint_several(run, outputs, wanted, settings)
    if len(outputs) == 1:
        print_summary(done, quiet)
    else:
        print_outcomes(outcomes, source, quiet)


@dataclass(frozen=True)
class _Run:
    """The options that a run of one look shares with a run of several looks.

    inputs: the other files that this run reads, besides `source`.  takes_off: options, as the user
    types them, that may leave a look without makeup.  report, save_look: files to write.
    """

    source: str
    inputs: list[str]
    takes_off: list[str]
    report: str | None
    save_look: str | None
    quiet: bool


def _look_for(run: _Run, look: WantedLook) -> "Look":
    """Load a look of the run. Unless quiet, log a look that paints nothing by mistake."""
    from makeup_video.pipeline.look.words import is_none

    painted, name = look.load(run.quiet), look.fields["look"]
    # `--look none` asks for no makeup; a file that is called none.json does not
    is_meant = is_none(name) and name not in [Path(file).stem for file in run.inputs]
    if painted.is_bare and not is_meant and not run.quiet:
        why = "is at a strength of 0" if painted.layers else "has no makeup"
        by = "" if painted.layers or not run.takes_off else f"with {join_words(run.takes_off)} "
        log(f"{by}the look {name or 'given'} {why}: nothing is painted on {run.source}")
    return painted


def _make_ready(run: _Run, *, paints: bool) -> None:
    """Prepare this process for the work, once the looks are read.  paints: it needs kernels."""
    from makeup_video.pipeline.engine.machine import return_large_blocks, seek_garbage

    if paints:
        settle_kernels(run.quiet)
    seek_garbage()
    return_large_blocks()  # not earlier: reading a photo uses the same large blocks again


def _paint_one(
    run: _Run, output: str, look: WantedLook, settings: "Settings", cluster: ClusterOptions
) -> "Report":
    from makeup_video.cli.progress import show_progress
    from makeup_video.pipeline import process_video

    with _sidecars(run, [output], [look], settings.overwrite) as files:
        painted = _look_for(run, look)
        _make_ready(run, paints=not painted.is_bare and cluster.ray is None)
        with (
            cluster.workers(settings.jobs) as workers,
            show_progress(run.quiet) as on_progress,
        ):
            done = process_video(run.source, output, painted, settings, on_progress, workers)
        for file, values in zip(files, (done.to_dict(), painted.to_dict()), strict=True):
            if file is not None:
                file.write(values)
    return done


def _paint_several(
    run: _Run, outputs: list[str], looks: list[WantedLook], settings: "Settings"
) -> "list[tuple[str, Outcome]]":
    from makeup_video.cli.many import titled
    from makeup_video.cli.progress import show_progress
    from makeup_video.pipeline import UsageError, process_looks

    if run.save_look is not None:
        raise UsageError("--save-look writes one look, and several are painted: leave it out")
    with _sidecars(run, outputs, looks, settings.overwrite) as (file, _):
        painted = {
            Path(one): _look_for(run, look) for one, look in zip(outputs, looks, strict=True)
        }
        _make_ready(run, paints=not all(look.is_bare for look in painted.values()))
        names = dict(zip(painted, (look.fields["look"] for look in looks), strict=True))
        with show_progress(run.quiet) as on_progress:
            tick = titled(on_progress, run.source, names)
            done = process_looks(run.source, painted, settings, tick)
        outcomes = [(output, done[Path(output)]) for output in outputs]
        if file is not None:
            file.write({"outputs": [_values(output, outcome) for output, outcome in outcomes]})
    return outcomes


def _values(output: str, outcome: "Outcome") -> dict[str, Any]:
    """The report of one of several looks as JSON values, or the error if the look failed."""
    from makeup_video.pipeline import MakeupVideoError

    if isinstance(outcome, MakeupVideoError):
        return {"output": output, "error": error_text(outcome)}
    return outcome.to_dict()


@contextmanager
def _sidecars(
    run: _Run, outputs: list[str], looks: list[WantedLook], overwrite: bool
) -> "Generator[tuple[JsonFile | None, JsonFile | None], None, None]":
    """Open the report and the look file; None stands for a file that is not wanted.

    Checks the video's name and the looks first, then all outputs and both files, before any of them
    is begun. Raises UsageError, LookError, InputError, OutputError.
    """
    from makeup_video.pipeline.files.local_file import local_file
    from makeup_video.pipeline.files.output_file import check_place, keep_apart
    from makeup_video.pipeline.files.sidecar import LookFile, ReportFile

    source = local_file(run.source)
    for look in looks:
        look.check()
    for output in outputs:
        check_place(output, source, overwrite=overwrite)
        for file in run.inputs:
            keep_apart(Path(output), Path(file))
    with ExitStack() as stack:

        def opened(
            kind: "type[JsonFile]", path: str | None, other: str | None
        ) -> "JsonFile | None":
            if path is None:
                return None
            others = [*run.inputs, *outputs[1:], *filter(None, [other])]
            file = kind(path, run.source, outputs[0], *others, overwrite=overwrite)
            return stack.enter_context(file)

        yield (
            opened(ReportFile, run.report, run.save_look),
            opened(LookFile, run.save_look, run.report),
        )
