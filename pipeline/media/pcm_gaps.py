"""Fills gaps in PCM sound with silence, for containers that only count its samples.

mp4 and mov store no times for PCM, so a gap would make all later sound play too early.
"""

import re
from collections.abc import Iterator
from fractions import Fraction
from typing import Any

import av

_LEAST_SECONDS = Fraction(1, 20)  # shorter ones may be the rounding of some container's clock
_LINEAR = re.compile(r"pcm_[suf](\d+)[lb]?e?$")
_IN_MP4 = ("ipcm", "fpcm")  # mp4's names for PCM (ISO/IEC 23003-5); mov has others
_LOGARITHMIC = {"pcm_alaw": 0xD5, "pcm_mulaw": 0xFF}  # silence in a byte (ITU-T G.711)


class FillPcmGaps:
    """Yields each packet, after silence where it begins more than 1/20 s after all written before.

    stream: the source's stream; see `has_pcm`.
    """

    def __init__(self, stream: Any) -> None:
        linear = _LINEAR.match(stream.name)
        width = int(linear[1]) // 8 if linear else 1
        self._middle = 0x80 if stream.name == "pcm_u8" else _LOGARITHMIC.get(stream.name, 0)
        self._rate = stream.codec_context.sample_rate
        self._bytes = width * stream.codec_context.layout.nb_channels
        self._end: Fraction | None = None

    def __call__(self, packet: Any) -> Iterator[Any]:
        if packet.pts is None:
            yield packet
            return
        begins = packet.pts * packet.time_base
        if self._end is None:
            self._end = begins
        elif begins - self._end > _LEAST_SECONDS:
            yield from self._silent(packet, self._end, begins)
            self._end = begins
        self._end += Fraction(packet.size // self._bytes, self._rate)
        yield packet

    def _silent(self, packet: Any, begins: Fraction, ends: Fraction) -> Iterator[Any]:
        left = round((ends - begins) * self._rate)
        while left > 0:
            samples = min(left, self._rate)  # at most a second per packet
            silent = av.Packet(bytes([self._middle]) * (samples * self._bytes))
            silent.time_base = packet.time_base
            silent.pts = silent.dts = round(begins / packet.time_base)
            silent.duration = round(Fraction(samples, self._rate) / packet.time_base)
            silent.is_keyframe = True
            yield silent
            left, begins = left - samples, begins + Fraction(samples, self._rate)


def has_pcm(stream: Any) -> bool:
    """True for sound whose samples are stored as they are."""
    name = str(stream.name)
    return stream.type == "audio" and (name in _LOGARITHMIC or _LINEAR.match(name) is not None)


def is_pcm_of_mp4(stream: Any) -> bool:
    """True for PCM with mp4's names: whoever has such a file presumably has a player for it."""
    return stream.codec_context.codec_tag in _IN_MP4
