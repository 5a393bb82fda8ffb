"""`makeup-video batch IN... -o TEMPLATE`: many inputs, many looks, and a journal."""

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from makeup_video.cli.console import log, log_stopped
from makeup_video.cli.looks_options import LooksOptions
from makeup_video.cli.options import (
    OUTPUT,
    RUN,
    ClusterOptions,
    Debug,
    Overwrite,
    Quiet,
    with_options,
)
from makeup_video.cli.outcome import error_text, report_errors, settle_kernels, some_of
from makeup_video.cli.output_options import OutputOptions

if TYPE_CHECKING:
    from collections.abc import Sequence

    from makeup_video.cli.batch_jobs import BatchJobs
    from makeup_video.pipeline.batch.job import Job, JobProgress, Result
    from makeup_video.pipeline.engine.jobs import Worker

EXAMPLES = (
    "makeup-video batch clips --look cat-eye -o 'out/{name}.mp4'",
    "makeup-video batch 'clips/*.mov' --looks shades -o 'out/{name}-{look}.mp4'",
    "makeup-video batch in.jpg --catalogue shades.csv -o '{brand}/{shade}.jpg'",
    "makeup-video batch --list jobs.csv -o 'out/{name}.mp4' --resume",
)


@with_options
def batch(
    *,
    inputs: Annotated[
        list[str] | None,
        typer.Argument(
            metavar="[INPUTS]",
            help="Videos and pictures, folders of them, or patterns such as 'clips/*.mp4'.",
        ),
    ] = None,
    listed: Annotated[
        str | None,
        typer.Option(
            "--list",
            metavar="CSV",
            help="A CSV file with a row for each input. The column in is required; out, look, ref, "
            "start, end and the names of other look options are optional.",
            rich_help_panel=RUN,
        ),
    ] = None,
    look: LooksOptions,
    output: Annotated[
        str | None,
        typer.Option(
            "-o",
            "--output",
            metavar="TEMPLATE",
            help="The names of the outputs, with {name}, {ext} and {folder} of the input, {look}, "
            "or {brand}, {product} and {shade} of a catalogue. Missing folders are made.",
            rich_help_panel=OUTPUT,
        ),
    ] = None,
    overwrite: Overwrite = False,
    how: OutputOptions,
    journal: Annotated[
        str | None,
        typer.Option(
            metavar="FILE",
            help="Where to record which outputs are complete; default: makeup-video.jsonl in the "
            "folder of the outputs.",
            rich_help_panel=RUN,
        ),
    ] = None,
    resume: Annotated[
        bool,
        typer.Option(
            "--resume",
            help="Resume a batch that was stopped, and fail where there is no journal. Without "
            "--resume the same command resumes, too, but starts a new batch where there is none.",
            rich_help_panel=RUN,
        ),
    ] = False,
    retry: Annotated[
        bool,
        typer.Option(
            "--retry", help="Also retry what failed in an earlier run.", rich_help_panel=RUN
        ),
    ] = False,
    jobs: Annotated[
        int | None,
        typer.Option(
            metavar="N",
            help="How many inputs to work on at once; default: one for every two cores.",
            rich_help_panel=RUN,
        ),
    ] = None,
    cluster: ClusterOptions,
    quiet: Quiet = False,
    debug: Debug = False,
) -> None:
    """Paint many videos and pictures. Outputs that are complete are not painted again, and one
    that fails does not stop the others. At the end, index.html next to the outputs shows every
    input before and after."""
    from makeup_video.cli.batch_jobs import open_batch
    from makeup_video.cli.output_names import NewFolders
    from makeup_video.pipeline.batch.run import local_workers

    with report_errors("batch", debug=debug), NewFolders() as folders:
        settings = how.settings(look, overwrite=overwrite)
        cluster.check()
        work = open_batch(
            inputs or [],
            listed=listed,
            look=look,
            how=how,
            output=output,
            journal=journal,
            overwrite=overwrite,
            resume=resume,
            folders=folders,
            quiet=quiet,
        )
        if cluster.ray is None:
            settle_kernels(quiet)
        with work.journal, cluster.workers(jobs) as remote:
            workers = remote or local_workers(jobs)
            results = _run(work, settings.overwrite, retry, workers, quiet)
    _print_end(work, results, quiet)


