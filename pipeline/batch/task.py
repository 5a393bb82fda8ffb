"""The task of a batch: does a job in any process, and resumes a job whose machine was lost."""

from collections.abc import Callable, Sequence
from fractions import Fraction
from pathlib import Path

from makeup_video.pipeline.batch.job import Done, Failed, Job, JobProgress, Result
from makeup_video.pipeline.batch.plan import adopt
from makeup_video.pipeline.batch.thumbnails import thumbnail
from makeup_video.pipeline.errors import MakeupVideoError
from makeup_video.pipeline.files.output_file import part_of
from makeup_video.pipeline.files.part_file import remove_ended
from makeup_video.pipeline.offline.looks import process_looks
from makeup_video.pipeline.offline.process import process_video
from makeup_video.pipeline.offline.report import Outcome, Report


def do_job(job: Job, report: Callable[[JobProgress], None]) -> list[Result]:
    """Like run_job, but keeps outputs that an earlier attempt, on a lost machine, has finished."""
    if job.attempt == 1:
        return run_job(job, report)
    known: dict[str, Result] = {}
    for at, output in enumerate(job.outputs):
        remove_ended(part_of(Path(output)))
        if (done := adopt(job, at)) is not None:
            known[output] = done
    left = job.only(set(job.outputs) - set(known))
    if left.looks:
        known |= {one.output: one for one in run_job(left, report)}
    return [known[output] for output in job.outputs]


def run_job(job: Job, report: Callable[[JobProgress], None]) -> list[Result]:
    """Paint all looks of a job; returns a result for each, in their order.

    report: called a few times a second while a video is painted.
    An error of the input becomes the error of every look. Raises no MakeupVideoError.
    """
    try:
        outcomes = _paint(job, report)
    except MakeupVideoError as error:
        return [Failed(one.output, error) for one in job.looks]
    results: list[Result] = []
    is_first = True  # of the finished looks, which share one picture before
    for one in job.looks:
        outcome, before = outcomes[one.output], None
        if isinstance(outcome, MakeupVideoError):
            results.append(Failed(one.output, outcome))
            continue
        if is_first:
            before = thumbnail(Path(job.source), float(job.settings.start_seconds or 0))
            is_first = False
        results.append(_done(one.output, outcome, before))
    return results


def _paint(job: Job, report: Callable[[JobProgress], None]) -> dict[str, Outcome]:
    names = {Path(one.output): one.name for one in job.looks}
    if len(job.looks) == 1:
        (only,) = job.looks

        def tick(done: int, expected: int | None, rate: Fraction) -> None:
            report(JobProgress((only.name,), done, expected))

        painted = process_video(job.source, only.output, only.look, job.settings, tick)
        return {only.output: painted}

    def tick_all(outputs: Sequence[Path], done: int, expected: int | None, rate: Fraction) -> None:
        report(JobProgress(tuple(names[one] for one in outputs), done, expected))

    looks = {Path(one.output): one.look for one in job.looks}
    outcomes = process_looks(job.source, looks, job.settings, tick_all, job.memory_share)
    return {one.output: outcomes[Path(one.output)] for one in job.looks}


def _done(output: str, report: Report, before: bytes | None) -> Done:
    return Done(
        output,
        report.bytes_out,
        report.frames_out,
        report.seconds,
        tuple(report.warnings()),
        report.damaged,
        before,
        thumbnail(Path(output), is_own=True),
    )
