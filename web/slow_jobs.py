"""The threads for jobs that the server's loop does not wait for.

Reading photos, painting portraits and encoding PNG files are slow jobs. Their thread has low
priority, so that live frames come first. Only one slow job runs at a time, which limits the memory.
Jobs of cameras and recordings run on a thread of their own with the usual priority: such a job may
start threads, which inherit its priority for good, and stopping a recording must not wait for a
photo.
"""

import asyncio
import os
import sys
import threading
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from typing import TypeVar

from makeup_video.pipeline.errors import StoppedError
from makeup_video.web.cut_off import STOPPING

_NICE = 10
T = TypeVar("T")


class SlowJobs:
    """Runs slow jobs one after another, and jobs of cameras and recordings on another thread."""

    def __init__(self) -> None:
        self._pool = ThreadPoolExecutor(1, "slow-jobs", initializer=_lower_priority)
        self._devices = ThreadPoolExecutor(1, "device-jobs")
        self._has_stopped = False

    def submit(self, job: Callable[[], T]) -> "Future[T]":
        """Run a slow job after the jobs that wait already. After `stop` the job is cancelled."""
        return self._submit_to(self._pool, job)

    def _submit_to(self, pool: ThreadPoolExecutor, job: Callable[[], T]) -> "Future[T]":
        try:
            if not self._has_stopped:
                return pool.submit(job)
        except RuntimeError:
            if not self._has_stopped:  # otherwise another thread has just called `stop`
                raise
        left_out: Future[T] = Future()
        left_out.cancel()
        return left_out

    async def run(self, job: Callable[[], T]) -> T:
        """Run a slow job after the jobs that wait, and return its result; see `result_of`."""
        return await self.result_of(self.submit(job))

    async def run_on_device(self, job: Callable[[], T]) -> T:
        """Like `run`, for a job of a camera or a recording."""
        return await self.result_of(self._submit_to(self._devices, job))

    async def result_of(self, submitted: "Future[T]") -> T:
        """The result of a job. Raises StoppedError if `stop` has cancelled the job."""
        try:
            return await asyncio.wrap_future(submitted)
        except (asyncio.CancelledError, RuntimeError):
            if self._has_stopped:
                raise StoppedError(STOPPING) from None
            raise

    def stop(self) -> None:
        """Cancel the jobs that wait. Does not wait for a job that runs."""
        self._has_stopped = True
        for pool in (self._pool, self._devices):
            pool.shutdown(wait=False, cancel_futures=True)


def _lower_priority() -> None:
    """Lower the priority of this thread. Only Linux can do this for a single thread."""
    if sys.platform == "linux":
        os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), _NICE)
