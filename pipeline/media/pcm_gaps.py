"""Silence in place of gaps in PCM sound, for containers that count its samples.

mp4 and mov give PCM no times: a gap would move all that follows to an earlier time.
"""

import re
from collections.abc import Iterator
from fractions import Fraction
from typing import Any

import av

_LEAST_SECONDS = Fraction(1, 20)  # a shorter gap is the rounding of some container's clock
_AT_ONCE_SECONDS = 1
_LINEAR = re.compile(r"pcm_(s|u|f)(\d+)[lb]?e?$")


class FillPcmGaps:
    """A packet -> that packet, after silence for the time since the last one.

    stream: of the source; see `has_pcm`.
    """

    def __init__(self, stream: Any) -> None:
        kind, bits = _LINEAR.match(stream.name).groups()  # type: ignore[union-attr]
        self._rate = stream.codec_context.sample_rate
        self._bytes = int(bits) // 8 * stream.codec_context.layout.nb_channels
        middle = 0x80 if kind == "u" and bits == "8" else 0
        self._silence = bytes([middle]) * (self._bytes * self._rate * _AT_ONCE_SECONDS)
        self._end: Fraction | None = None

    def __call__(self, packet: Any) -> Iterator[Any]:
        if packet.pts is None:
            yield packet
            return
        begins = packet.pts * packet.time_base
        if self._end is not None and begins - self._end > _LEAST_SECONDS:
            yield from self._silent(packet, self._end, begins)
        self._end = begins + Fraction(packet.size // self._bytes, self._rate)
        yield packet

    def _silent(self, packet: Any, begins: Fraction, ends: Fraction) -> Iterator[Any]:
        left = round((ends - begins) * self._rate)
        while left > 0:
            samples = min(left, len(self._silence) // self._bytes)
            silent = av.Packet(self._silence[: samples * self._bytes])
            silent.stream, silent.time_base = packet.stream, packet.time_base
            silent.pts = silent.dts = round(begins / packet.time_base)
            silent.duration = round(Fraction(samples, self._rate) / packet.time_base)
            silent.is_keyframe = True
            yield silent
            left, begins = left - samples, begins + Fraction(samples, self._rate)


def has_pcm(stream: Any) -> bool:
    """True for sound whose samples are stored as they are."""
    return stream.type == "audio" and _LINEAR.match(str(stream.name)) is not None
