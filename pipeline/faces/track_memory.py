"""What a stage remembers of each track, until a long absence ends the memory."""

from collections.abc import Hashable
from typing import Generic, Protocol, TypeVar


class Remembered(Protocol):
    """What is remembered of one track, and when the track was last seen."""

    @property
    def last_seconds(self) -> float: ...


Key = TypeVar("Key", bound=Hashable)  # the track's number, or the number and a region
T = TypeVar("T", bound=Remembered)


class TrackMemory(dict[Key, T], Generic[Key, T]):
    """A dict that forgets tracks not seen for more than gap_seconds. Call `clear` at a cut.

    Raises ValueError for a gap of 0 or less.
    """

    def __init__(self, gap_seconds: float) -> None:
        if not gap_seconds > 0:
            raise ValueError(f"gap_seconds must be more than 0, got {gap_seconds}")
        super().__init__()
        self.gap_seconds = gap_seconds

    def forget(self, now: float) -> None:
        """Drop the tracks that were last seen more than gap_seconds before or after `now`.

        A track seen after `now` is left over from before the clock jumped back.
        """
        oldest, newest = now - self.gap_seconds, now + self.gap_seconds
        for key in [key for key, value in self.items() if not _is_in(value, oldest, newest)]:
            del self[key]


def _is_in(value: Remembered, oldest: float, newest: float) -> bool:
    return oldest <= value.last_seconds <= newest
