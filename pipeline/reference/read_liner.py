"""Reads the form of an eyeliner, with a net that sees the outer corner of each eye.

The net of the whole face sees an eye so small that a line is a pixel or two wide. On real photos,
what that net returns for the form of eyeliner is chance (docs/decisions/reference.md).
"""

from dataclasses import dataclass

import numpy as np
from makeup_video.pipeline.faces.face import Face
from makeup_video.pipeline.faces.topology import EYE, EYE_CORNERS, RIGHT_EYE
from makeup_video.pipeline.frames.views import RgbPicture
from makeup_video.pipeline.reference.level_crop import level_place
from makeup_video.pipeline.reference.nets import LINER, reference_net
from makeup_video.pipeline.reference.product_film import ramp

CORNER_WH = (112, 72)  # px of the net's input
CORNER_XY = (70.0, 42.0)  # place of the eye's outer corner in the input
EYE_PX = 64.0  # width of the eye in the input
ANGLE_UNIT = 60.0  # this angle, in degrees, is 1 for the net
# The inner corners, in the order of EYE_CORNERS.
_INNER = [EYE[8], RIGHT_EYE[8]]
# An eye that is narrower than this share of the other one is turned away, and does not count.
_TURNED_AWAY = 0.8
# Log-odds from which a wing is read; in real photos few eyes without a wing reach them. They are
# higher with eyeshadow, since smoky eyeshadow ("smoke") may end in a point, too. _SMOKE: the
# probabilities of eyeshadow between which they rise.
_WING_FROM, _WING_IN_SMOKE_FROM = 0.75, 1.2
_SMOKE = 0.9, 0.98
_SURE_FROM = 3.5  # from these log-odds on, a dark place beside the corner is a wing, not smoke
# These correct what the net returns, which varies less than what people see.
_LONGER = 1.2
_THICKER, _THINNER = 1.74, 0.1
_THINNEST = 0.03
_LOWEST_ANGLE = -0.5  # in ANGLE_UNIT, the least value of the dial


@dataclass(frozen=True, slots=True)
class Wing:
    """The dials of eyeliner that describe its wing.

    length: in widths of the eye.  angle: degrees.  is_sure: the wing cannot be smoky eyeshadow.
    """

    length: float
    angle: float
    is_sure: bool = False


@dataclass(frozen=True, slots=True)
class LinerForm:
    """The dials of eyeliner that describe its form.

    thickness: in heights of the open eye.  wing: None when no wing is seen.
    """

    thickness: float
    wing: Wing | None = None


def read_liner(rgb8: np.ndarray, face: Face, eyeshadow: float = 0.0) -> LinerForm:
    """The form of a face's eyeliner, assuming that the face wears one.

    rgb8: (H, W, 3) uint8, R'G'B'.  eyeshadow: the probability that eyeshadow is worn, too.
    Raises InstallError without the net.
    """
    log_odds, length, angle, thickness = liner_numbers(rgb8, face).tolist()
    wing = None
    smoke = ramp(eyeshadow, _SMOKE)
    if log_odds >= _WING_FROM + smoke * (_WING_IN_SMOKE_FROM - _WING_FROM):
        length, angle = min(max(_LONGER * length, 0.0), 1.0), min(max(angle, _LOWEST_ANGLE), 1.0)
        wing = Wing(round(length, 3), round(ANGLE_UNIT * angle, 1), log_odds >= _SURE_FROM)
    thickness = min(max(_THICKER * thickness - _THINNER, _THINNEST), 1.0)
    return LinerForm(round(thickness, 3), wing)


def liner_numbers(rgb8: np.ndarray, face: Face) -> np.ndarray:
    """(4,) what the net returns, as the mean over the eyes that are not turned away.

    Log-odds of a wing, the wing's length, its angle in ANGLE_UNIT, and the line's thickness.
    """
    inputs, widths_px = corner_inputs(rgb8, face)
    found = reference_net(LINER)(inputs)["liner"]
    seen = widths_px >= _TURNED_AWAY * widths_px.max()
    numbers: np.ndarray = found[seen].mean(0)
    return numbers


def corner_inputs(rgb8: np.ndarray, face: Face) -> tuple[np.ndarray, np.ndarray]:
    """The outer corners of both eyes, (2, 72, 112, 3) uint8, and the widths of the eyes, (2,) px.

    Each eye is turned so that its corners lie level, with the outer one on the right. For this the
    first eye is mirrored.
    """
    picture = RgbPicture(rgb8)
    places, widths_px = corner_places(face)
    return np.stack([picture.crop(to_px, CORNER_WH) for to_px in places]), widths_px


def corner_places(face: Face) -> tuple[np.ndarray, np.ndarray]:
    """Where the pictures of corner_inputs lie, and the widths of the eyes, (2,) px.

    The places are affine maps, (2, 2, 3), from px of the pictures to px of the photo.
    """
    outer = face.points_px[list(EYE_CORNERS), :2].astype(np.float64)
    along = outer - face.points_px[_INNER, :2]
    widths_px = np.maximum(np.hypot(*along.T), 1.0)
    places = [
        level_place(line, EYE_PX, corner, CORNER_XY, is_mirrored=is_mirrored)
        for line, corner, is_mirrored in zip(along, outer, (True, False), strict=True)
    ]
    return np.stack(places), widths_px
