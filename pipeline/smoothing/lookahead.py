"""Smooths faces over time, so that a still face in a noisy film does not shimmer.

Time is that of the frames (pts * time_base), never a count of frames. The pose and each region
of the shape are smoothed apart, and only as far as differences look like noise.
"""

import math
from collections import deque
from collections.abc import Iterator

import numpy as np
from makeup_video.pipeline.face import Face, FrameFaces, with_faces
from makeup_video.pipeline.face_frame import (
    LIPS_REGION,
    PATCH_REGION,
    POSE_REGION,
    REGION_OF_COLUMN,
    FaceSpace,
    Readings,
)
from makeup_video.pipeline.face_tracks import GAP_SECONDS, EvenTimes, Tracks, sound_faces
from makeup_video.pipeline.local_fit import HEARD_MOMENTS, NoiseLevel, local_linear_taps
from makeup_video.pipeline.one_euro import OneEuro

# For score and mouth_visible, which must follow within a frame or two: the standard deviation of
# the weight by time, and the time constant of the live filter.
_LOOKS_SECONDS = 0.025
# Of the values as each region smooths them, those of its own points.
_OWN = REGION_OF_COLUMN * len(REGION_OF_COLUMN) + np.arange(len(REGION_OF_COLUMN))


class SmoothAhead:
    """FrameFaces -> FrameFaces, a few frames later, for files. Nothing lags.

    The window reaches `window_seconds` to both sides, but never more than `ahead_frames` frames:
    those are held back in memory (12 MB each at 2160p, 25 MB with 10 bits), and a hardware
    decoder has only so many pictures to lend. Four make nine moments, so noise falls to a third;
    for a quarter it would take twice the memory. Faces with numbers that are not finite are left
    out.
    """

    def __init__(
        self,
        window_seconds: float = 0.14,  # four frames at 30 fps, three at 24
        ahead_frames: int = 4,
        gap_seconds: float = GAP_SECONDS,
    ) -> None:
        if not window_seconds > 0 or ahead_frames < 0:
            raise ValueError(
                "window_seconds must be more than 0 and ahead_frames at least 0, got "
                f"{window_seconds} and {ahead_frames}"
            )
        self.window_seconds, self.ahead_frames = window_seconds, ahead_frames
        size = 2 * ahead_frames + 1
        self._tracks = Tracks(lambda face: _Window(face, size), gap_seconds)
        # The frame, its time, and for each face where it is remembered. A held frame keeps its
        # tracks, so a track that has ended still smooths the frames it was in.
        self._held: deque[tuple[FrameFaces, float, list[tuple[_Window, int]]]] = deque()

    def __call__(self, item: FrameFaces) -> FrameFaces | None:
        now = self._tracks.at(item)
        item = with_faces(item, sound_faces(item))
        places = []
        for face in item.faces:
            track = self._tracks.of(face, now)
            places.append((track, track.push(face, now)))
        self._held.append((item, now, places))
        if len(self._held) > self.ahead_frames or now - self._held[0][1] >= self.window_seconds:
            return self._release()
        return None

    def drain(self) -> Iterator[FrameFaces]:
        """The frames held back, in order."""
        while self._held:
            yield self._release()

    def _release(self) -> FrameFaces:
        item, _, places = self._held.popleft()
        faces = tuple(
            track.smooth(face, place, self.window_seconds)
            for face, (track, place) in zip(item.faces, places, strict=True)
        )
        return with_faces(item, faces)


