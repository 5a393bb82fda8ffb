"""How soft a picture is at a face, so that makeup has no sharper edges than all else there."""

import math
from collections.abc import Sequence

import cv2
import numpy as np
from makeup_video.kernels.light import LightPlanes
from makeup_video.pipeline.faces.face import Face, iod_px
from makeup_video.pipeline.faces.topology import EYE_CORNERS, LIPS_OUTER

# The outer corners of the eyes, and where lips are widest, highest and lowest.
_EYES, _MOUTH = np.asarray(EYE_CORNERS), LIPS_OUTER[::5]
# Half the width and height of what is read around the middle of both, in IOD.
_EYES_REACH, _MOUTH_REACH = (0.6, 0.2), (0.38, 0.25)
_AGAIN_SIGMA, _AGAIN_PX = 1.5, 9  # the blur that tells how blurred the picture is already
_BORDER_PX = 2  # of what is read: its blur would mirror the border
_LEAST_PX = 12  # of either side of what is read
_SEEN = 0.03  # of the mean: the least difference of px two apart that counts as an edge
_SOFTEST = 6.0  # sigma, px of what is read: the blur is hardly known from there on
_SHARP = 0.0125  # sigma in IOD up to which a picture counts as sharp: makeup stays as it is


def blur_of(light: LightPlanes, face: Face) -> dict[str, float]:
    """By how much more than a sharp picture this one is blurred where lips and eyes are painted, by
    the names of these regions: sigma, px of the frame; 0 for a sharp one.

    The strongest edges are compared with the same edges blurred once more (Zhuo and Sim, Defocus
    map estimation from a single image, 2011). Defocus, motion and enlargement count alike. A mouth
    that moves is blurred alone. Shut eyes have no sharp edges, so they count as the mouth does
    where that is sharper.
    light: the planes that light on the face is read from.
    """
    mouth = _more_px(light, face, _MOUTH, _MOUTH_REACH)
    eyes = min(_more_px(light, face, _EYES, _EYES_REACH), mouth) if mouth else 0.0
    return {"lips": mouth, "eyes": eyes}


def _more_px(
    light: LightPlanes, face: Face, around: np.ndarray, reach: tuple[float, float]
) -> float:
    """The blur around points of the face beyond that of a sharp picture: sigma, px of the frame."""
    unit = iod_px(face)
    middle_xy = face.points_px[around, :2].mean(0).tolist()
    sigma = _sigma_px(light, middle_xy, reach[0] * unit, reach[1] * unit)
    return math.sqrt(max(sigma**2 - (_SHARP * unit) ** 2, 0.0))


def _sigma_px(light: LightPlanes, middle_xy: Sequence[float], wide: float, high: float) -> float:
    """The blur of the strongest edges: sigma, px of the frame; 0 where no edge is seen.

    wide, high: half the width and height of what is read.
    """
    luma, (x_scale, x_offset, y_scale, y_offset) = light.planes[0], light.to_luma
    x, y = middle_xy
    left, right = ((x + side) * x_scale + x_offset for side in (-wide, wide))
    top, bottom = ((y + side) * y_scale + y_offset for side in (-high, high))
    rows = slice(max(int(top), 0), max(int(bottom), 0))
    seen = luma[rows, max(int(left), 0) : max(int(right), 0)].astype(np.float32)
    if min(seen.shape) < _LEAST_PX:
        return 0.0
    again = cv2.GaussianBlur(seen, (_AGAIN_PX, _AGAIN_PX), _AGAIN_SIGMA)
    first, second = _steepness(seen), _steepness(again)
    if float(second.max()) <= (_SEEN * float(seen.mean())) ** 2:
        return 0.0
    weight = first * second
    steeper = float(weight.ravel() @ first.ravel()) / float(weight.ravel() @ second.ravel())
    least = 1 + (_AGAIN_SIGMA / _SOFTEST) ** 2
    return _AGAIN_SIGMA / math.sqrt(max(steeper, least) - 1) / math.sqrt(x_scale * y_scale)


def _steepness(picture: np.ndarray) -> np.ndarray:
    """The squares of the gradients' lengths, without the border."""
    picture = picture[_BORDER_PX:-_BORDER_PX, _BORDER_PX:-_BORDER_PX]
    across: np.ndarray = picture[1:-1, 2:] - picture[1:-1, :-2]
    down = picture[2:, 1:-1] - picture[:-2, 1:-1]
    across *= across
    down *= down
    across += down
    return across
