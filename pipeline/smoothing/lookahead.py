"""Smooths faces with frames ahead, for files: a still face in a noisy video does not shimmer.

Time comes from the frames' timestamps (pts * time_base), never from a count of frames. The pose and
each part of the shape are smoothed separately, and only as far as differences look like noise.
"""

import math
from collections import deque
from collections.abc import Iterator

import numpy as np
from makeup_video.pipeline.faces.face import Face, FrameFaces, sound_faces, with_faces
from makeup_video.pipeline.smoothing.face_space import (
    PART_OF_COLUMN,
    PART_OF_POSE,
    PATCH_PART,
    POSE_PART,
    FaceSpace,
    Readings,
)
from makeup_video.pipeline.smoothing.local_linear import local_linear_taps
from makeup_video.pipeline.smoothing.noise_level import NOISE_MOMENTS, NoiseLevel
from makeup_video.pipeline.smoothing.tracks import Tracks

# For score and mouth_visible, which must follow within a frame or two: the standard deviation of
# the weight by time here, and the time constant of the live filter.
SCORE_SECONDS = 0.025
_WINDOW_SECONDS = 0.14  # to both sides of a frame: four frames at 30 fps, three at 24
# Most frames to each side. Frames ahead are held in memory (12 MB each at 2160p, 25 MB with 10
# bits), and a hardware decoder lends only a few pictures. Four to each side make nine moments, so
# noise falls to a third. To a quarter it would take twice the memory.
AHEAD_FRAMES = 4
# Places in flattened (parts, columns) values: each column in the row of its own part.
_OWN = PART_OF_COLUMN * len(PART_OF_COLUMN) + np.arange(len(PART_OF_COLUMN))


class SmoothAhead:
    """FrameFaces -> FrameFaces, a few frames later, without lag.

    The time window reaches _WINDOW_SECONDS to both sides, but never more than AHEAD_FRAMES. Faces
    with numbers that are not finite are left out.
    """

    def __init__(self) -> None:
        self._tracks = Tracks(lambda face: _TimeWindow(face, 2 * AHEAD_FRAMES + 1))
        # The frame, its time, and the track and index of each face. A held frame keeps its tracks,
        # so a track that has ended still smooths the frames that it was in.
        self._held: deque[tuple[FrameFaces, float, list[tuple[_TimeWindow, int]]]] = deque()

    def __call__(self, item: FrameFaces) -> FrameFaces | None:
        now = self._tracks.advance(item)
        item = with_faces(item, sound_faces(item))
        moments = []
        for face in item.faces:
            track = self._tracks.track_of(face, now)
            moments.append((track, track.push(face, now)))
        self._held.append((item, now, moments))
        if len(self._held) > AHEAD_FRAMES or now - self._held[0][1] >= _WINDOW_SECONDS:
            return self._release()
        return None

    def drain(self) -> Iterator[FrameFaces]:
        """The frames held back, in order."""
        while self._held:
            yield self._release()

    def _release(self) -> FrameFaces:
        item, _, moments = self._held.popleft()
        faces = tuple(
            track.smooth(face, index)
            for face, (track, index) in zip(item.faces, moments, strict=True)
        )
        return with_faces(item, faces)


class _TimeWindow:
    """The last moments of one face, in a ring buffer: as many as the window can hold."""

    def __init__(self, face: Face, size: int) -> None:
        self.space = FaceSpace(face)
        self.last_seconds = -math.inf
        self._readings = Readings(self.space, size)
        self._seconds = [-math.inf] * size
        self._scores = [(0.0, 0.0)] * size  # score, mouth_visible
        self._noise = NoiseLevel()
        self._size, self._count = size, 0

    def push(self, face: Face, now: float) -> int:
        """Add the newest face; returns its index in the ring."""
        index = self._count % self._size
        self._count += 1
        self.space.split(face, self._readings, index, now)
        self._seconds[index] = self.last_seconds = now
        self._scores[index] = face.score, face.mouth_visible
        count = min(self._count, self._size, NOISE_MOMENTS)
        last = [(index - back) % self._size for back in range(count)]
        self._noise.update(self._readings.apart, last, [self._seconds[i] for i in last])
        return index

    def smooth(self, face: Face, index: int) -> Face:
        """The face at an index of the ring, smoothed with the moments before and after it."""
        readings, now = self._readings, self._seconds[index]
        score, mouth_visible = self._scores_at(now)
        from_now = [
            seconds - now if abs(seconds - now) <= _WINDOW_SECONDS else math.nan
            for seconds in self._seconds
        ]
        taps = local_linear_taps(readings.apart, from_now, index, self._noise.variance())
        taps32 = taps.astype(np.float32)
        values = (taps32[:POSE_PART] @ readings.values).take(_OWN)
        logits = taps32[PATCH_PART] @ readings.patches.reshape(self._size, -1)
        pose = np.einsum("cn,nc->c", taps[PART_OF_POSE], readings.pose)
        points_px, lips = self.space.join(values, pose, logits)
        return Face(points_px, min(score, 1.0), min(mouth_visible, 1.0), face.track_id, lips)

    def _scores_at(self, now: float) -> tuple[float, float]:
        """Smoothed score and mouth_visible at a time."""
        weights = [math.exp(-0.5 * ((time - now) / SCORE_SECONDS) ** 2) for time in self._seconds]
        score = mouth_visible = 0.0
        for weight, scores in zip(weights, self._scores, strict=True):
            score += weight * scores[0]
            mouth_visible += weight * scores[1]
        total = sum(weights)
        return score / total, mouth_visible / total
