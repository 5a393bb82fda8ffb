"""How noisy a track's readings are, per region, from the last moments."""

import math
from collections.abc import Sequence

import numpy as np
from makeup_video.pipeline.smoothing.face_space import LIPS_REGION, POSE_REGION

# Per region as in face_frame.REGIONS, in its units, squared. What a reading's noise is taken for
# before any was heard; and between which bounds what is heard is believed: numbers are rounded,
# and some motion is taken for noise.
_USUAL = np.array([2e-3, 2e-3, 2e-3, 2e-3, 1e-3, 0.02]) ** 2
_LEAST = np.array([1.5e-4, 1.5e-4, 1.5e-4, 1.5e-4, 1e-4, 1e-3]) ** 2
_MOST = np.array([1.2e-2, 1.2e-2, 1.2e-2, 1.2e-2, 8e-3, 0.06]) ** 2

# Somebody who talks without a pause lets no noise of the lips be heard: it is hardly more than that
# of lids and rest, in variance.
_LIPS_TO_OTHERS = 2.5
HEARD_MOMENTS = 5
_HEARD_SECONDS = 0.3  # moments further apart say more about motion than about noise
_KEPT = 24  # estimates, one for every second moment: 1.6 s at 30 fps


class NoiseLevel:
    """The variance of a track's readings, per region.

    Five moments that follow each other are compared with the cubic nearest to them: what is
    left is noise, and very little motion (second differences were tried, and took a head that
    shakes for noise). The median over the last moments passes over blinks and syllables.
    """

    def __init__(self) -> None:
        self._heard = np.empty((_KEPT, len(_USUAL)))
        self._heard[0] = _USUAL
        self._count = 1
        self._variance = _USUAL
        self._moments = 0

    def hear(self, apart: np.ndarray, places: Sequence[int], seconds: Sequence[float]) -> None:
        """apart: (regions, N, N), see Readings; places and seconds of the last moments, all different."""
        # A new estimate shares four moments of five with the one before: every other will do,
        # once there are some.
        self._moments += 1
        skipped = self._moments > 2 * HEARD_MOMENTS and self._moments % 2
        if skipped or len(seconds) < 3 or max(seconds) - min(seconds) > _HEARD_SECONDS:
            return
        # Newton's divided difference: 0 for every polynomial of degree N - 2, whatever the times.
        shares = [1 / math.prod(at - other for other in seconds if other != at) for at in seconds]
        length = math.hypot(*shares)
        each = np.zeros(apart.shape[1])
        each[list(places)] = [share / length for share in shares]
        # The square of the difference, told by distances, as the shares sum to 0.
        self._heard[self._count % _KEPT] = np.maximum(-0.5 * (apart @ each @ each), 0)
        self._count += 1
        heard = np.sort(self._heard[: self._count], 0)
        variance = np.clip(heard[len(heard) // 2], _LEAST, _MOST)
        others = float(variance[LIPS_REGION + 1 : POSE_REGION].mean())
        variance[LIPS_REGION] = min(variance[LIPS_REGION], _LIPS_TO_OTHERS * others)
        self._variance = variance

    def variance(self) -> np.ndarray:
        """(regions,) mean squared error of a point's place; of the patch's sample."""
        return self._variance
