"""Similarities of the plane as complex numbers, x + iy, and the pose of a face.

A few similarities are computed for every face of every frame. On matrices of six numbers, a single
numpy call would take longer than all of this arithmetic.
"""

import cmath
import math
from typing import NamedTuple, TypeVar

import numpy as np
from makeup_video.pipeline.frames.affine import AffineArray

Points = TypeVar("Points", complex, np.ndarray)
# IOD: how far the centre of a face lies below the midpoint of its outer eye corners.
BELOW_EYES = 0.42


class Similarity(NamedTuple):
    """z -> turn * z + shift: turn, scale and shift, without reflection."""

    turn: complex = 1 + 0j
    shift: complex = 0j

    def array(self) -> AffineArray:
        """(2, 3) float64, for OpenCV."""
        turn, shift = self
        return np.array([[turn.real, -turn.imag, shift.real], [turn.imag, turn.real, shift.imag]])

    def apply(self, points: Points) -> Points:
        """Where the map leads points."""
        moved: Points = self.turn * points + self.shift
        return moved

    def after(self, first: "Similarity") -> "Similarity":
        """The map that does `first`, then this one."""
        return Similarity(self.turn * first.turn, self.apply(first.shift))

    def towards(self, other: "Similarity", share: float) -> "Similarity":
        """A map part of the way to another: this one for share 0, the other for share 1."""
        return Similarity(
            self.turn + share * (other.turn - self.turn),
            self.shift + share * (other.shift - self.shift),
        )


STAY = Similarity()

# The pose of a face is the similarity that lays the mean face, whose outer eye corners are 1 apart,
# over the face.


def middle_of(pose: Similarity) -> complex:
    """The centre of the face, px."""
    return pose.apply(complex(0, BELOW_EYES))


def iod_of(pose: Similarity) -> float:
    """The inter-ocular distance (IOD), px."""
    return abs(pose.turn)


def distance(a: Similarity, b: Similarity) -> float:
    """How far two poses differ: the largest of shift (IOD), log scale and turn (radians)."""
    ratio = b.turn / a.turn
    shift = abs(middle_of(a) - middle_of(b)) / iod_of(a)
    return max(shift, abs(math.log(max(abs(ratio), 1e-6))), abs(cmath.phase(ratio)))
