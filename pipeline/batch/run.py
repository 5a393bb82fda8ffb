"""run_batch: does the jobs that are left, a few at a time, and keeps the journal."""

import contextlib
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Protocol

from makeup_video.pipeline.batch.job import Failed, Job, JobProgress, Result
from makeup_video.pipeline.batch.journal import Journal
from makeup_video.pipeline.batch.plan import adopt
from makeup_video.pipeline.batch.task import do_job
from makeup_video.pipeline.engine.jobs import CORES_PER_JOB, Worker, jobs_at_once, run_jobs
from makeup_video.pipeline.engine.machine import cores, free_memory_bytes
from makeup_video.pipeline.engine.processes import ChildProcess
from makeup_video.pipeline.errors import MakeupVideoError, TooLittleMemoryError, WorkerError
from makeup_video.pipeline.files.output_file import part_of
from makeup_video.pipeline.files.part_file import remove_ended

_MEMORY_SHARE = 0.5  # of the free memory, for the encoders of all jobs
_JOB_BYTES = 1_500_000_000  # what painting some looks of a video at 1080p holds


class BatchEvents(Protocol):
    """What a batch reports while it runs, from one thread."""

    def progress(self, job: Job, progress: JobProgress) -> None: ...
    def ended(self, job: Job, results: Sequence[Result]) -> None: ...


def local_workers(count: int | None = None) -> list[Worker]:
    """Processes of this machine; None: one for every two cores, fewer where memory is short.

    Raises UsageError for fewer than one.
    """
    room = min(cores() // CORES_PER_JOB, int(free_memory_bytes() / _JOB_BYTES))
    return [ChildProcess() for _ in range(jobs_at_once(count, room))]


def run_batch(
    jobs: Sequence[Job],
    journal: Journal,
    events: BatchEvents,
    workers: Sequence[Worker],
) -> dict[str, Result]:
    """Do every job; returns the results by output. No error of a job ends the batch.

    workers: each does one job at a time; see local_workers. They are stopped in the end.
    Raises StoppedError after Ctrl-C, OutputError when the journal cannot be written. Unfinished
    outputs are then removed.
    """
    sharing = min(len(workers), len(jobs), *(one.per_machine or len(workers) for one in workers))
    share = _MEMORY_SHARE / max(1, sharing)
    run = _Run([replace(job, memory_share=share) for job in jobs], journal, events)
    try:
        run_jobs(do_job, run.begun(), workers, events.progress, run.end)
    except BaseException:
        run.remove_parts()
        raise
    finally:
        for worker in workers:
            worker.stop()
    return run.results


class _Run:
    """The jobs of a batch as they begin and end."""

    def __init__(self, jobs: Sequence[Job], journal: Journal, events: BatchEvents) -> None:
        self.results: dict[str, Result] = {}
        self._jobs, self._journal, self._events = jobs, journal, events
        self._running: list[Job] = []

    def begun(self) -> Iterator[Job]:
        """Each job, once the journal notes that the job has begun."""
        for job in self._jobs:
            self._running.append(noted := self._journal.begin(job))
            yield noted

    def end(self, job: Job, outcome: list[Result] | MakeupVideoError) -> None:
        if isinstance(outcome, MakeupVideoError):
            outcome = [Failed(output, outcome) for output in job.outputs]
        settled = [self._settled(job, at, result) for at, result in enumerate(outcome)]
        results = self._journal.end(job, settled)
        self._running.remove(job)
        self.results |= {one.output: one for one in results}
        self._events.ended(job, results)

    def _settled(self, job: Job, at: int, result: Result) -> Result:
        """The final result for one output.

        A process that died, or had too little memory, may have finished this output or left its
        part.
        """
        cut_short = (WorkerError, TooLittleMemoryError)
        if not (isinstance(result, Failed) and isinstance(result.error, cut_short)):
            return result
        _remove_part_quietly(result.output)
        return adopt(job, at) or result

    def remove_parts(self) -> None:
        """Remove the parts of all outputs that are being written."""
        for job in self._running:
            for one in job.looks:
                _remove_part_quietly(one.output)


def _remove_part_quietly(output: str) -> None:
    with contextlib.suppress(MakeupVideoError, OSError):
        remove_ended(part_of(Path(output)))
