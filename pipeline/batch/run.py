"""run_batch: does the jobs that are left, a few at a time, and keeps the journal."""

import contextlib
from collections import deque
from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from dataclasses import replace
from functools import partial
from pathlib import Path
from queue import SimpleQueue
from typing import Protocol

from makeup_video.pipeline.batch.child import ChildProcess
from makeup_video.pipeline.batch.job import Failed, Job, JobProgress, Result
from makeup_video.pipeline.batch.journal import Journal, identity
from makeup_video.pipeline.batch.plan import adopt
from makeup_video.pipeline.engine.machine import cores, free_memory_bytes
from makeup_video.pipeline.errors import (
    MakeupVideoError,
    StoppedError,
    UsageError,
    WorkerError,
    option,
)
from makeup_video.pipeline.files.output_file import part_of, target_of
from makeup_video.pipeline.files.part_file import remove_ended

_TICK_SECONDS = 0.2
_MEMORY_SHARE = 0.5  # of the free memory, for the encoders of all jobs
_JOB_BYTES = 1_500_000_000  # what painting some looks of a film at 1080p holds


class Worker(Protocol):
    """Where jobs are done: a process of this machine, or another machine.

    `run` is as run_job, in one thread at a time; `stop` ends it from any thread.
    """

    def run(self, job: Job, report: Callable[[JobProgress], None], /) -> list[Result]: ...
    def stop(self) -> None: ...


class BatchEvents(Protocol):
    """What a batch reports while it runs, from one thread."""

    def progress(self, job: Job, progress: JobProgress) -> None: ...
    def ended(self, job: Job, results: Sequence[Result]) -> None: ...


def local_workers(count: int | None = None) -> list[Worker]:
    """Processes of this machine; None: one for every two cores, fewer where memory is short.

    One film keeps two cores busy. Raises UsageError for less than one.
    """
    if count is None:
        by_memory = int(free_memory_bytes() / _JOB_BYTES)
        count = max(1, min(cores() // 2, by_memory))
    if count < 1:
        raise UsageError(f"{option('jobs')} must be at least 1, got {count}")
    return [ChildProcess() for _ in range(count)]


def run_batch(
    jobs: Sequence[Job],
    journal: Journal,
    events: BatchEvents,
    workers: Sequence[Worker],
) -> dict[str, Result]:
    """Do every job; returns the results by output. No error of a job ends the batch.

    workers: each does one job at a time; see local_workers. They are stopped in the end.
    Raises StoppedError after Ctrl-C, OutputError when the journal cannot be written. What was being
    written is then removed.
    """
    jobs = [replace(job, memory_share=_MEMORY_SHARE / len(workers)) for job in jobs]
    run = _Run(jobs, journal, events, workers)
    with ThreadPoolExecutor(len(workers)) as pool:
        try:
            run.all_jobs(pool)
        except BaseException as error:
            run.stop()
            if isinstance(error, KeyboardInterrupt):
                raise StoppedError("stopped by the user") from None
            raise
        finally:
            for worker in workers:
                worker.stop()
    return run.results


class _Run:
    def __init__(
        self,
        jobs: Sequence[Job],
        journal: Journal,
        events: BatchEvents,
        workers: Sequence[Worker],
    ) -> None:
        self.results: dict[str, Result] = {}
        self._journal, self._events, self._workers = journal, events, workers
        self._left = deque(jobs)
        self._idle: SimpleQueue[Worker] = SimpleQueue()
        for worker in workers:
            self._idle.put(worker)
        self._running: dict[Future[list[Result]], Job] = {}
        self._was: dict[str, list[int] | None] = {}
        self._progress: SimpleQueue[tuple[Job, JobProgress]] = SimpleQueue()

    def all_jobs(self, pool: ThreadPoolExecutor) -> None:
        while self._left or self._running:
            while self._left and len(self._running) < len(self._workers):
                self._begin(pool, self._left.popleft())
            done, _ = wait(self._running, _TICK_SECONDS, FIRST_COMPLETED)
            while not self._progress.empty():
                self._events.progress(*self._progress.get())
            for future in done:
                self._end(self._running.pop(future), future)

    def _begin(self, pool: ThreadPoolExecutor, job: Job) -> None:
        for one in job.looks:
            self._was[one.output] = identity(one.output)
        self._journal.begin(job)
        self._running[pool.submit(self._do, job)] = job

    def _do(self, job: Job) -> list[Result]:
        """Runs in a thread of the pool."""
        worker = self._idle.get()
        try:
            return worker.run(job, partial(self._report, job))
        except StoppedError:
            raise
        except MakeupVideoError as error:
            return [Failed(one.output, error) for one in job.looks]
        finally:
            self._idle.put(worker)

    def _report(self, job: Job, progress: JobProgress) -> None:
        self._progress.put((job, progress))

    def _end(self, job: Job, future: Future[list[Result]]) -> None:
        results = [self._settled(job, one) for one in future.result()]
        self._journal.end(job, results)
        self.results |= {one.output: one for one in results}
        self._events.ended(job, results)

    def _settled(self, job: Job, result: Result) -> Result:
        """The result; of a process that died some outputs may be whole, and parts are left."""
        if not (isinstance(result, Failed) and isinstance(result.error, WorkerError)):
            return result
        _remove_part(result.output)
        (look,) = job.only({result.output}).looks
        return adopt(job, look, self._was[result.output]) or result

    def stop(self) -> None:
        """End all workers, and remove what they were writing."""
        for worker in self._workers:
            worker.stop()
        wait(self._running)
        for job in self._running.values():
            for one in job.looks:
                _remove_part(one.output)


def _remove_part(output: str) -> None:
    with contextlib.suppress(MakeupVideoError, OSError):
        remove_ended(part_of(target_of(Path(output))))