class _Window:
    """The last moments of one face, in a ring: as many as a window can hold."""

    def __init__(self, face: Face, size: int) -> None:
        self.space = FaceSpace(face)
        self.last_seconds = -math.inf
        self._readings = Readings(self.space, size)
        self._seconds = [-math.inf] * size
        self._looks = [(0.0, 0.0)] * size  # score, mouth_visible
        self._noise = NoiseLevel()
        self._size, self._count = size, 0

    def push(self, face: Face, now: float) -> int:
        """Take the newest face; returns its place in the ring."""
        place = self._count % self._size
        self._count += 1
        self.space.split(face, self._readings, place)
        self._seconds[place] = self.last_seconds = now
        self._looks[place] = face.score, face.mouth_visible
        heard = min(self._count, self._size, HEARD_MOMENTS)
        last = [(place - back) % self._size for back in range(heard)]
        self._noise.hear(self._readings.apart, last, [self._seconds[each] for each in last])
        return place

    def smooth(self, face: Face, place: int, window_seconds: float) -> Face:
        """The face at a place in the ring, seen together with what came before and after."""
        ring, now = self._readings, self._seconds[place]
        score, mouth_visible = self._looks_at(now)
        from_now = [
            at - now if abs(at - now) <= window_seconds else math.nan for at in self._seconds
        ]
        taps = local_linear_taps(ring.apart, from_now, place, self._noise.variance())
        taps32 = taps.astype(np.float32)
        values = (taps32[:POSE_REGION] @ ring.values).take(_OWN)
        logits = taps32[PATCH_REGION] @ ring.patches.reshape(self._size, -1)
        points_px, lips = self.space.join(values, taps[POSE_REGION] @ ring.pose, logits)
        return Face(points_px, min(score, 1.0), min(mouth_visible, 1.0), face.track_id, lips)

    def _looks_at(self, now: float) -> tuple[float, float]:
        """Score and mouth_visible at a time."""
        by_time = [math.exp(-0.5 * ((at - now) / _LOOKS_SECONDS) ** 2) for at in self._seconds]
        score = mouth_visible = 0.0
        for weight, looks in zip(by_time, self._looks, strict=True):
            score += weight * looks[0]
            mouth_visible += weight * looks[1]
        total = sum(by_time)
        return score / total, mouth_visible / total


class SmoothLive:
    """FrameFaces -> FrameFaces at once, for cameras: the One-Euro filter (one_euro.py).

    Steady motion lags by a fraction of a frame; jitter at rest falls to a third. Faces with
    numbers that are not finite are left out.
    """

    def __init__(
        self,
        min_cutoff_hz: float = 1.0,
        rise_hz: float = 15.0,
        speed_cutoff_hz: float = 15.0,
        gap_seconds: float = GAP_SECONDS,
    ) -> None:
        if not (min_cutoff_hz > 0 and rise_hz >= 0 and speed_cutoff_hz > 0):
            raise ValueError(
                "the cutoffs must be more than 0 Hz and rise_hz at least 0, got "
                f"{min_cutoff_hz}, {speed_cutoff_hz} and {rise_hz}"
            )
        options = min_cutoff_hz, rise_hz, speed_cutoff_hz
        self._tracks = Tracks(lambda face: _Filter(face, *options), gap_seconds)
        self._even = EvenTimes()

    def __call__(self, item: FrameFaces) -> FrameFaces:
        now = self._even(self._tracks.at(item))
        faces = tuple(self._tracks.of(face, now).smooth(face, now) for face in sound_faces(item))
        return with_faces(item, faces)


class _Filter:
    """The filter of one face, and the last moments that tell its noise."""

    def __init__(
        self, face: Face, min_cutoff_hz: float, rise_hz: float, speed_cutoff_hz: float
    ) -> None:
        self.space = FaceSpace(face)
        self.last_seconds = -math.inf
        # In the last place is the smoothed reading: its patch moves to a new window with the rest.
        self._readings = Readings(self.space, HEARD_MOMENTS + 1)
        self._seconds = [0.0] * HEARD_MOMENTS
        self._looks = np.zeros(2)  # score, mouth_visible
        self._noise = NoiseLevel()
        self._filter = OneEuro(
            self.space.key_starts,
            self.space.key_counts,
            min_cutoff_hz,
            rise_hz,
            speed_cutoff_hz,
        )
        self._count = 0

    def smooth(self, face: Face, now: float) -> Face:
        """The face as it is taken to be now."""
        ring, place = self._readings, self._count % HEARD_MOMENTS
        self._count += 1
        self.space.split(face, ring, place)
        step = now - self.last_seconds  # at first endless, and then what was before counts nothing
        self._seconds[place] = self.last_seconds = now
        heard = range(min(self._count, HEARD_MOMENTS))
        self._noise.hear(ring.apart, heard, self._seconds[: len(heard)])
        shares = self._filter(ring.keys[place], step, self._noise.variance())
        values, pose, patch = ring.values[-1], ring.pose[-1], ring.patches[-1]
        values += shares.astype(np.float32)[REGION_OF_COLUMN] * (ring.values[place] - values)
        pose += shares[POSE_REGION] * (ring.pose[place] - pose)
        share = max(shares[LIPS_REGION], shares[PATCH_REGION])
        patch += np.float32(share) * (ring.patches[place] - patch)
        looks = np.array([face.score, face.mouth_visible])
        self._looks += (1 - math.exp(-step / _LOOKS_SECONDS)) * (looks - self._looks)
        score, mouth_visible = self._looks.tolist()
        points_px, lips = self.space.join(values, pose, patch.copy())
        return Face(points_px, score, mouth_visible, face.track_id, lips)
