"""Runs jobs in processes of their own, a few at a time.

A job is a plain value and a task is a function of a module, so that another engine can run the same
jobs on other machines.
"""

import multiprocessing
import os
import signal
import threading
from collections import deque
from collections.abc import Callable, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from typing import Any, Generic, TypeVar

from makeup_video.pipeline.engine.signals import interrupted_later, stop_signals, undisturbed
from makeup_video.pipeline.errors import StoppedError, WorkerError

Job = TypeVar("Job")
Result = TypeVar("Result")
# task(job, tick): the task calls tick(items done so far) a few times a second
Task = Callable[[Job, Callable[[int], None]], Result]

_TICK_SECONDS = 0.2
_shared: Any = None  # in a worker: the items done of each job, and whether all shall stop


class Processes(Generic[Job, Result]):
    """Runs a task on each job.

    workers: how many at once.
    follow: makes a job ready once the result of the job before it is known, so that jobs run one
    after another; None: they do not depend on each other.
    """

    def __init__(
        self,
        task: Task[Job, Result],
        workers: int,
        follow: Callable[[Job, Result], Job] | None = None,
    ) -> None:
        self._task, self._follow = task, follow
        self._workers = 1 if follow else workers

    def run(self, jobs: Sequence[Job], on_tick: Callable[[int], None]) -> list[Result]:
        """The results, in the order of the jobs. on_tick(items done by all jobs) is called often.

        Raises the first error of any job, WorkerError when a process was killed, StoppedError after
        Ctrl-C. All other jobs are stopped then.
        """
        # the children must neither inherit threads nor OpenCL and nets, so they are not forked
        context = multiprocessing.get_context("spawn")
        shared = context.RawArray("q", len(jobs) + 1)
        workers = min(self._workers, len(jobs))
        pool = ProcessPoolExecutor(workers, context, _begin_worker, (shared,))
        try:
            return self._results(pool, workers, jobs, lambda: on_tick(sum(shared[:-1])))
        except BrokenProcessPool as error:
            raise WorkerError(
                "a process that painted a segment was killed, perhaps since memory ran out: run "
                "again, with fewer at once"
            ) from error
        except KeyboardInterrupt:
            raise StoppedError("stopped by the user") from None
        finally:
            shared[-1] = True
            with undisturbed():
                pool.shutdown(cancel_futures=True)

    def _results(
        self,
        pool: ProcessPoolExecutor,
        workers: int,
        jobs: Sequence[Job],
        tick: Callable[[], None],
    ) -> list[Result]:
        waiting = deque(enumerate(jobs))
        running: dict[Future[Result], int] = {}
        results: dict[int, Result] = {}
        while waiting or running:
            while waiting and len(running) < workers:
                index, job = waiting.popleft()
                if self._follow and index:
                    job = self._follow(job, results[index - 1])
                with interrupted_later():
                    running[pool.submit(_work, self._task, index, job)] = index
            for future in wait(running, _TICK_SECONDS, FIRST_COMPLETED).done:
                results[running.pop(future)] = future.result()
            tick()
        return [results[index] for index in range(len(jobs))]


def _begin_worker(shared: Any) -> None:
    global _shared
    _shared = shared
    threading.Thread(target=_end_with_parent, daemon=True).start()
    for number in stop_signals():  # of the terminal's whole group: the main process decides
        signal.signal(number, signal.SIG_IGN)


def _end_with_parent() -> None:
    """End this process when the main one is gone: it would wait for its next job for ever."""
    parent = multiprocessing.parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)


def _work(task: Task[Job, Result], index: int, job: Job) -> Result:
    return task(job, lambda done: _tick(index, done))


def _tick(index: int, done: int) -> None:
    """Count the items done. Raises StoppedError when the run is over."""
    if _shared[-1]:
        raise StoppedError("stopped by the user")
    _shared[index] = done
