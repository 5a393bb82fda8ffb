"""How soft a picture is at a face, so that makeup has no sharper edges than all else there."""

import math
from collections.abc import Sequence

import cv2
import numpy as np
from makeup_video.kernels.light import LightPlanes
from makeup_video.pipeline.faces.face import Face
from makeup_video.pipeline.faces.topology import EYE_CORNERS

WINDOW_PER_SIGMA = 3.46  # the width of a window, or of a ramp, that is as soft as a blur of sigma 1
# Half the width and height of what is read around the middle of eyes and mouth, in IOD.
_EYES_REACH, _MOUTH_REACH = (0.6, 0.2), (0.38, 0.25)
_AGAIN_SIGMA, _AGAIN_PX = 1.5, 9  # the blur that tells how blurred the picture is already
_BORDER_PX = 2  # of what is read: its blur would mirror the border
_LEAST_PX = 14.0  # of either side of what is read
_SEEN = 0.03  # of the mean: the least difference of px two apart that counts as an edge
_SOFTEST = 6.0  # sigma, px of what is read: the blur is hardly known from there on
# Sigma up to which a picture counts as sharp, so that makeup stays as it is, in IOD and in px of
# what is read: a px has a size, too. And from how many times as much on all of the blur counts.
_SHARP, _SHARP_PX, _ALL_FROM = 0.016, 0.75, 1.3


def blur_of(light: LightPlanes, face: Face) -> dict[str, float]:
    """By how much more than a sharp picture this one is blurred where lips and eyes are painted, by
    the names of these regions: sigma, px of the frame; 0 for a sharp one.

    The strongest edges are compared with the same edges blurred once more (Zhuo and Sim, Defocus
    map estimation from a single image, 2011). Defocus, motion and enlargement count alike. A mouth
    that moves is blurred alone. Shut eyes have no sharp edges, so they count as the mouth does
    where that is sharper.
    light: the planes that light on the face is read from.
    """
    # in depth, too: a face that turns away gets narrower, and the picture no sharper
    unit = max(math.dist(*face.points_px.take(EYE_CORNERS, 0).tolist()), 1.0)
    (a, *_), (b, *_) = face.lips.to_px.tolist()
    along = abs(a) / max(math.hypot(a, b), 1e-9), abs(b) / max(math.hypot(a, b), 1e-9)
    high, wide = face.lips.logits.shape
    middle_xy = (face.lips.to_px @ (0.5 * wide, 0.5 * high, 1.0)).tolist()
    mouth = _more_px(light, middle_xy, _MOUTH_REACH, along, unit)
    if mouth == 0:
        return {"lips": 0.0, "eyes": 0.0}
    middle_xy = face.points_px.take(EYE_CORNERS, 0).mean(0).tolist()[:2]
    eyes = _more_px(light, middle_xy, _EYES_REACH, along, unit)
    known = [one for one in (mouth, eyes) if one is not None]
    return {"lips": mouth or 0.0, "eyes": min(known, default=0.0)}


def _more_px(
    light: LightPlanes,
    middle_xy: Sequence[float],
    reach: tuple[float, float],
    along: tuple[float, float],
    unit: float,
) -> float | None:
    """The blur around a place beyond that of a sharp picture: sigma, px of the frame; None where it
    is not known.

    reach: see above.  along: shares of x and y in the face's own horizontal.
    """
    x_scale, _, y_scale, _ = light.to_luma
    scale = math.sqrt(x_scale * y_scale)
    half_wide, half_high = (max(half * unit, 0.5 * _LEAST_PX / scale) for half in reach)
    cos, sin = along
    sigma = _sigma(
        light, middle_xy, cos * half_wide + sin * half_high, sin * half_wide + cos * half_high
    )
    if sigma is None:
        return None
    sigma_px, sharp_px = sigma / scale, max(_SHARP * unit, _SHARP_PX / scale)
    share = min((sigma_px / sharp_px - 1) / (_ALL_FROM - 1), 1.0)  # or edges would flicker
    return share * math.sqrt(sigma_px**2 - sharp_px**2) if share > 0 else 0.0


def _sigma(
    light: LightPlanes, middle_xy: Sequence[float], wide: float, high: float
) -> float | None:
    """The blur of the strongest edges: sigma, px of the plane; None where no edge is seen.

    wide, high: half the width and height of what is read, px of the frame.
    """
    luma, (x_scale, x_offset, y_scale, y_offset) = light.planes[0], light.to_luma
    x, y = middle_xy
    left, right = (max(int((x + side) * x_scale + x_offset), 0) for side in (-wide, wide))
    top, bottom = (max(int((y + side) * y_scale + y_offset), 0) for side in (-high, high))
    seen = luma[top:bottom, left:right]
    if min(seen.shape) < 0.7 * _LEAST_PX:  # the picture ends there
        return None
    pictures = np.empty((2, *seen.shape), np.float32)  # both at once: calls cost more than pixels
    pictures[0] = seen
    cv2.GaussianBlur(pictures[0], (_AGAIN_PX, _AGAIN_PX), _AGAIN_SIGMA, dst=pictures[1])
    first, second = _steepness(pictures[:, _BORDER_PX:-_BORDER_PX, _BORDER_PX:-_BORDER_PX])
    weight = first * second
    divisor = float(weight @ second)
    # an edge of the border alone has no weight
    if divisor <= 0 or float(second.max()) <= (_SEEN * float(seen.mean())) ** 2:
        return None
    least = 1 + (_AGAIN_SIGMA / _SOFTEST) ** 2
    return _AGAIN_SIGMA / math.sqrt(max(float(weight @ first) / divisor, least) - 1)


def _steepness(pictures: np.ndarray) -> np.ndarray:
    """(N, px) the squares of the gradients' lengths in every second row of pictures (N, H, W)."""
    across = pictures[:, 1:-1:2, 2:] - pictures[:, 1:-1:2, :-2]
    down = pictures[:, 2::2, 1:-1] - pictures[:, :-2:2, 1:-1]
    across *= across
    down *= down
    across += down
    steepness: np.ndarray = across.reshape(len(pictures), -1)
    return steepness
