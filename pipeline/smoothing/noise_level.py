"""Estimates how noisy a track's readings are, per part, from the last moments."""

import math
from collections.abc import Sequence

import numpy as np
from makeup_video.pipeline.frames.clock import slot
from makeup_video.pipeline.smoothing.face_space import LIPS_PART, PLACE_PART, POSE_PART

# Variances of the parts of face_space.PARTS, in units of Readings. _USUAL holds until there is an
# estimate, and below 9 frames a second for good. Estimates are at least _LEAST, because numbers are
# rounded, and at most _MOST, because some motion is taken for noise.
_USUAL = np.array([2e-3, 2e-3, 2e-3, 2e-3, 1e-3, 2e-3, 0.02]) ** 2
_LEAST = np.array([1.5e-4, 1.5e-4, 1.5e-4, 1.5e-4, 1e-4, 1.5e-4, 1e-3]) ** 2
_MOST = np.array([1.2e-2, 1.2e-2, 1.2e-2, 1.2e-2, 8e-3, 1.2e-2, 0.06]) ** 2
# From the median of the estimates to their mean. The median of a sum of few squares is lower than
# the mean: 0.69 of it for two numbers with normal noise that differs from moment to moment. These
# factors were measured on a still face in noise.
_TO_MEAN = np.array([1, 1, 1, 1, 1.5, 2, 1])

# Continuous speech hides the lips' noise, so the lips' variance is bounded by this multiple of the
# mean variance of the lids and the rest.
_LIPS_TO_OTHERS = 2.5
NOISE_MOMENTS = 5
# Moments further apart than this on average show motion, not noise: five of them, and fewer at the
# beginning of a track.
_MOST_STEP_SECONDS, _MOST_FIRST_STEP_SECONDS = 0.11, 0.075
# How many estimates are kept, and the length of the slots of time with one estimate each: 1.5 s in
# all.
_KEPT, _SLOT_SECONDS = 22, 1 / 15


class NoiseLevel:
    """The variance of a track's readings, per part.

    Five consecutive moments are compared with the cubic nearest to them. What is left is noise, and
    very little motion (second differences were tried, and took a shaking head for noise). The
    median over the last estimates ignores blinks and syllables.
    """

    def __init__(self) -> None:
        self._estimates = np.empty((_KEPT, len(_USUAL)))
        self._estimates[0] = _USUAL
        self._count = 1
        self._variance = _USUAL
        self._moments, self._slot = 0, 0

    def update(self, apart: np.ndarray, indices: Sequence[int], seconds: Sequence[float]) -> None:
        """Estimate the noise of the last moments.

        apart: (parts, N, N), see Readings. indices: the last moments' places in `apart`.
        seconds: their times in the video, all different.
        """
        # A new estimate shares four moments of five with the one before, so one in a slot is enough
        # once there are some.
        self._moments += 1
        own_slot = slot(max(seconds), _SLOT_SECONDS)
        skipped = self._moments > 2 * NOISE_MOMENTS and own_slot == self._slot
        self._slot = own_slot
        if skipped or len(seconds) < 3:
            return
        is_first = len(seconds) < NOISE_MOMENTS
        most_step = _MOST_FIRST_STEP_SECONDS if is_first else _MOST_STEP_SECONDS
        if max(seconds) - min(seconds) > most_step * (len(seconds) - 1):
            return
        # Newton's divided difference: 0 for every polynomial of degree N - 2, whatever the times.
        shares = [
            1 / math.prod(time - other for other in seconds if other != time) for time in seconds
        ]
        length = math.hypot(*shares)
        weights = np.zeros(apart.shape[1])
        weights[list(indices)] = [share / length for share in shares]
        # The square of the difference follows from distances alone, because the weights sum to 0.
        self._estimates[self._count % _KEPT] = np.maximum(-0.5 * (apart @ weights @ weights), 0)
        self._count += 1
        estimates = self._estimates[: self._count].copy()
        estimates.sort(0)
        usual = _TO_MEAN * estimates[len(estimates) // 2]
        variance = np.minimum(np.maximum(usual, _LEAST), _MOST)
        of_others = variance[LIPS_PART + 1 : POSE_PART].tolist()
        most = _LIPS_TO_OTHERS * (sum(of_others) / len(of_others))
        for part in (LIPS_PART, PLACE_PART):
            variance[part] = min(variance[part], most)
        self._variance = variance

    def variance(self) -> np.ndarray:
        """(parts,) mean squared error of a point; for the patch, of a sample."""
        return self._variance
