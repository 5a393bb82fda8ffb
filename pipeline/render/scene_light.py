"""FrameFaces -> the light on each face, smoothed over time.

skin_light.py reads the light from one frame.
"""

import math
from dataclasses import dataclass

import cv2
import numpy as np
from makeup_video.pipeline.faces.face import Face, FrameFaces
from makeup_video.pipeline.faces.track_memory import TrackMemory
from makeup_video.pipeline.frames.clock import MediaClock, slot
from makeup_video.pipeline.frames.frame import Frame, coding_of
from makeup_video.pipeline.render.scene import SceneLight
from makeup_video.pipeline.render.skin_light import (
    Optics,
    log_mean,
    optics_of,
    read_face,
    read_room,
)

READ_SECONDS = 0.2  # slot of time in which faces and room are read once; smoothing fills the gaps
SMOOTH_SECONDS = 0.5  # time constant: a hand's shadow hardly counts, a lamp switched on soon does
ROOM_SMOOTH_SECONDS = 0.4  # time constant of the environment
FORGET_SECONDS = 2.0  # four time constants: hardly anything of the old value is left


@dataclass(slots=True)
class _Room:
    """The environment, the same for all faces of a frame."""

    reading: int  # the slot of time when it was read last
    seen_seconds: float
    target: np.ndarray  # (16, 16, 3) float32, linear, as last read
    mean: np.ndarray  # (3,) log of its mean, in sRGB's primaries
    value: np.ndarray  # the target, smoothed


@dataclass(slots=True)
class _Track:
    """The light on one face as 13 numbers.

    They are log strength, log colour, direction, log luminance of the skin, log of its share under
    the eyes, and log share and log colour of the light for veils.
    """

    reading: int  # the slot of time when it was read last
    last_seconds: float
    target: list[float]
    value: list[float]


class EstimateLight:
    """FrameFaces -> a SceneLight for each face, in the same order, smoothed over time.

    Without faces nothing is read. A face that cannot be read (outside the picture, or its numbers
    are not finite) gets the light that the frame as a whole suggests, from the front and above.
    """

    def __init__(self) -> None:
        self._clock = MediaClock()
        self._room: _Room | None = None
        self._tracks: TrackMemory[int, _Track] = TrackMemory(FORGET_SECONDS)

    def __call__(self, item: FrameFaces) -> tuple[SceneLight, ...]:
        now = self._clock.tick(item.frame)
        if item.cut:
            self._room = None
            self._tracks.clear()
        self._tracks.forget(now)
        if not item.faces:
            return ()
        optics = optics_of(coding_of(item.frame))
        room = self._room = _follow_room(self._room, item.frame, optics, now)
        return tuple(
            _light(self._follow(face, item.frame, optics, room, now), optics, room.value)
            for face in item.faces
        )

    def _follow(
        self, face: Face, frame: Frame, optics: Optics, room: _Room, now: float
    ) -> list[float]:
        """The light on a face now, smoothed, as the numbers of `_Track`."""
        track = self._tracks.get(face.track_id)
        if track is not None and track.last_seconds == now:  # a second face with the same id
            return _read(face, frame, optics, room)
        if track is None:
            target = _read(face, frame, optics, room)
            reading = slot(frame.seconds, READ_SECONDS)
            track = self._tracks[face.track_id] = _Track(reading, now, target, target)
            return track.value
        if (reading := slot(frame.seconds, READ_SECONDS)) != track.reading:
            track.target = _read(face, frame, optics, room)
            track.reading = reading
        share = -math.expm1((track.last_seconds - now) / SMOOTH_SECONDS)
        track.value = [
            value + share * (target - value)
            for value, target in zip(track.value, track.target, strict=True)
        ]
        track.last_seconds = now
        return track.value


def _read(face: Face, frame: Frame, optics: Optics, room: _Room) -> list[float]:
    """The light on a face from this frame alone, as the numbers of `_Track`."""
    numbers: list[float] = read_face(face, frame, optics, room.mean).tolist()
    return numbers


def _light(state: list[float], optics: Optics, room: np.ndarray) -> SceneLight:
    strength, *logs, x, y, z, skin, under_eyes, veil_share, veil_red, veil_green, veil_blue = state
    colour = _colour(logs, optics)
    veil_colour = _colour([veil_red, veil_green, veil_blue], optics)
    length = math.hypot(x, y, z)
    numbers = colour, (x / length, y / length, z / length), veil_colour
    rgb, direction, veil_rgb = np.array(numbers, np.float32)
    skin, under_eyes, share = (math.exp(log) for log in (skin, under_eyes, veil_share))
    return SceneLight(rgb, math.exp(strength), direction, room, skin, under_eyes, veil_rgb, share)


def _colour(logs: list[float], optics: Optics) -> list[float]:
    """Log colour -> colour, of luminance 1."""
    colour = [math.exp(log) for log in logs]
    luminance = sum(c * w for c, w in zip(colour, optics.luminance.tolist(), strict=True))
    return [c / luminance for c in colour]


def light_of(item: FrameFaces) -> tuple[SceneLight, ...]:
    """The light on each face of a picture that stands alone."""
    return EstimateLight()(item)


def _follow_room(room: _Room | None, frame: Frame, optics: Optics, now: float) -> _Room:
    """The environment now, smoothed."""
    reading = slot(frame.seconds, READ_SECONDS)
    if room is None or now - room.seen_seconds > FORGET_SECONDS:
        target = read_room(frame, optics)
        return _Room(reading, now, target, log_mean(target, optics), target)
    if reading != room.reading:
        room.target, room.reading = read_room(frame, optics), reading
        room.mean = log_mean(room.target, optics)
    share = -math.expm1((room.seen_seconds - now) / ROOM_SMOOTH_SECONDS)
    room.value = cv2.addWeighted(room.target, share, room.value, 1 - share, 0)
    room.seen_seconds = now
    return room
