"""Faces that stand on their head, which the nets often take for upright ones."""

import math

from makeup_video.pipeline.faces.landmarks import FaceLandmarks, locate
from makeup_video.pipeline.faces.nets import FaceNets
from makeup_video.pipeline.faces.similarity import Similarity
from makeup_video.pipeline.frames.views import Picture

# Probabilities of a face and of a visible mouth: less in a face that may stand on its head. Of 133
# faces that were read upside down none scored 0.99, of 356 upright ones three in four did.
_SURELY_A_FACE, _MOUTH_HIDDEN = 0.99, 0.2
_MOUTH_COUNTS = 0.2  # of how much the face's own score counts: masks hide mouths, too
_MORE = 0.8  # log-odds: of 575 upright faces in masks one has 0.75 more upside down


def right_way_up(
    nets: FaceNets, picture: Picture, found: FaceLandmarks, average: bool = False
) -> FaceLandmarks:
    """The face, or the same face turned by 180 degrees where that is more of a face.

    A third of the faces that stand on their head are found as if they were upright: their eyes are
    read as eyes, and brows or forehead as nose and mouth.
    average: as of `locate`.
    """
    face, mouth = found.scores
    if face >= _SURELY_A_FACE and mouth >= _MOUTH_HIDDEN:
        return found
    around_eyes = Similarity(-found.pose.turn, found.pose.shift)
    other = locate(nets, picture, around_eyes, average)
    if other is None or not _has_eyes_within(found, other.pose):
        return found
    is_turned = (other.pose.turn / found.pose.turn).real < 0
    return other if is_turned and _evidence(other) > _evidence(found) + _MORE else found


def _evidence(found: FaceLandmarks) -> float:
    """Log-odds of a face, and a share of those of a visible mouth."""
    face, mouth = (math.log((p + 1e-6) / (1 - p + 1e-6)) for p in found.scores)
    return face + _MOUTH_COUNTS * mouth


def _has_eyes_within(found: FaceLandmarks, pose: Similarity) -> bool:
    """Whether the midpoint between the eyes of another face lies in the box around this one."""
    eyes, across, down = pose.shift, found.xy.real, found.xy.imag
    return bool(across.min() < eyes.real < across.max() and down.min() < eyes.imag < down.max())
