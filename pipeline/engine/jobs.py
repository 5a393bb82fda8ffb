"""Does a list of jobs with workers, each of which does one job at a time.

A job is a plain value and a task is a function of a module, so that processes and other machines
can do them.
"""

from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ThreadPoolExecutor, wait
from functools import partial
from itertools import islice
from queue import SimpleQueue
from typing import Any, Generic, Protocol, TypeVar

from makeup_video.pipeline.engine.signals import interrupted_later, undisturbed
from makeup_video.pipeline.errors import MakeupVideoError, StoppedError, UsageError, option

Job = TypeVar("Job")
Progress = TypeVar("Progress")
Result = TypeVar("Result")
# task(job, report) returns the result; it calls report(progress) a few times a second
Task = Callable[[Job, Callable[[Progress], None]], Result]

WAS_STOPPED = "workers serve one video, and these were stopped after another: make new ones"
CORES_PER_JOB = 2  # one video keeps two cores busy
_TICK_SECONDS = 0.2


class Worker(Protocol):
    """Where jobs are done: a process of this machine, or a task on another machine.

    run: does one job at a time, in any thread. Raises what the task raises, WorkerError when the
    process or machine that did the job is gone, StoppedError when `stop` ends the job, and
    UsageError after `stop`.
    stop: ends the job at once, from any thread.
    per_machine: how many of these workers may share the memory of one machine; None: all.
    """

    per_machine: int | None

    def run(
        self, task: Task[Job, Progress, Result], job: Job, report: Callable[[Progress], None], /
    ) -> Result: ...
    def stop(self) -> None: ...


def jobs_at_once(wanted: int | None, room: int) -> int:
    """As many jobs as wanted; None: as many as there is room for, but at least one.

    Raises UsageError for fewer than one.
    """
    if wanted is None:
        return max(1, room)
    if wanted < 1:
        raise UsageError(f"{option('jobs')} must be at least 1, got {wanted}")
    return wanted


def run_jobs(
    task: Task[Job, Progress, Result],
    jobs: Iterable[Job],
    workers: Sequence[Worker],
    on_progress: Callable[[Job, Progress], None],
    on_end: Callable[[Job, Result | MakeupVideoError], None],
) -> None:
    """Do every job, as many at once as there are workers.

    jobs: one is taken whenever a worker is free.
    on_progress, on_end: called in this thread, on_end with the result of a job or with its error.
    Raises what these functions raise, StoppedError after Ctrl-C, and errors that are not ours. In
    these cases all workers are stopped; otherwise they can go on with other jobs.
    """
    run = _Run(task, workers, on_progress, on_end)
    with ThreadPoolExecutor(len(workers)) as pool:
        try:
            run(pool, iter(jobs))
        except BaseException as error:
            with undisturbed():
                for worker in workers:
                    worker.stop()
                wait(run.running)
            if isinstance(error, KeyboardInterrupt):
                raise StoppedError from None
            raise


class _Run(Generic[Job, Progress, Result]):
    def __init__(
        self,
        task: Task[Job, Progress, Result],
        workers: Sequence[Worker],
        on_progress: Callable[[Job, Progress], None],
        on_end: Callable[[Job, Result | MakeupVideoError], None],
    ) -> None:
        self.running: dict[Future[Result], Job] = {}
        self._task, self._on_progress, self._on_end = task, on_progress, on_end
        self._count = len(workers)
        self._idle: SimpleQueue[Worker] = SimpleQueue()
        for worker in workers:
            self._idle.put(worker)
        self._progress: SimpleQueue[tuple[Job, Any]] = SimpleQueue()

    def __call__(self, pool: ThreadPoolExecutor, jobs: Iterator[Job]) -> None:
        self._fill(pool, jobs)
        while self.running:
            done, _ = wait(self.running, _TICK_SECONDS, FIRST_COMPLETED)
            while not self._progress.empty():
                self._on_progress(*self._progress.get())
            for future in done:
                outcome: Result | MakeupVideoError = _outcome(future)
                self._on_end(self.running.pop(future), outcome)
            self._fill(pool, jobs)

    def _fill(self, pool: ThreadPoolExecutor, jobs: Iterator[Job]) -> None:
        for job in islice(jobs, self._count - len(self.running)):
            with interrupted_later():
                self.running[pool.submit(self._do, job)] = job

    def _do(self, job: Job) -> Result:
        """Runs in a thread of the pool."""
        worker = self._idle.get()
        try:
            return worker.run(self._task, job, partial(self._report, job))
        finally:
            self._idle.put(worker)

    def _report(self, job: Job, progress: Progress) -> None:
        self._progress.put((job, progress))


def _outcome(future: Future[Any]) -> Any:
    """The result of a job, or its error. Raises StoppedError, and errors that are not ours."""
    try:
        return future.result()
    except StoppedError:
        raise
    except MakeupVideoError as error:
        return error
