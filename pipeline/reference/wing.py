"""Reads the wing of an eyeliner, with a net that sees the outer corner of each eye.

As the net of the whole face sees an eye, a wing is a few pixels: what it returned for wings on real
photos was chance (docs/decisions/reference.md).
"""

from dataclasses import dataclass

import numpy as np
from makeup_video.pipeline.faces.face import Face
from makeup_video.pipeline.faces.topology import EYE_CORNERS
from makeup_video.pipeline.frames.views import RgbPicture
from makeup_video.pipeline.reference.nets import WING, reference_net

CORNER_WH = (112, 72)  # px of the net's input
CORNER_XY = (70.0, 42.0)  # where the outer corner of the eye lies in it
EYE_PX = 64.0  # width of the eye there
ANGLE_UNIT = 60.0  # degrees that are 1 for the net
# The inner corners, in the order of EYE_CORNERS.
_INNER = (133, 362)
# An eye that is narrower than this share of the other one is turned away, and does not count.
_TURNED_AWAY = 0.8
WING_FROM = 0.6  # log-odds: on real photos few eyes without a wing reach it
_SURE_FROM = 2.0  # from here on what is dark beside the corner is the wing, not smoke


@dataclass(frozen=True, slots=True)
class Wing:
    """The dials of eyeliner that describe its wing: length in widths of the eye, and degrees.

    is_sure: a wing that cannot be smoke.
    """

    length: float
    angle: float
    is_sure: bool = False


def read_wing(rgb8: np.ndarray, face: Face) -> Wing | None:
    """The wing of a face's eyeliner, None where none is seen.

    rgb8: (H, W, 3) uint8, R'G'B'.  Raises InstallError without the net.
    """
    log_odds, length, angle = wing_numbers(rgb8, face)
    if log_odds < WING_FROM:
        return None
    length, angle = np.clip((length, angle), 0, 1).tolist()
    return Wing(round(length, 3), round(ANGLE_UNIT * angle, 1), log_odds >= _SURE_FROM)


def wing_numbers(rgb8: np.ndarray, face: Face) -> tuple[float, float, float]:
    """Log-odds of a wing, and its length and angle as of the net's training."""
    inputs, widths_px = corner_inputs(rgb8, face)
    found = reference_net(WING)(inputs)["wing"]
    seen = widths_px >= _TURNED_AWAY * widths_px.max()
    log_odds, length, angle = found[seen].mean(0).tolist()
    return log_odds, length, angle


def corner_inputs(rgb8: np.ndarray, face: Face) -> tuple[np.ndarray, np.ndarray]:
    """The outer corners of both eyes, (2, 72, 112, 3) uint8, and the widths of the eyes, (2,) px.

    Every eye is turned so that its corners lie level, the outer one on the right.
    """
    picture = RgbPicture(rgb8)
    outer = face.points_px[list(EYE_CORNERS), :2].astype(np.float64)
    along = outer - face.points_px[list(_INNER), :2]
    widths_px = np.maximum(np.hypot(*along.T), 1.0)
    inputs = []
    for corner, right, side in zip(outer, along / EYE_PX, (-1, 1), strict=True):
        down = side * np.array([-right[1], right[0]])  # of an eye that is mirrored, or not
        linear = np.column_stack([right, down])
        to_px = np.column_stack([linear, corner - linear @ CORNER_XY])
        inputs.append(picture.crop(to_px, CORNER_WH))
    return np.stack(inputs), widths_px
