"""Processes of our own that do jobs, one after the other."""

import multiprocessing
import os
import signal
import threading
import traceback
from collections.abc import Callable
from multiprocessing.connection import Connection, wait
from typing import Any, NamedTuple

from makeup_video.pipeline.engine.jobs import WAS_STOPPED, Job, Progress, Result, Task
from makeup_video.pipeline.engine.machine import return_large_blocks
from makeup_video.pipeline.engine.out_of_memory import is_out_of_memory
from makeup_video.pipeline.engine.signals import stop_signals
from makeup_video.pipeline.errors import (
    MakeupVideoError,
    StoppedError,
    TooLittleMemoryError,
    UsageError,
    WorkerError,
    option,
)

# a fork would copy locks of threads and of OpenCL
_START = multiprocessing.get_context("spawn")
_SOON_SECONDS = 5.0
_NO_MEMORY = (
    f"there is not enough memory for this job: lower {option('jobs')}, close other programs, or "
    "raise the limit (ulimit -v, the container's)"
)


class InProgress(NamedTuple):
    """What a task reports while it does a job."""

    progress: Any


class Ended(NamedTuple):
    """The result of a task, or the error that ended it."""

    result: Any = None
    error: MakeupVideoError | None = None
    trace: str = ""  # of an error that is not ours

    def value(self) -> Any:
        """The result. Raises the error."""
        if self.error is None:
            return self.result
        if self.trace:
            self.error.add_note(self.trace)
        raise self.error


class _Died(Exception):
    """The process ended before its job.

    serves_never: every other process that this program starts would die as well.
    """

    serves_never = False


class ChildProcess:
    """A worker that does jobs in a process of its own, so that a crash ends one job alone.

    The process starts with the first job, and again after a crash.
    attempts: how often a job is tried in all, when its process dies.
    """

    per_machine: int | None = None

    def __init__(self, attempts: int = 1) -> None:
        self._attempts = attempts
        self._process: Any = None
        self._pipe: Any = None
        self._stopped = False

    def run(
        self, task: Task[Job, Progress, Result], job: Job, report: Callable[[Progress], None]
    ) -> Result:
        """See Worker."""
        if self._stopped:
            raise UsageError(WAS_STOPPED)
        died: WorkerError | None = None
        for _ in range(self._attempts):
            try:
                if self._process is None:
                    self._start()
                result: Result = self._once(task, job, report).value()
                return result
            except _Died as error:
                if self._stopped:
                    raise StoppedError from None
                died = WorkerError(str(error))
                if error.serves_never:
                    break
        assert died is not None
        raise died

    def _once(self, task: Any, job: Any, report: Callable[[Any], None]) -> Ended:
        try:
            self._pipe.send((task, job))
            while isinstance(message := self._pipe.recv(), InProgress):
                report(message.progress)
        except (EOFError, OSError):
            raise _Died(self._why_it_died()) from None
        ended: Ended = message
        return ended

    def stop(self) -> None:
        """End the process at once. Any thread may call this."""
        self._stopped = True
        if (process := self._process) is not None:
            process.kill()
            process.join(_SOON_SECONDS)

    def _start(self) -> None:
        self._pipe, other = _START.Pipe()
        process = _START.Process(target=_serve, args=(other,), daemon=True)
        process.start()
        self._process = process
        other.close()  # else reading from the pipe would not notice the end of the process
        if self._stopped:  # by another thread in the meantime
            process.kill()
        try:
            self._pipe.recv()  # the process reports that it is ready
        except (EOFError, OSError):
            died = _Died(self._why_it_died())
            if (process.exitcode or 0) > 0:  # an error, such as that it started processes itself
                died = _Died(
                    f"a process that paints ended with exit code {process.exitcode} before it "
                    "began: see the error above, and in a script put the call under "
                    '`if __name__ == "__main__":`'
                )
                died.serves_never = True
            raise died from None

    def _why_it_died(self) -> str:
        process, self._process = self._process, None
        process.join(_SOON_SECONDS)
        code = process.exitcode
        times = f", in each of {self._attempts} attempts" if self._attempts > 1 else ""
        if code is None:
            process.kill()
            process.join(_SOON_SECONDS)
            return f"the painting process stopped answering and was ended{times}"
        if code < 0:
            name = _signal_name(-code)
            memory = ", perhaps because memory ran out" if name == "SIGKILL" else ""
            return f"the painting process was ended by {name}{times}{memory}"
        return f"the painting process ended with exit code {code}{times}"


def _signal_name(number: int) -> str:
    try:
        return signal.Signals(number).name
    except ValueError:  # most real-time signals have no name
        return f"signal {number}"


def perform(task: Task[Any, Any, Any], job: Any, send: Callable[[InProgress], None]) -> Ended:
    """Do a job in this process. An error that is not ours becomes a WorkerError, or a
    TooLittleMemoryError where memory ran out."""
    try:
        return Ended(task(job, lambda progress: send(InProgress(progress))))
    except MakeupVideoError as error:
        return Ended(None, error)
    except Exception as error:  # noqa: BLE001  # one line for whoever waits for the result
        if is_out_of_memory(error):
            return Ended(None, TooLittleMemoryError(_NO_MEMORY), traceback.format_exc())
        text = (
            f"internal error: {type(error).__name__}: {error}; "
            f"run this job alone with {option('debug')}"
        )
        return Ended(None, WorkerError(text), traceback.format_exc())


def _serve(pipe: Connection) -> None:
    """Do every job that comes through the pipe; ends with the process that started this one."""
    pipe.send(None)
    return_large_blocks()
    for number in stop_signals():  # they reach the terminal's whole group: the main process decides
        signal.signal(number, signal.SIG_IGN)
    parent = multiprocessing.parent_process()
    assert parent is not None
    threading.Thread(target=_end_with, args=(parent.sentinel,), daemon=True).start()
    while True:
        try:
            task, job = pipe.recv()
        except EOFError:
            return
        pipe.send(perform(task, job, pipe.send))


def _end_with(sentinel: int) -> None:
    """End this process when the one that started it is gone: another run may take its work."""
    wait([sentinel])
    os._exit(1)
