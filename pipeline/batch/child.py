"""A process of our own that does jobs, one after the other."""

import multiprocessing
import os
import signal
import threading
from collections.abc import Callable
from multiprocessing.connection import Connection, wait
from typing import Any

from makeup_video.pipeline.batch.job import Failed, Job, JobProgress, Result, run_job
from makeup_video.pipeline.errors import MakeupVideoError, StoppedError, WorkerError

_START = multiprocessing.get_context("spawn")  # a fork would copy locks of threads and of OpenCL
_SOON_SECONDS = 5.0


class ChildProcess:
    """Does jobs in a process of its own, so that a crash ends one job and not the batch.

    The process starts with the first job, and again after a crash. One thread at a time may use it.
    """

    def __init__(self) -> None:
        self._process: Any = None
        self._pipe: Any = None
        self._stopped = False

    @property
    def process_id(self) -> int | None:
        """The system's number of the process; None while there is none."""
        return None if self._process is None else self._process.pid

    def run(self, job: Job, report: Callable[[JobProgress], None]) -> list[Result]:
        """As run_job. When the process dies, every look has failed with a WorkerError.

        Raises StoppedError after `stop`.
        """
        if self._process is None:
            self._start()
        try:
            self._pipe.send(job)
            while isinstance(message := self._pipe.recv(), JobProgress):
                report(message)
        except (EOFError, OSError):
            error = self._why_it_died()
            if self._stopped:
                raise StoppedError("stopped by the user") from None
            return [Failed(one.output, error) for one in job.looks]
        if isinstance(message, str):
            error = WorkerError(f"internal error: {message}; run this job alone with --debug")
            return [Failed(one.output, error) for one in job.looks]
        results: list[Result] = message
        return results

    def stop(self) -> None:
        """End the process at once. Any thread may call this."""
        self._stopped = True
        if (process := self._process) is not None:
            process.kill()
            process.join(_SOON_SECONDS)

    def _start(self) -> None:
        self._pipe, other = _START.Pipe()
        self._process = _START.Process(target=_serve, args=(other,), daemon=True)
        self._process.start()
        other.close()  # else the end of the process would not show

    def _why_it_died(self) -> MakeupVideoError:
        process, self._process = self._process, None
        process.join(_SOON_SECONDS)
        code = process.exitcode
        if code is not None and code < 0:
            name = signal.Signals(-code).name
            memory = ", perhaps because memory ran out" if name == "SIGKILL" else ""
            return WorkerError(f"the process that painted it was ended by {name}{memory}")
        return WorkerError(f"the process that painted it ended with exit code {code}")


def _serve(pipe: Connection) -> None:
    """Do every job that comes through the pipe; ends with the process that started this one."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)  # Ctrl-C reaches all: the batch ends this process
    parent = multiprocessing.parent_process()
    assert parent is not None
    threading.Thread(target=_end_with, args=(parent.sentinel,), daemon=True).start()
    while True:
        try:
            job: Job = pipe.recv()
        except EOFError:
            return
        try:
            pipe.send(run_job(job, pipe.send))
        except Exception as error:  # noqa: BLE001  # one line in the list of what failed
            pipe.send(f"{type(error).__name__}: {error}")


def _end_with(sentinel: int) -> None:
    """End this process when the one that started it is gone: another batch may take its work."""
    wait([sentinel])
    os._exit(1)
