"""Mends the clock of an MPEG stream that jumps, so that its times go on.

Where recordings of broadcasts were joined byte by byte, or a stream was interrupted, the clock
begins anew. All streams of the file jump by the same amount, each at its own place among the
interleaved packets.
"""

from fractions import Fraction
from typing import Any

from makeup_video.pipeline.media.input_file import VideoSource

_BACK_SECONDS = 1  # a smaller step back comes from packets that are out of order
# A step ahead by this much comes from a jump back: when a clock shows a minute less than the file's
# first time, FFmpeg assumes that the clock has passed its largest time, 26.5 hours.
_AHEAD_SECONDS = 12 * 3600


class ClockJumps:
    """Moves packets, in the order of the file, so that their clock never jumps back.

    jumps: for each jump, its time on the mended clock and how far all later packets move, in
    seconds.
    """

    def __init__(self, source: VideoSource) -> None:
        self.jumps: list[tuple[Fraction, Fraction]] = []
        self._is_free = source.has_free_clock
        # by index of an audio or video stream: how many jumps it has made, and where its last
        # packet ends on the mended clock, in seconds
        self._states: dict[int, tuple[int, Fraction]] = {}
        # the state before the stream's last packet, if that packet was the first after a jump
        self._before: dict[int, tuple[int, Fraction]] = {}

    def __call__(self, packet: Any) -> None:
        """Move a packet in place."""
        if not self._is_free:
            return
        time = packet.pts if packet.dts is None else packet.dts
        if time is None:
            return
        base, index = packet.time_base, packet.stream.index
        # A stream that begins after a jump has made it already. Subtitles have too few packets to
        # show a jump, so they move with sound and picture.
        met = max((met for met, _ in self._states.values()), default=0)
        if index in self._states:
            met = self._met_by(index, time * base)
        ticks = round(self._moved(met) / base)
        if packet.dts is not None:
            packet.dts += ticks
        if packet.pts is not None:
            packet.pts += ticks
        if packet.stream.type in ("audio", "video"):
            self._states[index] = met, (time + ticks + (packet.duration or 0)) * base

    def _met_by(self, index: int, seconds: Fraction) -> int:
        """How many jumps a stream has made by its packet at this time on the file's clock."""
        met, end = self._states[index]
        before = self._before.pop(index, None)
        if before is not None and abs(seconds + self._moved(before[0]) - before[1]) < _BACK_SECONDS:
            met, end = before  # only that one packet had a wrong time, and no clock has jumped
            if all(others <= met for at, (others, _) in self._states.items() if at != index):
                del self.jumps[met:]
        for known in range(met, len(self.jumps) + 1):
            if not _is_jump(seconds + self._moved(known) - end):
                break
        else:  # no other stream has jumped yet
            known = len(self.jumps) + 1
            now = max(end for _, end in self._states.values())
            self.jumps.append((now, now - seconds))
        if known > met:
            self._before[index] = met, end
        return known

    def _moved(self, met: int) -> Fraction:
        return self.jumps[met - 1][1] if met else Fraction(0)


def _is_jump(step_seconds: Fraction) -> bool:
    """Whether a step between the decoding times of a stream is a jump of its clock."""
    return not -_BACK_SECONDS < step_seconds < _AHEAD_SECONDS
