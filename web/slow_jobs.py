"""The thread for slow jobs: reading photos, painting portraits, encoding PNG files.

The thread has low priority, so that live frames come first. One job at a time limits its memory.
"""

import asyncio
import os
import sys
import threading
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from typing import TypeVar

from makeup_video.pipeline.errors import StoppedError

_NICE = 10
T = TypeVar("T")


class SlowJobs:
    """Runs jobs one after another on one thread."""

    def __init__(self) -> None:
        self._pool = ThreadPoolExecutor(1, "slow-jobs", initializer=_lower_priority)
        self._has_stopped = False

    def submit(self, job: Callable[[], T]) -> "Future[T]":
        """Run a job after those that wait. After `stop` the job is cancelled."""
        try:
            if not self._has_stopped:
                return self._pool.submit(job)
        except RuntimeError:
            if not self._has_stopped:  # by another thread, just now
                raise
        left_out: Future[T] = Future()
        left_out.cancel()
        return left_out

    async def run(self, job: Callable[[], T]) -> T:
        """Run a job after those that wait, and return its result; see `result_of`."""
        return await self.result_of(self.submit(job))

    async def result_of(self, submitted: "Future[T]") -> T:
        """The result of a job. Raises StoppedError for one that `stop` has left out."""
        try:
            return await asyncio.wrap_future(submitted)
        except (asyncio.CancelledError, RuntimeError):
            if self._has_stopped:
                raise StoppedError("makeup-video is stopping") from None
            raise

    def stop(self) -> None:
        """Cancel the jobs that wait. The running job is not waited for."""
        self._has_stopped = True
        self._pool.shutdown(wait=False, cancel_futures=True)


def _lower_priority() -> None:
    """Lower the priority of this thread, which only Linux can do."""
    if sys.platform == "linux":
        os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), _NICE)
