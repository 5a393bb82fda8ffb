"""Blocks of sound -> one sequence of samples that keeps step with the clock of the pictures.

A sound card's clock differs from the computer's by up to 0.02 %: a tenth of a second in ten
minutes. Lost samples, or a source that begins late, shift the sound, too. So each block is
stretched or shortened by up to 0.4 %, which nobody hears, until the sound is in step again. Larger
gaps are filled with silence, and samples that come far too early for the sequence are cut out.
"""

from collections import deque
from collections.abc import Iterator

import numpy as np
from makeup_video.pipeline.live.sound import RATE, SoundBlock

# A block may arrive late but never early. So the earliest of all arrivals in this time shows when
# the samples were taken.
_WINDOW_SECONDS = 2.0
_CORRECTED_IN_SECONDS = 0.5  # stretching would remove a small error in this time
_MOST_STRETCH = 0.004
_GAP_SECONDS = 0.04  # a larger error is filled with silence or cut out; at the start, any error is
_LOST_SECONDS = 1.0  # if all blocks seem late for this long, samples were lost before them
_BEHIND_SECONDS = 0.5  # a source this far behind the pictures counts as silent


class SteadySound:
    """Turns blocks into one sequence, whose sample n belongs at `zero_seconds` + n / RATE.

    zero_seconds: when the first picture arrived, by time.monotonic().
    silent: number of samples of silence that were filled in.
    """

    def __init__(self, channels: int, zero_seconds: float) -> None:
        self._channels, self._zero = channels, zero_seconds
        self._in = 0  # number of samples that came in
        # A sliding minimum: (sample number, time of the source's sample 0 by this arrival) for the
        # arrivals that are the earliest, or may become so; both numbers increase.
        self._least: deque[tuple[int, float]] = deque()
        # (sample number, time of arrival) of the first block since which all blocks were late
        self._late_from: tuple[int, float] | None = None
        self.count = 0  # number of samples that went out
        self.silent = 0

    def add(self, block: SoundBlock) -> Iterator[np.ndarray]:
        """Yield the next samples of the sequence, (channels, N) float32; N may be 0.

        Long silence comes in parts of at most one second.
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
        """Yield silence, as `add` does, if the source is far behind this monotonic time."""
        behind = until_seconds - self._zero - self.count / RATE
        if behind > _BEHIND_SECONDS:
            yield from self._silence(round((behind - _BEHIND_SECONDS / 2) * RATE))

    def _begin_of(self, block: SoundBlock) -> float:
        """When the block's first sample was taken, judged by the earliest of the last arrivals."""
        if block.is_exact:
            return block.begins_seconds
        zero = block.begins_seconds - self._in / RATE
        if self._least and abs(zero - self._least[0][1]) > 1:
            self._least.clear()  # the source paused, or began another pass
        self._forget_what_was_lost(zero, block)
        while self._least and self._least[-1][1] >= zero:
            self._least.pop()
        self._least.append((self._in, zero))
        while self._least[0][0] < self._in - _WINDOW_SECONDS * RATE:
            self._least.popleft()
        return self._least[0][1] + self._in / RATE

    def _forget_what_was_lost(self, zero: float, block: SoundBlock) -> None:
        """Forget the arrivals from before a loss of samples, once the loss is certain.

        Late blocks alone prove no loss. When the reading thread did not run for a while, the blocks
        that waited arrive late and all at once, and then the lateness ends.
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
    """The samples, lengthened or shortened to remove part of the error, by linear interpolation."""
    count = samples.shape[1]
    wanted = error_seconds * count / _CORRECTED_IN_SECONDS
    most = _MOST_STRETCH * count
    more = round(min(max(wanted, -most), most))
    if not more or count < 2:
        return samples
    at = np.arange(count + more) * ((count - 1) / (count + more - 1))
    whole = np.arange(count)
    return np.stack([np.interp(at, whole, row) for row in samples]).astype(np.float32)
