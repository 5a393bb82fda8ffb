"""Time as stages that smooth see it, and the memory they keep of each face."""

import math
from collections.abc import Callable
from typing import Generic, Protocol, TypeVar

from makeup_video.pipeline.face import Face, FrameFaces
from makeup_video.pipeline.face_frame import FaceSpace
from makeup_video.pipeline.frame import Frame

GAP_SECONDS = 0.15  # a face that was away for longer is a new one: four frames at 30 fps

_STEP_SHARE = 0.1  # of the newest step in the usual one
_LEAST_STEP = 0.8  # of the usual one; at less, what comes in pairs is left less even


class Clock:
    """Seconds since the first frame that never stand still or go back."""

    def __init__(self) -> None:
        self.seconds = 0.0
        self._last: float | None = None  # None, not falsehood: the first pts is often 0
        self._usual_step = 1 / 30

    def tick(self, frame: Frame) -> float:
        """The time of this frame. A repeated or earlier one counts as one usual step."""
        now = frame.seconds
        if self._last is not None:
            step = now - self._last
            if step > 0:
                self._usual_step = min(step, GAP_SECONDS)
            self.seconds += step if step > 0 else self._usual_step
        self._last = now
        return self.seconds


class EvenTimes:
    """Arrival times with the shortest steps made longer, to most of the usual one.

    A camera takes its pictures evenly, but a busy machine may be handed two at once. As times stand, the
    second would show enormous noise, and hardly count. What was added is taken off the steps after it.
    """

    def __init__(self) -> None:
        self._arrived: float | None = None
        self._told = 0.0
        self._usual_step = 0.0

    def __call__(self, seconds: float) -> float:
        """seconds: each more than the last."""
        if self._arrived is not None:
            step = seconds - self._arrived
            share = _STEP_SHARE if step < GAP_SECONDS else 1  # a pause tells of no usual step
            self._usual_step += share * ((step if step < GAP_SECONDS else 0) - self._usual_step)
            self._told = max(seconds, self._told + _LEAST_STEP * self._usual_step)
        else:
            self._told = seconds
        self._arrived = seconds
        return self._told


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
        self._clock = Clock()
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


def sound_faces(item: FrameFaces) -> tuple[Face, ...]:
    """The faces whose numbers are all finite; one NaN would spoil a whole window."""
    return tuple(face for face in item.faces if _is_finite(face))


def _is_finite(face: Face) -> bool:
    across, down = face.lips.to_px.tolist()
    plain = face.score, face.mouth_visible, *across, *down
    return math.isfinite(sum(plain) + float(face.points_px.sum() + face.lips.logits.sum()))
