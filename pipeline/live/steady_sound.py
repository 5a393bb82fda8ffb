"""Blocks of sound -> one sequence of samples that keeps step with the clock of the pictures.

A sound card's clock differs from the computer's by up to 0.02 %: a tenth of a second in ten
minutes. Samples that are lost, or a source that begins late, shift the sound, too. So each block is
stretched by up to 0.4 %, which nobody hears, until its samples stand where the clock wants them.
Larger gaps are filled with silence, and what lies before the sequence is left out.
"""

from collections import deque
from collections.abc import Iterator

import numpy as np
from makeup_video.pipeline.live.sound import RATE, SoundBlock

# A block arrives late now and then, and never early. So of all arrivals in this time the earliest
# shows when the samples were taken.
_WINDOW_SECONDS = 2.0
_CORRECTED_IN_SECONDS = 0.5  # how fast a small error is stretched away
_MOST_STRETCH = 0.004
_GAP_SECONDS = 0.04  # a larger error is filled with silence or cut out, as is any at the start
_LOST_SECONDS = 1.0  # arrivals that are late for so long are not late: samples were lost before
_BEHIND_SECONDS = 0.5  # a source this far behind the pictures counts as silent


class SteadySound:
    """Makes samples of blocks; sample n belongs at `zero_seconds` + n / RATE.

    zero_seconds: of time.monotonic(), when the first picture arrived.
    silent: number of samples that were filled in.
    """

    def __init__(self, channels: int, zero_seconds: float) -> None:
        self._channels, self._zero = channels, zero_seconds
        self._in = 0  # samples that have come
        # (sample number, time of the source's sample 0) of those arrivals that are, or may become,
        # the earliest; times increase
        self._least: deque[tuple[int, float]] = deque()
        # (sample number, time of arrival) from which on all blocks came late
        self._late_from: tuple[int, float] | None = None
        self.count = 0  # samples that went out
        self.silent = 0

    def add(self, block: SoundBlock) -> Iterator[np.ndarray]:
        """Yield the next samples of the sequence, (channels, N) float32; N may be 0.

        Silence comes in parts of a second, however long it is.
        """
        samples = block.samples
        error = self._begin_of(block) - (self._zero + self.count / RATE)
        self._in += samples.shape[1]
        gap = _GAP_SECONDS if self.count else 0.0
        if error > gap:
            yield from self._silence(round(error * RATE))
            yield self._out(samples)
        elif error < -gap:
            yield self._out(samples[:, min(round(-error * RATE), samples.shape[1]) :])
        else:
            yield self._out(_stretched(samples, error))

    def pad(self, until_seconds: float) -> Iterator[np.ndarray]:
        """Yield silence, as `add` does, where the source is far behind that monotonic time."""
        behind = until_seconds - self._zero - self.count / RATE
        if behind > _BEHIND_SECONDS:
            yield from self._silence(round((behind - _BEHIND_SECONDS / 2) * RATE))

    def _begin_of(self, block: SoundBlock) -> float:
        """When the block's first sample was taken, by the earliest of the last arrivals."""
        if block.is_exact:
            return block.begins_seconds
        zero = block.begins_seconds - self._in / RATE
        if self._least and abs(zero - self._least[0][1]) > 1:
            self._least.clear()  # the source paused, or plays another pass
        self._forget_what_was_lost(zero, block)
        while self._least and self._least[-1][1] >= zero:
            self._least.pop()
        self._least.append((self._in, zero))
        while self._least[0][0] < self._in - _WINDOW_SECONDS * RATE:
            self._least.popleft()
        return self._least[0][1] + self._in / RATE

    def _forget_what_was_lost(self, zero: float, block: SoundBlock) -> None:
        """Leave out the arrivals from before a loss of samples, once it is one.

        After a thread that did not run for a while, the blocks that waited arrive at once.
        """
        if not self._least or zero - self._least[0][1] <= _GAP_SECONDS:
            self._late_from = None
            return
        arrived = block.begins_seconds + block.samples.shape[1] / RATE
        if self._late_from is None:
            self._late_from = self._in, arrived
        first, since = self._late_from
        if arrived - since > _LOST_SECONDS:
            while self._least and self._least[0][0] < first:
                self._least.popleft()
            self._late_from = None

    def _silence(self, count: int) -> Iterator[np.ndarray]:
        for begin in range(0, count, RATE):
            part = min(RATE, count - begin)
            self.silent += part
            yield self._out(np.zeros((self._channels, part), np.float32))

    def _out(self, samples: np.ndarray) -> np.ndarray:
        self.count += samples.shape[1]
        return samples


def _stretched(samples: np.ndarray, error_seconds: float) -> np.ndarray:
    """Samples made more or fewer by a part of an error, by linear interpolation."""
    count = samples.shape[1]
    wanted = error_seconds * count / _CORRECTED_IN_SECONDS
    most = _MOST_STRETCH * count
    more = round(min(max(wanted, -most), most))
    if not more or count < 2:
        return samples
    at = np.arange(count + more) * ((count - 1) / (count + more - 1))
    whole = np.arange(count)
    return np.stack([np.interp(at, whole, row) for row in samples]).astype(np.float32)
