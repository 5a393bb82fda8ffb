"""What a surface of the face tells a kind of makeup: where each place of it lies on the face.

Arrays are float32 and may be broadcast against each other to (N, H, W): the places on the grids of
N surfaces of one sort, such as both eyes.
"""

from dataclasses import dataclass

import numpy as np

LID_RISE_AT = 0.72  # across, where the lash line turns down to the outer corner
LID = 0.22  # of the eye's width: height of a usual lid, the unit of heights below the eye


@dataclass(frozen=True, slots=True, eq=False)
class LipsFields:
    """inward: 0 at the lips' outer border, 1 where the lips meet or the mouth opens."""

    inward: np.ndarray


@dataclass(frozen=True, slots=True, eq=False)
class EyeFields:
    """Both eyes; lengths in px of the frame.

    across: 0 at the inner corner, 1 at the outer one, in widths of the eye.
    height: above the eye 0 at the upper lash line, 1 in the crease, 2 below the brow; below the eye
    0 at the lower lash line and -1 a lid's usual height (LID) further down.
    above_px: above the upper lash line, negative below it.  below_px: below the lower lash line,
    negative above it.  rise_px: above the line through both corners of the eye.  lid_rise_px: the
    same of the upper lash line at LID_RISE_AT.
    width_px: of the eye.
    """

    across: np.ndarray
    height: np.ndarray
    above_px: np.ndarray
    below_px: np.ndarray
    rise_px: np.ndarray
    lid_rise_px: np.ndarray
    width_px: np.ndarray


@dataclass(frozen=True, slots=True, eq=False)
class FaceFields:
    """The mean face's own coordinates, in distances of the outer eye corners.

    across: from the middle of the face, negative on the picture's left.  down: from the line
    through the eye corners.
    """

    across: np.ndarray
    down: np.ndarray
