"""Lets the clock of an MPEG stream go on where it jumps.

Recordings of broadcasts that were joined byte by byte, and streams that were interrupted, have a
clock that begins anew. All streams of the file jump by as much, each at its own place between the
packets of the others.
"""

from fractions import Fraction
from typing import Any

from makeup_video.pipeline.media.input_file import VideoSource

BACK_SECONDS, AHEAD_SECONDS = 1, 10  # from where on a step is a jump: FFmpeg's step ahead


class ClockJumps:
    """Moves packets, in the order of the file, so that none begins before another one's jump.

    jumps: of each jump its time on the mended clock, and by how much what follows moves, seconds.
    """

    def __init__(self, source: VideoSource) -> None:
        self.jumps: list[tuple[Fraction, Fraction]] = []
        self._is_free = source.has_free_clock
        self._met: dict[int, int] = {}  # of each stream, the jumps that it has made
        self._ends: dict[int, Fraction] = {}  # of each stream, on the mended clock, in seconds

    def __call__(self, packet: Any) -> None:
        """Move a packet in place."""
        if not self._is_free or packet.dts is None:
            return
        index, base = packet.stream.index, packet.time_base
        time = packet.dts * base + self._moved(index)
        end = self._ends.get(index)
        if end is not None and is_jump(time - end):
            met = self._met[index] = self._met.get(index, 0) + 1
            if met > len(self.jumps):  # no other stream has jumped yet
                now = max(self._ends.values())
                self.jumps.append((now, now - packet.dts * base))
        ticks = round(self._moved(index) / base)
        packet.dts += ticks
        if packet.pts is not None:
            packet.pts += ticks
        self._ends[index] = (packet.dts + (packet.duration or 0)) * base

    def _moved(self, index: int) -> Fraction:
        met = self._met.get(index, 0)
        return self.jumps[met - 1][1] if met else Fraction(0)


def is_jump(step_seconds: Fraction) -> bool:
    """Whether a step between the decoding times of a stream is a jump of its clock."""
    return not -BACK_SECONDS < step_seconds < AHEAD_SECONDS