def _run(
    work: "BatchJobs", overwrite: bool, retry: bool, workers: "Sequence[Worker]", quiet: bool
) -> "dict[str, Result]":
    """Paint the outputs that are left, and write the page. Ctrl-C ends with exit code 130."""
    from makeup_video.cli.progress import show_batch
    from makeup_video.pipeline import StoppedError
    from makeup_video.pipeline.batch.page import check_page, write_page
    from makeup_video.pipeline.batch.plan import plan_batch
    from makeup_video.pipeline.batch.run import run_batch

    check_page(work.page, overwrite=overwrite)
    plan = plan_batch(work.jobs, work.journal, retry=retry, overwrite=overwrite)
    if plan.known and not quiet:
        log(f"{len(plan.known)} of {work.count} outputs are in the journal already")
    try:
        with show_batch(quiet) as (log_line, show):
            events = _Events(plan.todo, log_line, show)
            results = plan.known | run_batch(plan.todo, work.journal, events, workers)
    except StoppedError:
        log_stopped("stopped: run the same command again to resume")
        raise typer.Exit(StoppedError.exit_code) from None
    write_page(work.page, work.jobs, results, error_text)
    return results


class _Events:
    """Shows how a batch proceeds: a line for each output, and the job in hand."""

    def __init__(
        self,
        jobs: "Sequence[Job]",
        log_line: Callable[[str], None],
        show: Callable[[str], None],
    ) -> None:
        self._log, self._show, self._total, self._done = log_line, show, len(jobs), 0

    def progress(self, job: "Job", progress: "JobProgress") -> None:
        total = f"/{progress.expected}" if progress.expected else ""
        self._show(
            f"{self._done} of {self._total} inputs done; {Path(job.source).name}: "
            f"{some_of(progress.looks)}, {progress.frames}{total} frames"
        )

    def ended(self, job: "Job", results: "Sequence[Result]") -> None:
        self._done += 1
        for result in results:
            self._log(f"[{self._done}/{self._total}] {_line(result)}")


def _line(result: "Result") -> str:
    from makeup_video.pipeline.batch.job import Done

    if not isinstance(result, Done):
        return f"{result.output} failed: {error_text(result.error)}"
    took = f" in {result.seconds:.1f} s" if result.seconds else ""
    notes = "".join(f"; {text}" for text in result.warnings)
    return f"{result.output}: {result.size_in_words}{took}{notes}"


def _print_end(work: "BatchJobs", results: "dict[str, Result]", quiet: bool) -> None:
    """Log how many outputs are done, and name those that failed.

    Raises typer.Exit with exit code 5 when an output failed or an input was damaged.
    """
    from makeup_video.pipeline.batch.job import Done
    from makeup_video.pipeline.batch.plan import is_hopeless
    from makeup_video.pipeline.errors import EXIT_IN_PART

    failed = [one for one in results.values() if not isinstance(one, Done)]
    damaged = [one for one in results.values() if isinstance(one, Done) and one.damaged]
    if not quiet:
        log(f"{len(results) - len(failed)} of {len(results)} outputs done; {work.page} shows them")
    hopeless = [one for one in failed if is_hopeless(one)]
    hopeful = [one for one in failed if one not in hopeless]
    for some, advice in (
        (hopeful, "; --retry tries again"),
        (hopeless, ", and would fail again with --retry"),
    ):
        if some:
            log(f"{len(some)} failed{advice}:")
        for one in some:
            log(f"  {_line(one)}")
    if work.changes_kind([one.output for one in hopeless]):
        log("a template that ends in .{ext}, as in -o '{name}.{ext}', suits pictures and videos")
    if failed or damaged:
        raise typer.Exit(EXIT_IN_PART)
