"""Regression over a short window of time that lets go where something really happens."""

import math

import numpy as np
from makeup_video.pipeline.face_frame import LIPS_REGION, PATCH_REGION, POSE_REGION, FaceSpace

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
# Rows: rest, steady speed. Lids have no steady speed: a line through a blink's two sides would only
# make it shallower.
_MAY_MOVE = np.array([[1, 1, 1, 1, 1, 1], [1, 0, 0, 1, 1, 1]])


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

    def hear(self, space: FaceSpace, keys: np.ndarray, seconds: np.ndarray) -> None:
        """keys: (N, K) of the last N moments, in any order; seconds: (N,), all different."""
        # A new estimate shares four moments of five with the one before: every other will do,
        # once there are some.
        self._moments += 1
        skipped = self._moments > 2 * HEARD_MOMENTS and self._moments % 2
        if skipped or len(seconds) < 3 or np.ptp(seconds) > _HEARD_SECONDS:
            return
        # Newton's divided difference: 0 for every polynomial of degree N - 2, whatever the times.
        apart = seconds[:, None] - seconds
        np.fill_diagonal(apart, 1)
        shares = 1 / apart.prod(1)
        off = (shares / math.sqrt(shares @ shares)).astype(np.float32) @ keys
        self._heard[self._count % _KEPT] = (
            np.add.reduceat(off * off, space.key_starts) / space.key_counts
        )
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
    space: FaceSpace, keys: np.ndarray, from_now: np.ndarray, now: int, variance: np.ndarray
) -> np.ndarray:
    """How much each moment counts for the smoothed value at moment `now`, per region.

    keys: (N, K). from_now: (N,) seconds, NaN where the moment is not to be used. Returns (N,
    regions) float64 whose columns sum to 1: the value at `now` of the straight line fitted by
    weighted least squares. So steady motion has no lag, even in a one-sided window (Fan, 1993).
    The weights fall with time, and with the distance from what `now` alone would foretell: the
    bilateral filter (Tomasi & Manduchi, 1998), about a moving centre.
    """
    used = np.isfinite(from_now)
    dt = np.where(used, from_now, 0.0)
    by_time = used * np.exp(-0.5 * (dt / _TIME_SECONDS) ** 2)
    near = by_time * np.exp(-0.5 * (dt / _SLOPE_SECONDS) ** 2) * dt
    off = keys - keys[now]
    speed = (near / max(float(near @ dt), 1e-12)).astype(np.float32) @ off
    scale = 1 / (2 * space.key_counts * variance)  # both moments of a distance are noisy
    # Distances from a face at rest and from one at steady speed: |off - dt * speed| ** 2,
    # multiplied out.
    resting = np.add.reduceat(off * off, space.key_starts, 1) * scale
    along = np.add.reduceat(off * speed, space.key_starts, 1) * scale
    speeds = np.add.reduceat(speed * speed, space.key_starts) * scale
    dt = dt[:, None]
    distances = np.array((resting, resting + dt * (dt * speeds - 2 * along)))
    # A mouth that closes changes little of the patch, but its points tell.
    seen = distances[..., PATCH_REGION]
    distances[..., PATCH_REGION] = np.maximum(seen, distances[..., LIPS_REGION])
    excess = np.maximum(distances - _TOLERANCE, 0)
    both = by_time[:, None] * np.exp(-_FALL * excess)
    # Whichever explains more of the window: at rest, a speed would be nothing but noise.
    explained = both.sum(1) * _MAY_MOVE
    weights = np.where(explained[0] >= explained[1], both[0], both[1])
    total, first = explained.max(0), (dt * weights).sum(0)
    # The tiny addition decides when only `now` has weight, and is nothing beside a frame's time.
    second = (dt * dt * weights).sum(0) + 1e-9 * total
    taps: np.ndarray = weights * (second - dt * first) / (total * second - first * first)
    return taps
