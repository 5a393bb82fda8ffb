"""Heads that move under noise, and what smoothing makes of them."""

import numpy as np
from heads import IOD_PX, face, lip_logits
from makeup_video.pipeline.faces.topology import LIPS
from makeup_video.pipeline.smoothing.face_space import FaceSpace, Readings
from makeup_video.pipeline.smoothing.lookahead import SmoothAhead
from makeup_video.pipeline.smoothing.noise_level import NOISE_MOMENTS, NoiseLevel
from makeup_video.pipeline.smoothing.realtime import SmoothLive

SMALL = lip_logits((8, 10))


def heard(points, seconds=None):
    """NoiseLevel after these faces, and their space."""
    seconds = np.arange(len(points)) / 30 if seconds is None else seconds
    space, level = FaceSpace(face(points[0], logits=SMALL)), NoiseLevel()
    readings = Readings(space, len(points))
    for at, each in enumerate(points):
        space.split(face(each, logits=SMALL), readings, at)
        last = range(max(0, at + 1 - NOISE_MOMENTS), at + 1)
        level.update(readings.apart, last, seconds[last].tolist())
    return space, readings, level


STAGES = [SmoothAhead, SmoothLive]


def noise_px(count, share_of_iod=0.003, seed=0):
    """Jitter as nets have it: part moves each point, part a whole region at once."""
    rng = np.random.default_rng(seed)
    lips = np.isin(np.arange(478), LIPS)
    out = rng.normal(0, 0.7, (count, 478, 2))
    for region in (lips, ~lips):
        out[:, region] += rng.normal(0, 0.7, (count, 1, 2))
    return out * share_of_iod * IOD_PX
