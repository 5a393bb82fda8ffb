"""Tasks for child processes, which import them from here, and the ids of such processes."""

import os
import signal
import time

from makeup_video.pipeline import OutputError

FOR_EVER = 600.0  # s


def square(job, tick):
    tick(job)
    return job * job, os.getpid()


def die(job, tick):
    os.kill(os.getpid(), signal.SIGKILL)


def die_by(number, tick):
    os.kill(os.getpid(), number)


def hang_up(job, tick):
    """Closes all open files, such as the pipe to the main process, and goes on."""
    os.closerange(3, 256)
    time.sleep(FOR_EVER)


def die_twice(folder, tick):
    """Dies in the first two attempts; returns the number of attempts."""
    note = folder / "attempts"
    count = len(note.read_text()) + 1 if note.exists() else 1
    note.write_text("x" * count)
    if count < 3:
        os.kill(os.getpid(), signal.SIGKILL)
    return count


def divide(job, tick):
    return 1 / job


def run_out_of_memory(words, tick):
    raise RuntimeError(words) if words else MemoryError


def refuse_odd(job, tick):
    if job % 2:
        raise OutputError("no room")
    return job


def go_on(job, tick):
    while True:
        tick(0)
        time.sleep(0.01)


def ignore_stop_signals(job, tick):
    tick(1)
    for number in (signal.SIGINT, signal.SIGTERM):
        os.kill(os.getpid(), number)
    return "alive"


def wait_for_ever(note, tick):
    note.with_suffix(".new").write_text(f"{os.getpid()} {os.getppid()}")
    note.with_suffix(".new").rename(note)
    time.sleep(FOR_EVER)


def process_id(worker):
    """The process id of a ChildProcess; None while no process runs."""
    return None if worker._process is None else worker._process.pid
