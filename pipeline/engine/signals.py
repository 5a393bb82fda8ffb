"""The signals that stop a run, and ways to hold them back until a step is complete.

The command imports this module before anything else, so the module needs only the standard library.
"""

import signal
import threading
from collections.abc import Generator
from contextlib import contextmanager
from typing import Any

_NAMES = ("SIGINT", "SIGTERM", "SIGHUP")  # Ctrl-C, a supervisor, a terminal that is closed


def stop_signals() -> list[signal.Signals]:
    """The signals that end a run on this system.

    Signals that this process was started to ignore, as by nohup, are not among them, nor are those
    that a host program handles outside Python, whose handlers could not be restored.
    """
    known = [signal.Signals[name] for name in _NAMES if hasattr(signal, name)]  # Windows: no SIGHUP
    return [number for number in known if signal.getsignal(number) not in (signal.SIG_IGN, None)]


@contextmanager
def undisturbed() -> Generator[None, None, None]:
    """Ignore stop signals within the block: a second Ctrl-C must not break off the clean end."""
    with _stop_signals_go_to(signal.SIG_IGN):
        yield


@contextmanager
def interrupted_later() -> Generator[None, None, None]:
    """Hold a Ctrl-C back until the block ends, so that the block is done as a whole."""
    received: list[int] = []
    with _stop_signals_go_to(lambda number, _: received.append(number)):
        yield
    if received:
        raise KeyboardInterrupt


@contextmanager
def _stop_signals_go_to(handler: Any) -> Generator[None, None, None]:
    """Set the handler within the block. Other threads than the main one receive no signals."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return
    before = {number: signal.signal(number, handler) for number in stop_signals()}
    try:
        yield
    finally:
        for number, handler_before in before.items():
            signal.signal(number, handler_before)
