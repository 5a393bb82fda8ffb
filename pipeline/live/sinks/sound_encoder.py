"""The sound of a live run -> audio packets of a recording or a stream."""

from collections.abc import Iterable, Iterator
from fractions import Fraction
from typing import Any

import av
import numpy as np
from makeup_video.pipeline.errors import EncodeError
from makeup_video.pipeline.live.sound import RATE, SoundTap
from makeup_video.pipeline.live.steady_sound import SteadySound

_ENCODERS = {"webm": "libopus"}  # other containers get AAC, which players and receivers know
_BITS_PER_CHANNEL = 80_000


class SoundEncoder:
    """An audio stream in `container`, to be made before anything is written there.

    zero_seconds: when the first picture arrived, by time.monotonic(): the time 0 of the sound.
    """

    def __init__(
        self,
        container: Any,
        format_name: str,
        tap: SoundTap,
        zero_seconds: float,
        *,
        global_header: bool = False,
    ) -> None:
        self._tap, self._steady = tap, SteadySound(tap.channels, zero_seconds)
        self._layout = "mono" if tap.channels == 1 else "stereo"
        self._encoder = _ENCODERS.get(format_name, "aac")
        self.stream = container.add_stream(self._encoder, rate=RATE)
        context = self.stream.codec_context
        context.layout, context.format = self._layout, "flt" if self._encoder != "aac" else "fltp"
        context.bit_rate = _BITS_PER_CHANNEL * tap.channels
        if global_header:
            context.flags |= av.codec.context.Flags.global_header

    @property
    def silent_seconds(self) -> float:
        """How much silence was filled in because no sound came."""
        return self._steady.silent / RATE

    def __call__(self, until_seconds: float) -> Iterator[Any]:
        """Encode the sound that has come, and silence if the source is far behind the pictures.

        until_seconds: when the newest picture arrived, by time.monotonic().  Raises EncodeError.
        """
        for block in self._tap.take():
            yield from self._encoded(self._steady.add(block))
        yield from self._encoded(self._steady.pad(until_seconds))

    def flush(self) -> Iterator[Any]:
        """Yield the packets of the samples that wait in the encoder. Raises EncodeError."""
        yield from self._packets(None)

    def _encoded(self, parts: Iterable[np.ndarray]) -> Iterator[Any]:
        for samples in parts:
            yield from self._encode(samples)

    def _encode(self, samples: np.ndarray) -> Iterator[Any]:
        count = samples.shape[1]
        if not count:
            return
        frame = av.AudioFrame.from_ndarray(np.ascontiguousarray(samples), "fltp", self._layout)
        frame.sample_rate, frame.time_base = RATE, Fraction(1, RATE)
        frame.pts = self._steady.count - count
        yield from self._packets(frame)

    def _packets(self, frame: av.AudioFrame | None) -> Iterator[Any]:
        try:
            yield from self.stream.encode(frame)
        except av.FFmpegError as error:
            raise EncodeError(f"{self._encoder} failed: {error.strerror}") from error


def sound_in_words(tap: SoundTap | None, encoder: SoundEncoder | None) -> str:
    """The words about an output's audio in the last line: its source, and how much is missing."""
    if tap is None:
        return ", without audio"
    missing = encoder.silent_seconds if encoder is not None else 0.0
    silent = f", of which {missing:.1f} s silent because nothing came" if missing >= 0.1 else ""
    return f", with audio from {tap.name}{silent}"
