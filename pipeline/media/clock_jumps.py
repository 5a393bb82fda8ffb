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
        # both of these before the last packet, where that was the first behind a jump
        self._before: dict[int, tuple[int, Fraction]] = {}

    def __call__(self, packet: Any) -> None:
        """Move a packet in place."""
        time = packet.pts if packet.dts is None else packet.dts
        if not self._is_free or time is None:
            return
        base, stream = packet.time_base, packet.stream
        if stream.type in ("audio", "video"):
            met = self._met[stream.index] = self._met_by(stream.index, time * base)
        else:  # too few packets to show a jump: they are moved as sound and picture are
            met = max(self._met.values(), default=0)
        ticks = round(self._moved(met) / base)
        if packet.dts is not None:
            packet.dts += ticks
        if packet.pts is not None:
            packet.pts += ticks
        self._ends[stream.index] = (time + ticks + (packet.duration or 0)) * base

    def _met_by(self, index: int, seconds: Fraction) -> int:
        """How many jumps a stream has made up to a packet of this time on the file's clock."""
        met, end = self._met.get(index), self._ends.get(index)
        if met is None or end is None:
            return max(self._met.values(), default=0)  # a stream that begins behind a jump
        before = self._before.pop(index, None)
        if before is not None and abs(seconds + self._moved(before[0]) - before[1]) < BACK_SECONDS:
            met, end = before  # one packet was astray, and no clock has jumped
            if all(others <= met for at, others in self._met.items() if at != index):
                del self.jumps[met:]
        for known in range(met, len(self.jumps) + 1):
            if not is_jump(seconds + self._moved(known) - end):
                break
        else:  # no other stream has jumped yet
            known = len(self.jumps) + 1
            now = max(self._ends.values())
            self.jumps.append((now, now - seconds))
        if known > met:
            self._before[index] = met, end
        return known

    def _moved(self, met: int) -> Fraction:
        return self.jumps[met - 1][1] if met else Fraction(0)


def is_jump(step_seconds: Fraction) -> bool:
    """Whether a step between the decoding times of a stream is a jump of its clock."""
    return not -BACK_SECONDS < step_seconds < AHEAD_SECONDS
