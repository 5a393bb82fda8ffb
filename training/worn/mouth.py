"""Mouths: the training examples of the net that reads how lipstick shines and fades."""

from typing import NamedTuple

import numpy as np
from makeup_video.pipeline.faces.face import Face
from makeup_video.pipeline.reference.read_lipstick import mouth_place
from makeup_video.pipeline.render.surfaces.lips import LIP_RINGS
from makeup_video.training.worn.packed import in_crop

# The outer and the inner contour of the upper lip, then those of the lower lip, (4, 11) points.
_CONTOURS = LIP_RINGS[[0, 3, 4, 7]]
NUMBERS = ("gloss", "fade")  # of a target, on the scales of read_lipstick.py


class Mouth(NamedTuple):
    """rgb8: (80, 112, 3) uint8, R'G'B', a crop that mouth_input cuts.

    target: (2,) float32, the NUMBERS.  contours: (4, 11, 2) float32 px of rgb8, from one corner of
    the mouth to the other: the outer and the inner contour of the upper lip, then of the lower.
    """

    rgb8: np.ndarray
    target: np.ndarray
    contours: np.ndarray


def contours_of(face: Face) -> np.ndarray:
    """(4, 11, 2) float32: the contours of the lips in px of the mouth's crop."""
    return in_crop(face.points_px[_CONTOURS, :2], mouth_place(face))
