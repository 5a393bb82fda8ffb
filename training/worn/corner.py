"""Outer corners of eyes: the training examples of the net that reads eyeliner."""

from typing import NamedTuple

import numpy as np
from makeup_video.pipeline.faces.face import Face
from makeup_video.pipeline.faces.topology import EYE_CONTOUR, RIGHT_EYE
from makeup_video.pipeline.reference.read_liner import corner_places
from makeup_video.training.worn.packed import in_crop


def _lids(contour: np.ndarray) -> np.ndarray:
    """(2, 9) the points of the upper and the lower lid, from the outer to the inner corner.

    contour: (16,) points in the order of EYE_CONTOUR.
    """
    inner = len(contour) // 2
    return np.stack([np.append(contour[0], contour[: inner - 1 : -1]), contour[: inner + 1]])


# For each eye, in the order of EYE_CORNERS.
_LIDS = [_lids(contour) for contour in (EYE_CONTOUR, RIGHT_EYE[: len(EYE_CONTOUR)])]
# The numbers of a target, in this order; a number that nobody knows is nan.
NUMBERS = ("liner", "wing", "length", "angle", "thickness")


class Corner(NamedTuple):
    """rgb8: (72, 112, 3) uint8, R'G'B', the outer corner on the right.

    target: (5,) float32, the NUMBERS: whether liner is worn (0 or 1), whether it has a wing, the
    wing's length in widths of the eye, its angle in units of ANGLE_UNIT, and the line's thickness
    in heights of the open eye.
    lids: (2, 9, 2) float32 px in rgb8: the edges of the upper and the lower lid, from the outer
    corner on.
    """

    rgb8: np.ndarray
    target: np.ndarray
    lids: np.ndarray


def lids_of(face: Face) -> np.ndarray:
    """(2, 2, 9, 2) float32: for each eye, the edges of its lids in px of its corner's crop."""
    places, _ = corner_places(face)
    return np.stack([
        in_crop(face.points_px[points, :2], to_px)
        for to_px, points in zip(places, _LIDS, strict=True)
    ])  # fmt: skip
