"""Smooths faces without delay, for cameras: one One-Euro filter per face, part by part."""

import math

import numpy as np
from makeup_video.pipeline.faces.face import Face, FrameFaces, sound_faces, with_faces
from makeup_video.pipeline.frames.clock import EvenTimes
from makeup_video.pipeline.smoothing.face_space import (
    LIPS_PART,
    PART_OF_COLUMN,
    PART_OF_POSE,
    PATCH_PART,
    PLACE_PART,
    POSE_PART,
    FaceSpace,
    Readings,
)
from makeup_video.pipeline.smoothing.lookahead import SCORE_SECONDS
from makeup_video.pipeline.smoothing.noise_level import NOISE_MOMENTS, NoiseLevel
from makeup_video.pipeline.smoothing.one_euro import OneEuro
from makeup_video.pipeline.smoothing.tracks import Tracks


class SmoothLive:
    """FrameFaces -> FrameFaces without delay.

    Steady motion lags by a fraction of a frame; jitter at rest falls to a third. Faces with numbers
    that are not finite are left out.
    """

    def __init__(self) -> None:
        self._tracks = Tracks(_Filter, EvenTimes())

    def __call__(self, item: FrameFaces) -> FrameFaces:
        now = self._tracks.advance(item)
        faces = tuple(
            self._tracks.track_of(face, now).smooth(face, now) for face in sound_faces(item)
        )
        return with_faces(item, faces)


class _Filter:
    """The filter of one face, and the last moments, which its noise is estimated from."""

    def __init__(self, face: Face) -> None:
        self.space = FaceSpace(face)
        self.last_seconds = -math.inf
        # The last reading is the smoothed one: its patch moves to a new crop together with the
        # others.
        self._readings = Readings(self.space, NOISE_MOMENTS + 1)
        self._seconds = [0.0] * NOISE_MOMENTS
        self._scores = np.zeros(2)  # score, mouth_visible
        self._noise = NoiseLevel()
        self._filter = OneEuro(self.space.key_starts, self.space.key_counts)
        self._count = 0

    def smooth(self, face: Face, now: float) -> Face:
        """The smoothed face."""
        readings, index = self._readings, self._count % NOISE_MOMENTS
        self._count += 1
        self.space.split(face, readings, index, now)
        step = now - self.last_seconds  # infinite at first, so that nothing before counts
        self._seconds[index] = self.last_seconds = now
        last = range(min(self._count, NOISE_MOMENTS))
        self._noise.update(readings.apart, last, self._seconds[: len(last)])
        variance = self._noise.variance().copy()
        # from units of the face now to units of the track's first face, which the keys have
        variance[[POSE_PART, PLACE_PART]] *= math.exp(2 * readings.pose[index, 2])
        shares = self._filter(readings.keys[index], step, variance)
        values, pose, patch = readings.values[-1], readings.pose[-1], readings.patches[-1]
        values += shares.astype(np.float32)[PART_OF_COLUMN] * (readings.values[index] - values)
        pose += shares[PART_OF_POSE] * (readings.pose[index] - pose)
        share = max(shares[LIPS_PART], shares[PATCH_PART])
        patch += np.float32(share) * (readings.patches[index] - patch)
        scores = np.array([face.score, face.mouth_visible])
        self._scores += (1 - math.exp(-step / SCORE_SECONDS)) * (scores - self._scores)
        score, mouth_visible = self._scores.tolist()
        points_px, lips = self.space.join(values, pose, patch.copy())
        return Face(points_px, score, mouth_visible, face.track_id, lips)
