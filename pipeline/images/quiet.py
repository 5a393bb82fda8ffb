"""Keeps libraries quiet about damaged pictures: our errors say in one line what is wrong."""

import threading
import warnings
from collections.abc import Callable

Undo = Callable[[], object]


class Quiet:
    """Changes a setting of the whole process while any thread is in a `with` block of it.

    begin: makes the change, and returns how to undo it. A thread that saved and restored the
    setting by itself might restore what another thread had changed.
    """

    def __init__(self, begin: Callable[[], Undo]) -> None:
        self._begin = begin
        self._lock = threading.Lock()
        self._blocks = 0  # that have not ended
        self._undo: Undo = int

    def __enter__(self) -> None:
        with self._lock:
            if not self._blocks:
                self._undo = self._begin()
            self._blocks += 1

    def __exit__(self, *_: object) -> None:
        with self._lock:
            self._blocks -= 1
            if not self._blocks:
                self._undo()


def _ignore_warnings() -> Undo:
    block = warnings.catch_warnings()
    block.__enter__()
    warnings.simplefilter("ignore")
    return lambda: block.__exit__(None, None, None)


def _silence_opencv() -> Undo:
    import cv2  # late: videos do not need it here

    before = cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)
    return lambda: cv2.utils.logging.setLogLevel(before)


without_warnings = Quiet(_ignore_warnings)
silent_opencv = Quiet(_silence_opencv)
