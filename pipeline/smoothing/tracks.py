"""The clock of a stage that smooths faces, and what the stage remembers of each track."""

from collections.abc import Callable
from typing import Generic, Protocol, TypeVar

from makeup_video.pipeline.faces.face import Face, FrameFaces
from makeup_video.pipeline.faces.track_memory import TrackMemory
from makeup_video.pipeline.frames.clock import GAP_SECONDS, MediaClock
from makeup_video.pipeline.smoothing.face_space import FaceSpace


class Track(Protocol):
    """What is remembered of one face."""

    space: FaceSpace
    last_seconds: float


T = TypeVar("T", bound=Track)


class Tracks(Generic[T]):
    """What is remembered of each face. A cut, or an absence of more than GAP_SECONDS, ends it.

    begin: makes the memory of a new track from its first face.
    even: media time, which always advances -> the time that the tracks use.
    """

    def __init__(
        self,
        begin: Callable[[Face], T],
        even: Callable[[float], float] = lambda seconds: seconds,
    ) -> None:
        self._begin = begin
        self._even = even
        self._clock = MediaClock()
        self._tracks: TrackMemory[int, T] = TrackMemory(GAP_SECONDS)

    def advance(self, item: FrameFaces) -> float:
        """Go on to this frame; returns its time in seconds, evened."""
        now = self._even(self._clock.tick(item.frame))
        if item.cut:
            self._tracks.clear()
        self._tracks.forget(now)
        return now

    def track_of(self, face: Face, now: float) -> T:
        """The track that this face continues; a second face with its number gets a new track."""
        track = self._tracks.get(face.track_id)
        if track is not None and track.last_seconds == now:
            return self._begin(face)
        if track is None or track.space.patch_hw != face.lips.logits.shape:
            track = self._tracks[face.track_id] = self._begin(face)
        return track
