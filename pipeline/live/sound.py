"""The sound of a live run: one source, on a thread of its own, for every sink that wants sound."""

import threading
from collections import deque
from collections.abc import Callable, Generator
from dataclasses import dataclass
from typing import Protocol

import numpy as np
from makeup_video.pipeline.errors import MakeupVideoError

RATE = 48_000  # samples per second of every source
_KEPT_SECONDS = 10.0  # kept for a sink that takes no sound now, such as while the camera is gone


@dataclass(frozen=True, slots=True, eq=False)
class SoundBlock:
    """A piece of sound.

    samples: (channels, N) float32, -1..1, at RATE.
    begins_seconds: when the first sample was taken, by time.monotonic().
    is_exact: the time is exact; otherwise it was measured on arrival, and may be late.
    """

    samples: np.ndarray
    begins_seconds: float
    is_exact: bool = False


class SoundSource(Protocol):
    """Where the sound of a live run comes from."""

    name: str  # for messages
    channels: int  # 1 or 2

    def blocks(self) -> Generator[SoundBlock, None, None]:
        """Yield each block when it arrives. Called once."""
        ...

    def close(self) -> None:
        """End `blocks`. May be called from any thread, and repeatedly."""
        ...


class SoundTap:
    """The blocks that have come since one sink last took them.

    on_close: called once, when the tap is closed.
    """

    def __init__(
        self, name: str, channels: int, on_close: Callable[[], None] | None = None
    ) -> None:
        self.name, self.channels, self._on_close = name, channels, on_close
        self._blocks: deque[SoundBlock] = deque()
        self._lock = threading.Lock()
        self.is_closed = False

    def close(self) -> None:
        """Take no more blocks."""
        if self.is_closed:
            return
        self.is_closed = True
        self.take()
        if self._on_close is not None:
            self._on_close()

    def put(self, block: SoundBlock) -> None:
        if self.is_closed:
            return
        with self._lock:
            self._blocks.append(block)
            while block.begins_seconds - self._blocks[0].begins_seconds > _KEPT_SECONDS:
                self._blocks.popleft()

    def take(self) -> list[SoundBlock]:
        with self._lock:
            blocks = list(self._blocks)
            self._blocks.clear()
        return blocks


class LiveSound:
    """Reads a source from `start` until `close`, and hands every block to all taps.

    log: called with a line of text when the source fails; the pictures go on.
    while_tapped: close the source when the last tap is closed, as a microphone needs.
    """

    def __init__(
        self, source: SoundSource, log: Callable[[str], None], *, while_tapped: bool = False
    ) -> None:
        self._source, self._log, self._while_tapped = source, log, while_tapped
        self._taps: list[SoundTap] = []
        self._tapping = threading.Lock()
        self._is_closing = False
        self._thread = threading.Thread(target=self._run, name="makeup-sound", daemon=True)

    @property
    def name(self) -> str:
        return self._source.name

    def tap(self) -> SoundTap | None:
        """Make a tap for a further sink; None once the sound is over.

        May be called while the sound runs.
        """
        tap = SoundTap(self._source.name, self._source.channels, self._tap_closed)
        with self._tapping:
            if self.is_over:
                return None
            # a new list, since the thread iterates over the old one
            self._taps = [*(one for one in self._taps if not one.is_closed), tap]
        return tap

    @property
    def is_over(self) -> bool:
        """True once there will be no more sound."""
        return self._is_closing or bool(self._thread.ident and not self._thread.is_alive())

    def start(self) -> None:
        self._thread.start()

    def close(self) -> None:
        """End the thread; a read that hangs stays behind on its daemon thread."""
        self._is_closing = True
        self._source.close()
        if self._thread.is_alive():
            self._thread.join(1)

    def _tap_closed(self) -> None:
        with self._tapping:
            if not (self._while_tapped and all(tap.is_closed for tap in self._taps)):
                return
            self._is_closing = True
        self._source.close()

    def _run(self) -> None:
        try:
            for block in self._source.blocks():
                for tap in self._taps:
                    tap.put(block)
        except Exception as error:  # noqa: BLE001  # odd sound may make a library raise anything
            if not self._is_closing:
                what = str(error)
                if not isinstance(error, MakeupVideoError):  # a library's error names no source
                    what = f"{self.name} cannot be heard ({type(error).__name__}: {error})"
                self._log(f"{what}; the video continues without audio")
