"""The kept part of a video: moves its packets and chapters in time and drops all others."""

from dataclasses import dataclass
from fractions import Fraction
from typing import Any

from makeup_video.pipeline.media.input_file import is_cover

_ZERO = Fraction(0)


@dataclass(frozen=True, slots=True)
class Clip:
    """A span of the source's clock, in seconds.

    start, end: None where the clip begins or ends with the video.
    shift: subtracted from every time, so that the clip begins at 0.
    """

    start: Fraction | None = None
    end: Fraction | None = None
    shift: Fraction = _ZERO

    @property
    def _is_whole(self) -> bool:
        """True when nothing moves and nothing is dropped."""
        return self.start is None and self.end is None and not self.shift

    def is_after(self, packet: Any) -> bool:
        """True for a packet from the clip's end on."""
        time = packet.pts if packet.pts is not None else packet.dts
        return self.end is not None and time is not None and time * packet.time_base >= self.end

    def take(self, packet: Any) -> bool:
        """Move a packet into the clip's time; False when the packet lies outside.

        Subtitles that are on screen at the start or at the end are cut to the clip. Cover art from
        before the start is kept.
        """
        time = packet.pts if packet.pts is not None else packet.dts
        if self._is_whole or time is None:
            return True
        base, is_text = packet.time_base, packet.stream.type == "subtitle"
        seconds = time * base
        if self.is_after(packet):
            return False
        stop = seconds + (packet.duration or 0) * base
        is_before = stop <= self.shift if is_text else seconds < self.shift
        # without a start, only subtitles are dropped: those that end before a late clock begins
        if is_before and (self.start is not None or (is_text and self.shift > 0)):
            return is_cover(packet.stream)
        if is_text and self.end is not None:
            packet.duration = min(packet.duration, round((self.end - seconds) / base))
        ticks = round(self.shift / base)
        cut_ticks = max(0, ticks - time) if is_text else 0  # the subtitle's part before the start
        if packet.pts is not None:
            packet.pts += cut_ticks - ticks
        if packet.dts is not None:
            packet.dts += cut_ticks - ticks
        if cut_ticks:
            packet.duration -= cut_ticks
        return True

    def chapters(self, chapters: list[Any]) -> list[Any]:
        """PyAV's chapters that lie in the clip, cut to the clip and moved to its times."""
        if self._is_whole:
            return chapters
        kept = []
        for chapter in chapters:
            base = chapter["time_base"]
            first = max(chapter["start"] * base, self.start or _ZERO, self.shift)
            last = chapter["end"] * base
            last = last if self.end is None else min(last, self.end)
            if last > first:
                start = max(0, int((first - self.shift) / base))
                kept.append({**chapter, "start": start, "end": int((last - self.shift) / base)})
        return kept
