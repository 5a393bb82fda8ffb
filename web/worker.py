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


class Worker:
    """Runs jobs one after another on one thread."""

    def __init__(self) -> None:
        self._pool = ThreadPoolExecutor(1, "worker", initializer=_lower_priority)
        self._has_stopped = False

    def submit(self, job: Callable[[], object]) -> "Future[object]":
        """Run a job after those that wait. After `stop` the job is cancelled."""
        if self._has_stopped:
            left_out: Future[object] = Future()
            left_out.cancel()
            return left_out
        return self._pool.submit(job)

    async def run(self, job: Callable[[], T]) -> T:
        """Run a job after those that wait, and return its result.

        Raises StoppedError for a job that `stop` has left out.
        """
        if self._has_stopped:
            raise StoppedError("makeup-video is stopping")
        try:
            return await asyncio.wrap_future(self._pool.submit(job))
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
