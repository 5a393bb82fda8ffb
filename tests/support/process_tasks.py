"""Tasks for processes, which import them from here."""

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


def refuse(job, tick):
    if job == 1:
        raise OutputError("no room")
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
