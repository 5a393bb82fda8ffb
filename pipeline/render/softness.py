"""How soft a picture is at a face, so that makeup has no sharper edges than all else there."""

import math
from collections.abc import Sequence

import cv2
import numpy as np
from makeup_video.kernels.light import LightPlanes
from makeup_video.pipeline.faces.face import Face, iod_px
from makeup_video.pipeline.faces.topology import EYE_CORNERS

# Half the width and height of what is read around the middle of eyes and mouth, in IOD.
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
    unit, (high, wide) = iod_px(face), face.lips.logits.shape
    middle_xy = (face.lips.to_px @ (0.5 * wide, 0.5 * high, 1.0)).tolist()
    mouth = eyes = _more_px(light, middle_xy, _MOUTH_REACH, unit)
    if mouth:
        middle_xy = face.points_px.take(EYE_CORNERS, 0).mean(0).tolist()[:2]
        eyes = min(_more_px(light, middle_xy, _EYES_REACH, unit), mouth)
    return {"lips": mouth, "eyes": eyes}


def _more_px(
    light: LightPlanes, middle_xy: Sequence[float], reach: tuple[float, float], unit: float
) -> float:
    """The blur around a place beyond that of a sharp picture: sigma, px of the frame."""
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
    seen = luma[max(int(top), 0) : max(int(bottom), 0), max(int(left), 0) : max(int(right), 0)]
    if min(seen.shape) < _LEAST_PX:
        return 0.0
    pictures = np.empty((2, *seen.shape), np.float32)  # both at once: calls cost more than pixels
    pictures[0] = seen
    cv2.GaussianBlur(pictures[0], (_AGAIN_PX, _AGAIN_PX), _AGAIN_SIGMA, dst=pictures[1])
    first, second = _steepness(pictures[:, _BORDER_PX:-_BORDER_PX, _BORDER_PX:-_BORDER_PX])
    if float(second.max()) <= (_SEEN * float(seen.mean())) ** 2:
        return 0.0
    weight = first * second
    steeper = float(weight @ first) / float(weight @ second)
    least = 1 + (_AGAIN_SIGMA / _SOFTEST) ** 2
    return _AGAIN_SIGMA / math.sqrt(max(steeper, least) - 1) / math.sqrt(x_scale * y_scale)


def _steepness(pictures: np.ndarray) -> np.ndarray:
    """(N, px) the squares of the gradients' lengths in every second row of pictures (N, H, W)."""
    across = pictures[:, 1:-1:2, 2:] - pictures[:, 1:-1:2, :-2]
    down = pictures[:, 2::2, 1:-1] - pictures[:, :-2:2, 1:-1]
    across *= across
    down *= down
    across += down
    steepness: np.ndarray = across.reshape(len(pictures), -1)
    return steepness
