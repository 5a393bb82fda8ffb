"""Keeps the pictures between a start and an end, with times that begin at 0."""

from fractions import Fraction
from typing import Generic, TypeVar

T = TypeVar("T")

# A picture that stays on screen for longer than this after the start belongs to the clip: a screen
# recording may show one for seconds. At ordinary frame rates the clip begins with the next picture.
STILL_SECONDS = Fraction(1, 10)


class Trim(Generic[T]):
    """Takes pictures in order of time and returns those to keep, with their times and durations in
    the clip.

    start, end: seconds on the container's clock, None where nothing is cut.
    tick: seconds; the shift is a whole number of ticks, so that times stay exact.
    late_start: seconds to subtract from all times where there is no start.
    shift: seconds to subtract from every time of the clip, None until the first picture is kept.
    """

    def __init__(
        self,
        start: Fraction | None,
        end: Fraction | None,
        tick: Fraction,
        late_start: Fraction = Fraction(0),
    ) -> None:
        self.start, self.end, self.tick, self.late_start = start, end, tick, late_start
        self.shift: Fraction | None = None
        self.is_past_end = False
        self._held: T | None = None
        self._held_until = Fraction(0)

    def __call__(
        self, picture: T, seconds: Fraction, duration: Fraction
    ) -> list[tuple[T, Fraction, Fraction]]:
        """The pictures to keep now, with their times in the clip, which are at least 0, and their
        durations."""
        if self.start is not None and seconds < self.start:
            self._held, self._held_until = picture, seconds + duration
            return []
        self._held_until = seconds  # the picture that is held was on screen until now
        if self.end is not None and seconds >= self.end:
            self.is_past_end = True
            return self.finish()
        if self.end is not None and duration > STILL_SECONDS:
            duration = min(duration, self.end - seconds)
        if self.shift is not None:
            return [(picture, seconds - self.shift if self.shift else seconds, duration)]
        if self.start is None:
            # a picture before 0 moves to 0, since players do not show what lies before 0
            self.shift = min(self.late_start, seconds)
            return [(picture, seconds - self.shift, duration)]
        if seconds - self.start <= STILL_SECONDS:
            self.shift = seconds
            return [(picture, Fraction(0), duration)]
        return [*self.finish(), (picture, seconds - self._begin(), duration)]

    def is_counted(self, seconds: Fraction) -> bool:
        """True when a picture of the video at that time counts in the report."""
        return True

    def finish(self) -> list[tuple[T, Fraction, Fraction]]:
        """The picture that is on screen at `start`, if any.

        Called at the end of the video, or before a picture that comes late.
        """
        if self.shift is not None or self.start is None or self._held is None:
            return []
        if self._held_until <= self.start:
            return []
        until = self._held_until if self.end is None else min(self._held_until, self.end)
        return [(self._held, Fraction(0), until - self._begin())]

    def _begin(self) -> Fraction:
        """Let the clip begin at `start`, rounded down to a tick; returns the shift."""
        if self.shift is None:
            self.shift = (self.start or Fraction(0)) // self.tick * self.tick
        return self.shift
