"""Keeps the scheduling policy of threads while an encoder's library starts its own."""

import contextlib
import os
import sys
from collections.abc import Iterator
from typing import Any

_THREADS = "/proc/self/task"
_CALLER = 0  # for the system's functions: the calling thread


def open_encoder(context: Any) -> None:
    """Open PyAV's context of an encoder; the scheduling of threads stays as it was.

    Raises what `context.open` raises: av.FFmpegError or ValueError.
    """
    with same_scheduling():
        context.open(strict=False)


@contextlib.contextmanager
def same_scheduling() -> Iterator[None]:
    """Restore the calling thread's policy afterwards, for it and all threads started meanwhile.

    Where SVT-AV1 has the right (as root), it gives the thread that opens it and all of its own
    threads the real-time policy SCHED_FIFO at the highest priority. Later threads and processes
    would inherit that policy, and on a few cores such threads leave no time to others. Does nothing
    on systems other than Linux.
    """
    if sys.platform != "linux" or not os.path.isdir(_THREADS):
        yield
        return
    policy, priority = os.sched_getscheduler(_CALLER), os.sched_getparam(_CALLER)
    before = _threads()
    try:
        yield
    finally:
        for thread in {_CALLER} | (_threads() - before):
            with contextlib.suppress(OSError):  # it has ended
                os.sched_setscheduler(thread, policy, priority)


def _threads() -> set[int]:
    return {int(name) for name in os.listdir(_THREADS)}
