"""Signals that stop a run: which there are, and holding them back until a step is done."""

import signal
import threading
from collections.abc import Generator
from contextlib import contextmanager
from typing import Any


def stop_signals() -> list[signal.Signals]:
    """Those that end a run: Ctrl-C, a supervisor's, a closed terminal's. What is ignored stays so: nohup."""
    names = ("SIGINT", "SIGTERM", "SIGHUP")  # Windows has no SIGHUP
    there = [signal.Signals[name] for name in names if name in signal.Signals.__members__]
    return [each for each in there if signal.getsignal(each) is not signal.SIG_IGN]


@contextmanager
def undisturbed() -> Generator[None, None, None]:
    """A second Ctrl-C does not keep the sink from finishing what the first one ended."""
    with _stop_signals_go_to(signal.SIG_IGN):
        yield


@contextmanager
def interrupted_later() -> Generator[None, None, None]:
    """A Ctrl-C within the block counts when it ends: what must be done as a whole is."""
    came: list[int] = []
    with _stop_signals_go_to(lambda *_: came.append(1)):
        yield
    if came:
        raise KeyboardInterrupt


@contextmanager
def _stop_signals_go_to(handler: Any) -> Generator[None, None, None]:
    """Within the block; only on the main thread, which alone hears them."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = {name: signal.signal(name, handler) for name in stop_signals()}
    try:
        yield
    finally:
        for name, was in before.items():
            signal.signal(name, was)
