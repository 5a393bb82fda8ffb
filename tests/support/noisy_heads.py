"""Moving heads with noise, and their noise levels."""

import numpy as np
from heads import IOD_PX, face, lip_logits
from makeup_video.pipeline.faces.topology import LIPS
from makeup_video.pipeline.smoothing.face_space import FaceSpace, Readings
from makeup_video.pipeline.smoothing.lookahead import SmoothAhead
from makeup_video.pipeline.smoothing.noise_level import NOISE_MOMENTS, NoiseLevel
from makeup_video.pipeline.smoothing.realtime import SmoothLive

SMALL = lip_logits((8, 10))


def measure_noise(points, seconds=None):
    """(FaceSpace, Readings, NoiseLevel) after one face for each element of `points`."""
    seconds = np.arange(len(points)) / 30 if seconds is None else seconds
    space, level = FaceSpace(face(points[0], logits=SMALL)), NoiseLevel()
    readings = Readings(space, len(points))
    for index, points_px in enumerate(points):
        space.split(face(points_px, logits=SMALL), readings, index, seconds[index])
        last = range(max(0, index + 1 - NOISE_MOMENTS), index + 1)
        level.update(readings.apart, last, seconds[last].tolist())
    return space, readings, level


STAGES = [SmoothAhead, SmoothLive]


def noise_px(count, share_of_iod=0.003, seed=0):
    """Jitter like that of nets: one part moves single points, the other moves whole regions."""
    rng = np.random.default_rng(seed)
    lips = np.isin(np.arange(478), LIPS)
    out = rng.normal(0, 0.7, (count, 478, 2))
    for region in (lips, ~lips):
        out[:, region] += rng.normal(0, 0.7, (count, 1, 2))
    return out * share_of_iod * IOD_PX
