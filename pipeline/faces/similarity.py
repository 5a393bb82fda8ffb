"""Turns, scales and shifts of the plane in plain complex numbers, x + iy.

A few of them are reckoned for every face of every frame, where each numpy call on a matrix of six
numbers takes longer than all that is reckoned here together.
"""

import cmath
import math
from typing import NamedTuple, TypeVar

import numpy as np

Places = TypeVar("Places", complex, np.ndarray)


class Similarity(NamedTuple):
    """z -> turn * z + shift: without reflection."""

    turn: complex = 1 + 0j
    shift: complex = 0j

    def of(self, places: Places) -> Places:
        """Where places lie after it."""
        moved: Places = self.turn * places + self.shift
        return moved

    def after(self, first: "Similarity") -> "Similarity":
        """The map that does `first`, then this."""
        return Similarity(self.turn * first.turn, self.of(first.shift))

    def towards(self, other: "Similarity", share: float) -> "Similarity":
        """A part of the way to another."""
        return Similarity(
            self.turn + share * (other.turn - self.turn),
            self.shift + share * (other.shift - self.shift),
        )


STAY = Similarity()


def from_matrix(matrix: np.ndarray) -> Similarity:
    """Of a (2, 3) matrix that is a similarity."""
    (a, _, x), (c, _, y) = matrix.tolist()
    return Similarity(complex(a, c), complex(x, y))


# -- Face frames: they lay the mean face, whose outer eye corners are 1 apart, over a face.

BELOW_EYES = 0.42  # IOD: the middle of a face is so far below the middle of the eyes


def middle_of(frame: Similarity) -> complex:
    """px: the middle of a face."""
    return frame.of(complex(0, BELOW_EYES))


def iod_of(frame: Similarity) -> float:
    """The inter-ocular distance in px."""
    return abs(frame.turn)


def distance(a: Similarity, b: Similarity) -> float:
    """The largest of shift (IOD), log scale and turn (radians) between two face frames."""
    ratio = b.turn / a.turn
    shift = abs(middle_of(a) - middle_of(b)) / iod_of(a)
    return max(shift, abs(math.log(max(abs(ratio), 1e-6))), abs(cmath.phase(ratio)))
