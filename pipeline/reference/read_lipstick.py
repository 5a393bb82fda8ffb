"""Reads how a lipstick shines and fades towards its border, with a net that sees the mouth.

The net returns both on the scales with which people labelled mouths. Gloss is 0 for matte, 1 for
satin, 2 for glossy, 3 for wet. Fade is 0 for lipstick that is even up to its border, and 2 for
lipstick that fades out there. The gloss and gradient that are painted are those for which people,
looking at painted lips, gave the same numbers (docs/decisions/reference.md).
"""

from dataclasses import dataclass

import numpy as np
from makeup_video.pipeline.faces.face import Face
from makeup_video.pipeline.faces.topology import MOUTH_CORNERS
from makeup_video.pipeline.frames.affine import AffineArray
from makeup_video.pipeline.frames.views import RgbPicture
from makeup_video.pipeline.reference.level_crop import level_place
from makeup_video.pipeline.reference.nets import LIPSTICK, reference_net

MOUTH_WH = (112, 80)  # px of the net's input
MOUTH_PX = 0.7 * MOUTH_WH[0]  # width of the mouth in the input
# The points in the middle of the lips' outer contour, above and below.
_MIDDLES = (0, 17)
# The values that the net returns, and what is painted for each. The net returns more gloss than
# people see in the same photos, and less fade when a lipstick clearly fades.
_GLOSS_RETURNED = (0.77, 1.11, 1.4, 1.68, 1.91, 2.34, 2.81)
_GLOSS = (0.0, 0.1, 0.3, 0.5, 0.75, 1.15, 1.5)
_FADE_RETURNED = (0.22, 0.38, 0.82, 1.32, 1.54)
_GRADIENT = (0.0, 0.5, 0.7, 0.9, 0.95)


@dataclass(frozen=True, slots=True)
class LipstickForm:
    """How a lipstick shines and fades: the gloss of its product, and its dial `gradient`."""

    gloss: float
    gradient: float


def read_lipstick(rgb8: np.ndarray, face: Face) -> LipstickForm:
    """The form of a face's lipstick, assuming that the face wears one.

    rgb8: (H, W, 3) uint8, R'G'B'.  Raises InstallError without the net.
    """
    gloss, fade = lipstick_numbers(rgb8, face).tolist()
    return LipstickForm(
        round(float(np.interp(gloss, _GLOSS_RETURNED, _GLOSS)), 3),
        round(float(np.interp(fade, _FADE_RETURNED, _GRADIENT)), 3),
    )


def lipstick_numbers(rgb8: np.ndarray, face: Face) -> np.ndarray:
    """(2,) gloss and fade as the net returns them: the mean over the mouth and its mirror image."""
    mouth = mouth_input(rgb8, face)
    found = reference_net(LIPSTICK)(np.stack([mouth, mouth[:, ::-1]]))["lipstick"]
    numbers: np.ndarray = found.mean(0)
    return numbers


def mouth_input(rgb8: np.ndarray, face: Face) -> np.ndarray:
    """The net's input, (80, 112, 3) uint8: the mouth, with its corners level."""
    return RgbPicture(rgb8).crop(mouth_place(face), MOUTH_WH)


def mouth_place(face: Face) -> AffineArray:
    """The affine map from px of the picture of mouth_input to px of the photo."""
    points = face.points_px[:, :2].astype(np.float64)
    left, right = points[list(MOUTH_CORNERS)]
    middle, along = (left + right) / 2, right - left
    across = np.array([-along[1], along[0]])
    below = (points[list(_MIDDLES)].mean(0) - middle) @ across / max(across @ across, 1e-9)
    centre = (MOUTH_WH[0] - 1) / 2, (MOUTH_WH[1] - 1) / 2
    return level_place(along, MOUTH_PX, middle + below * across, centre)
