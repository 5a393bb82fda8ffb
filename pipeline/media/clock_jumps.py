"""Lets the clock of an MPEG stream go on where it jumps back.

Recordings of broadcasts that were joined byte by byte, and streams that were interrupted, have a
clock that begins anew. All streams of the file jump by as much, each at its own place between the
packets of the others.
"""

from fractions import Fraction
from typing import Any

from makeup_video.pipeline.media.input_file import VideoSource

BACK_SECONDS = 1  # from where on a step back is a jump, and no disorder of packets
# From where on a step ahead is one: FFmpeg takes a clock that says a minute less than the file's
# first time for one that has passed the largest time, 26.5 hours.
AHEAD_SECONDS = 12 * 3600


class ClockJumps:
    """Moves packets, in the order of the file, so that their clock never jumps back.

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
        base, stream = packet.time_base, packet.stream
        if stream.type in ("audio", "video"):
            met = self._met_by(stream.index, packet.dts * base)
        else:  # too few packets to show a jump: they are moved as sound and picture are
            met = max(self._met.values(), default=0)
        ticks = round(self._moved(met) / base)
        packet.dts += ticks
        if packet.pts is not None:
            packet.pts += ticks
        self._ends[stream.index] = (packet.dts + (packet.duration or 0)) * base

    def _met_by(self, index: int, seconds: Fraction) -> int:
        """How many jumps a stream has made up to a packet of this time on the file's clock."""
        met, end = self._met.get(index, 0), self._ends.get(index)
        if end is not None and is_jump(seconds + self._moved(met) - end):
            met += 1
            if met > len(self.jumps):  # no other stream has jumped yet
                now = max(self._ends.values())
                self.jumps.append((now, now - seconds))
        self._met[index] = met
        return met

    def _moved(self, met: int) -> Fraction:
        return self.jumps[met - 1][1] if met else Fraction(0)


def is_jump(step_seconds: Fraction) -> bool:
    """Whether a step between the decoding times of a stream is a jump of its clock."""
    return not -BACK_SECONDS < step_seconds < AHEAD_SECONDS
