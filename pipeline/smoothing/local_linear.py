"""Regression over a short window of time that lets go where something really happens."""

import math
from collections.abc import Sequence

import numpy as np
from makeup_video.pipeline.smoothing.face_space import LIPS_REGION, PATCH_REGION

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
