"""Regression over a short window of time that lets go where something really happens."""

import math
from collections.abc import Sequence

import numpy as np
from makeup_video.pipeline.face_frame import LIPS_REGION, PATCH_REGION, POSE_REGION

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

_TIME_SECONDS = 0.12  # standard deviation of the weight by time
_SLOPE_SECONDS = 0.04  # of the weight by time for the first guess of the speed
# Squared distances up to this, in units of what noise alone makes, are noise; for each unit
# beyond it the weight falls by a half.
_TOLERANCE = 1.7
_FALL = 0.7
_NOTHING = (
    -40.0
)  # e to this is no weight at all; less would be numbers that processors are slow with
# Rest, steady speed. Lids have no steady speed: a line through a blink's two sides would only
# make it shallower.
_MAY_MOVE = np.array([[1, 1, 1, 1, 1, 1], [1, 0, 0, 1, 1, 1]])[..., None]


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


def local_linear_taps(
    apart: np.ndarray, from_now: Sequence[float], now: int, variance: np.ndarray
) -> np.ndarray:
    """How much each moment counts for the smoothed value at moment `now`, per region.

    apart: (regions, N, N), see Readings. from_now: N seconds, NaN where the moment is not to be used.
    Returns (regions, N) float64 whose rows sum to 1: the value at `now` of the straight line fitted
    by weighted least squares. So steady motion has no lag, even in a one-sided window (Fan, 1993).
    The weights fall with time, and with the distance from what `now` alone would foretell: the
    bilateral filter (Tomasi & Manduchi, 1998), about a moving centre.
    """
    plain, by_time, near = [], [], []
    for seconds in from_now:
        step = 0.0 if math.isnan(seconds) else seconds
        plain.append(step)
        by_time.append(0.0 if math.isnan(seconds) else math.exp(-0.5 * (step / _TIME_SECONDS) ** 2))
        near.append(by_time[-1] * math.exp(-0.5 * (step / _SLOPE_SECONDS) ** 2) * step)
    per_second = max(sum(a * b for a, b in zip(near, plain, strict=True)), 1e-12)
    dt, speed = np.array(plain), np.array([each / per_second for each in near])
    # Distances from a face at rest and from one at steady speed, where speed is the sum of speed[i] *
    # off[i], and off from `now`: |off - dt * speed| ** 2, multiplied out. And twice off[i] . off[j] is
    # apart[i, now] + apart[j, now] - apart[i, j].
    resting, towards = apart[:, now], apart @ speed
    own, total = towards[:, now, None], sum(speed.tolist())
    speeds = total * own - 0.5 * (towards @ speed)[:, None]
    both = np.empty((2, *resting.shape))
    both[0] = resting
    both[1] = resting * (1 - total * dt) + dt * (towards - own + dt * speeds)
    both *= (_FALL / 2) / variance[
        :, None
    ]  # in units of noise; both moments of a distance are noisy
    # A mouth that closes changes little of the patch, but its points tell.
    seen = both[:, PATCH_REGION]
    np.maximum(seen, both[:, LIPS_REGION], out=seen)
    both = np.array(by_time) * np.exp((_FALL * _TOLERANCE - both).clip(_NOTHING, 0))
    # Whichever explains more of the window: at rest, a speed would be nothing but noise.
    explained = both.sum(2, keepdims=True) * _MAY_MOVE
    weights = np.where(explained[0] >= explained[1], both[0], both[1])
    sums = weights @ np.array((np.ones_like(dt), dt, dt * dt)).T
    total, first, second = sums[:, :1], sums[:, 1:2], sums[:, 2:]
    # The tiny addition decides when only `now` has weight, and is nothing beside a frame's time.
    second = second + 1e-9 * total
    taps: np.ndarray = weights * (second - dt * first) / (total * second - first * first)
    return taps
