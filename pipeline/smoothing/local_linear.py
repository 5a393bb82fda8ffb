"""Local linear regression over a short time window that leaves real motion alone."""

import math
from collections.abc import Sequence

import numpy as np
from makeup_video.pipeline.smoothing.face_space import LIPS_PART, PATCH_PART

_TIME_SECONDS = 0.12  # standard deviation of the weight by time
_SLOPE_SECONDS = 0.04  # the same for the first estimate of the speed

# Squared distances up to this multiple of what noise alone makes count as noise. For each unit
# beyond, the weight falls by half: to e to the power of -_FALL.
_TOLERANCE = 1.7
_FALL = 0.7
# e to this power counts as no weight. Smaller weights would be denormal numbers, which are slow.
_NO_WEIGHT = -40.0

# Which parts may be at rest (the first row), and which may have a steady speed (the second). Lids
# have none: a line through both sides of a blink would only make the blink shallower.
_MAY_MOVE = np.array([[1, 1, 1, 1, 1, 1, 1], [1, 0, 0, 1, 1, 1, 1]])[..., None]


def local_linear_taps(
    apart: np.ndarray, from_now: Sequence[float], now: int, variance: np.ndarray
) -> np.ndarray:
    """How much each moment counts for the smoothed value at moment `now`, per part.

    apart: (parts, N, N), see Readings. from_now: N seconds, NaN for a moment that does not count.
    Returns (parts, N) float64 whose rows sum to 1. They give the value at `now` of the straight
    line fitted by weighted least squares, so steady motion has no lag, even in a one-sided window
    (Fan, 1993). The weights fall with time, and with the distance from what `now` alone predicts:
    the bilateral filter (Tomasi & Manduchi, 1998) about a moving centre.
    """
    steps = [0.0 if math.isnan(seconds) else seconds for seconds in from_now]
    squares = [step * step for step in steps]
    by_time = [
        0.0 if math.isnan(seconds) else math.exp(-0.5 / _TIME_SECONDS**2 * square)
        for seconds, square in zip(from_now, squares, strict=True)
    ]
    nearby = [
        weight * math.exp(-0.5 / _SLOPE_SECONDS**2 * square)
        for weight, square in zip(by_time, squares, strict=True)
    ]
    dt = np.array(steps)
    near = np.array(nearby) * dt
    speed = near / max(near @ dt, 1e-12)
    # Squared distances from a face at rest, |off| ** 2, and at steady speed, |off - dt * v| ** 2,
    # multiplied out. off[i] is moment i minus `now`, v the sum of speed[i] * off[i], and
    # 2 * off[i] . off[j] = apart[i, now] + apart[j, now] - apart[i, j].
    resting, towards = apart[:, now], apart @ speed
    own, total = towards[:, now, None], sum(speed.tolist())
    speeds = total * own - 0.5 * (towards @ speed)[:, None]
    both = np.empty((2, *resting.shape))
    both[0] = resting
    both[1] = resting * (1 - total * dt) + dt * (towards - own + dt * speeds)
    # In units of the noise, halved because both moments of a distance are noisy.
    both *= (_FALL / 2) / variance[:, None]
    # A closing mouth changes little of the patch, but moves the points of the lips.
    patch = both[:, PATCH_PART]
    np.maximum(patch, both[:, LIPS_PART], out=patch)
    np.subtract(_FALL * _TOLERANCE, both, out=both)
    np.minimum(np.maximum(both, _NO_WEIGHT, out=both), 0, out=both)
    np.exp(both, out=both)
    both *= by_time
    # Take rest or speed, whichever explains more of the window: at rest, a speed is mere noise.
    explained = np.add.reduce(both, 2, keepdims=True) * _MAY_MOVE
    weights = np.where(explained[0] >= explained[1], both[0], both[1])
    sums = weights @ np.array(([1.0] * len(steps), steps, squares)).T
    total, first, second = sums[:, :1], sums[:, 1:2], sums[:, 2:]
    # The tiny addend matters only when no moment but `now` has weight: it avoids dividing 0 by 0.
    second = second + 1e-9 * total
    taps: np.ndarray = weights * (second - dt * first) / (total * second - first * first)
    return taps
