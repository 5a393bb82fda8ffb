"""The one thread for what takes its time: reading photos, painting portraits, writing PNG files.

It runs at low priority, so that pictures of a camera go first; one job at a time bounds its memory.
"""

import asyncio
import os
import sys
import threading
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from typing import TypeVar

_NICE = 10
T = TypeVar("T")


class Worker:
    def __init__(self) -> None:
        self._pool = ThreadPoolExecutor(1, "worker", initializer=_step_back)

    def submit(self, job: Callable[[], object]) -> "Future[object]":
        """Do this after what waits already."""
        return self._pool.submit(job)

    async def run(self, job: Callable[[], T]) -> T:
        """The same, and wait for what comes out of it."""
        return await asyncio.wrap_future(self._pool.submit(job))

    def stop(self) -> None:
        """Do nothing more; what is being done is not waited for."""
        self._pool.shutdown(wait=False, cancel_futures=True)


def _step_back() -> None:
    """Only on Linux is priority a matter of threads."""
    if sys.platform == "linux":
        os.setpriority(os.PRIO_PROCESS, threading.get_native_id(), _NICE)
