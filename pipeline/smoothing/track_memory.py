"""Time as stages that smooth see it, and the memory they keep of each face."""

import math
from collections.abc import Callable
from typing import Generic, Protocol, TypeVar

from makeup_video.pipeline.faces.face import Face, FrameFaces
from makeup_video.pipeline.frames.clock import MediaClock
from makeup_video.pipeline.smoothing.face_space import FaceSpace


class Track(Protocol):
    """What is remembered of one face."""

    space: FaceSpace
    last_seconds: float


T = TypeVar("T", bound=Track)


class Tracks(Generic[T]):
    """The memory of each face by its number. A cut, or a longer absence, ends it."""

    def __init__(self, begin: Callable[[Face], T], gap_seconds: float) -> None:
        if not gap_seconds > 0:
            raise ValueError(f"gap_seconds must be more than 0, got {gap_seconds}")
        self._begin, self.gap_seconds = begin, gap_seconds
        self._clock = MediaClock()
        self._tracks: dict[int, T] = {}

    def at(self, item: FrameFaces) -> float:
        """Go on to this frame; returns its time in seconds."""
        now = self._clock.tick(item.frame)
        oldest = math.inf if item.cut else now - self.gap_seconds
        self._tracks = {
            name: track for name, track in self._tracks.items() if track.last_seconds >= oldest
        }
        return now

    def of(self, face: Face, now: float) -> T:
        """The memory that this face goes on with; a second face of one number has its own."""
        track = self._tracks.get(face.track_id)
        if track is not None and track.last_seconds == now:
            return self._begin(face)
        if track is None or track.space.patch_hw != face.lips.logits.shape:
            track = self._tracks[face.track_id] = self._begin(face)
        return track
