"""FrameFaces -> FrameFaces at once, for cameras: the One-Euro filter per region."""

import math

import numpy as np
from makeup_video.pipeline.faces.face import Face, FrameFaces, sound_faces, with_faces
from makeup_video.pipeline.frames.clock import GAP_SECONDS, EvenTimes
from makeup_video.pipeline.smoothing.face_space import (
    LIPS_REGION,
    PATCH_REGION,
    POSE_REGION,
    REGION_OF_COLUMN,
    FaceSpace,
    Readings,
)
from makeup_video.pipeline.smoothing.lookahead import SCORE_SECONDS
from makeup_video.pipeline.smoothing.noise_level import HEARD_MOMENTS, NoiseLevel
from makeup_video.pipeline.smoothing.one_euro import OneEuro
from makeup_video.pipeline.smoothing.track_memory import Tracks


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
        self._looks += (1 - math.exp(-step / SCORE_SECONDS)) * (looks - self._looks)
        score, mouth_visible = self._looks.tolist()
        points_px, lips = self.space.join(values, pose, patch.copy())
        return Face(points_px, score, mouth_visible, face.track_id, lips)
