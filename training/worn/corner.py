"""Outer corners of eyes, as the net that reads eyeliner learns from them."""

from typing import NamedTuple

import numpy as np
from makeup_video.pipeline.faces.face import Face
from makeup_video.pipeline.reference.read_liner import corner_places

# Points of the upper and the lower lid, from the outer to the inner corner; eyes in the order of
# EYE_CORNERS.
_LIDS = np.array([
    [
        [33, 246, 161, 160, 159, 158, 157, 173, 133],
        [33, 7, 163, 144, 145, 153, 154, 155, 133],
    ],
    [
        [263, 466, 388, 387, 386, 385, 384, 398, 362],
        [263, 249, 390, 373, 374, 380, 381, 382, 362],
    ],
])  # fmt: skip
# What a target tells, in this order; nan where nobody knows.
NUMBERS = ("liner", "wing", "length", "angle", "thickness")


class Corner(NamedTuple):
    """rgb8: (72, 112, 3) uint8, R'G'B', the outer corner on the right.

    target: (5,) float32, as of NUMBERS: whether liner is worn (0 or 1), whether it has a wing, the
    wing's length and angle as of the net, and how thick the line is, in heights of the open eye.
    lids: (2, 9, 2) float32 px in rgb8: the edges of the upper and the lower lid, from the outer
    corner on.
    """

    rgb8: np.ndarray
    target: np.ndarray
    lids: np.ndarray


def lids_of(face: Face) -> np.ndarray:
    """(2, 2, 9, 2) float32: by eye, the edges of its lids in px of its corner's picture."""
    places, _ = corner_places(face)
    found = []
    for to_px, points in zip(places, _LIDS, strict=True):
        to_corner = np.linalg.inv(to_px[:, :2])
        found.append((face.points_px[points, :2] - to_px[:, 2]) @ to_corner.T)
    return np.float32(found)
