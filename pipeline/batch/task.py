"""The task of a batch: does a job in any process, and resumes a job whose machine was lost."""

from collections.abc import Callable
from pathlib import Path

from makeup_video.pipeline.batch.job import Job, JobProgress, Result, run_job
from makeup_video.pipeline.batch.plan import adopt
from makeup_video.pipeline.files.output_file import part_path, target_of
from makeup_video.pipeline.files.part_file import remove_ended


def do_job(job: Job, report: Callable[[JobProgress], None]) -> list[Result]:
    """Like run_job, but keeps outputs that an earlier attempt, on a lost machine, has finished."""
    if job.attempt == 1:
        return run_job(job, report)
    known: dict[str, Result] = {}
    for at, output in enumerate(job.outputs):
        remove_ended(part_path(target_of(Path(output))))
        if (done := adopt(job, at)) is not None:
            known[output] = done
    left = job.only(set(job.outputs) - set(known))
    if left.looks:
        known |= {one.output: one for one in run_job(left, report)}
    return [known[output] for output in job.outputs]
