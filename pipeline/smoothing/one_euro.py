"""The One-Euro filter, for many numbers at once, which move together in parts."""

import math

import numpy as np

# Squared speeds up to this multiple of what noise alone makes count as rest. Noise that moves a
# whole part at once varies by about its own size from moment to moment.
_TOLERANCE = 2.5
# Variance of the difference between the newest and the filtered value, in units of the noise's
# variance: 1 for the newest value, and some more for the filtered value.
_DIFFERENCE = 1.5
_MIN_CUTOFF_HZ = 1.0  # at rest
_RISE_HZ = 20.0  # how much the cutoff rises for each unit of speed
# Cutoff of the low-pass filter of the speed. It is well above the paper's 1 Hz, with which a blink
# would be over before its speed counts.
_SPEED_CUTOFF_HZ = 15.0


class OneEuro:
    """A low-pass filter whose cutoff rises with speed: steady at rest, prompt in motion.

    Casiez, Roussel and Vogel, "1 Euro Filter: A Simple Speed-based Low-pass Filter for Noisy Input
    in Interactive Systems", CHI 2012. Two things differ. The speed is that of a part: the root
    mean square over its columns. And its unit is the speed that noise alone would show, so that one
    setting suits a sharp face and a blurred one.
    """

    def __init__(self, starts: np.ndarray, counts: np.ndarray) -> None:
        """starts: (R,) first column of each part.

        counts: (R,) divisor of each part's sum of squares.
        """
        self._starts, self._counts = starts, counts
        self._value: np.ndarray | None = None
        self._speed = np.zeros(0)

    def __call__(self, x: np.ndarray, step_seconds: float, variance: np.ndarray) -> np.ndarray:
        """How much the newest value counts in each part, (R,) in (0, 1]; 1 at the first call.

        x: (K,) float64. step_seconds: since the last call, more than 0. variance: (R,), of the
        noise of x.
        """
        if self._value is None:
            self._value, self._speed = x.copy(), np.zeros_like(x)
            return np.ones(len(self._starts))
        off = x - self._value
        share = float(_share(_SPEED_CUTOFF_HZ, step_seconds))
        self._speed += share * (off / step_seconds - self._speed)
        squares = np.add.reduceat(self._speed * self._speed, self._starts) / self._counts
        noise = variance * (_DIFFERENCE / step_seconds**2 * share / (2 - share))
        units = np.maximum(np.sqrt(squares / noise) - math.sqrt(_TOLERANCE), 0)
        shares = _share(_MIN_CUTOFF_HZ + _RISE_HZ * units, step_seconds)
        widths = np.diff(self._starts, append=len(x))
        self._value += np.repeat(shares, widths) * off
        return shares


def _share(cutoff_hz: "float | np.ndarray", step_seconds: float) -> np.ndarray:
    """The weight of the newest value in a first-order low-pass filter."""
    radians = 2 * math.pi * step_seconds * np.asarray(cutoff_hz, np.float64)
    share: np.ndarray = radians / (1 + radians)
    return share
