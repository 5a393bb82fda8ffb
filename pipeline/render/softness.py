"""How soft a picture is at a face, so that makeup has no sharper edges than all else there."""

import math
from collections.abc import Sequence

import cv2
import numpy as np
from makeup_video.kernels.light import LightPlanes
from makeup_video.pipeline.faces.face import Face
from makeup_video.pipeline.faces.topology import EYE_CORNERS

FADE_PER_SIGMA = 3.46  # the width of a border that is as soft as a blur of sigma 1
# Half the width and height of what is read around the middle of eyes and mouth, in IOD.
_EYES_REACH, _MOUTH_REACH = (0.6, 0.2), (0.38, 0.25)
_LEAST_PX, _MOST_PX = 7.0, 200.0  # bounds of both, px of what is read
_AGAIN_SIGMA, _AGAIN_PX = 1.5, 9  # the blur that tells how blurred the picture is already
_BORDER_PX = 2  # of what is read: its blur would mirror the border
_SEEN = 0.01  # of the mean: the least difference of px two apart that counts as an edge
_SOFTEST = 6.0  # sigma, px of what is read: the blur is hardly known from there on
# Sigma up to which a picture counts as sharp, so that makeup stays as it is, in IOD and in px of
# what is read: a px has a size, too. And from how many times as much on all of the blur counts.
_SHARP, _SHARP_PX, _ALL_FROM = 0.016, 0.75, 1.3


def softness_of(light: LightPlanes, face: Face) -> dict[str, float]:
    """By how much more than a sharp picture this one is blurred where lips and eyes are painted, by
    the names of these regions: sigma, px of the frame; 0 for a sharp one.

    The strongest edges along the face, as most of those of lips and lids are, are compared with the
    same edges blurred once more (Zhuo and Sim, Defocus map estimation from a single image, 2011).
    Defocus and enlargement count, and motion up and down the face. A mouth that moves is blurred
    alone. Shut eyes have no sharp edges, so they count as the mouth does where that is sharper.
    light: the planes that light on the face is read from.
    """
    # in depth, too: a face that turns away gets narrower, and the picture no sharper
    unit = max(math.dist(*face.points_px.take(EYE_CORNERS, 0).tolist()), 1.0)
    (a, *_), (b, *_) = face.lips.to_px.tolist()
    long = max(math.hypot(a, b), 1e-9)
    right = a / long, b / long
    high, wide = face.lips.logits.shape
    middle_xy = (face.lips.to_px @ (0.5 * wide, 0.5 * high, 1.0)).tolist()
    mouth = _more_px(light, middle_xy, right, _MOUTH_REACH, unit)
    if mouth == 0:
        return {"lips": 0.0, "eyes": 0.0}
    middle_xy = face.points_px.take(EYE_CORNERS, 0).mean(0).tolist()[:2]
    eyes = _more_px(light, middle_xy, right, _EYES_REACH, unit)
    known = [one for one in (mouth, eyes) if one is not None]
    return {"lips": known[0] if known else 0.0, "eyes": min(known, default=0.0)}


def _more_px(
    light: LightPlanes,
    middle_xy: Sequence[float],
    right: tuple[float, float],
    reach: tuple[float, float],
    unit: float,
) -> float | None:
    """The blur around a place beyond that of a sharp picture: sigma, px of the frame; None where it
    is not known.

    right: unit vector to the right of the face.
    reach: half the width and height of what is read, in IOD.
    """
    x_scale, x_offset, y_scale, y_offset = light.to_luma
    scale = math.sqrt(x_scale * y_scale)
    middle = middle_xy[0] * x_scale + x_offset, middle_xy[1] * y_scale + y_offset
    wide, high = (min(max(half * unit * scale, _LEAST_PX), _MOST_PX) for half in reach)
    sigma = _sigma(light.planes[0], middle, right, (round(wide), round(high)))
    if sigma is None:
        return None
    sigma_px, sharp_px = sigma / scale, max(_SHARP * unit, _SHARP_PX / scale)
    share = min((sigma_px / sharp_px - 1) / (_ALL_FROM - 1), 1.0)  # or edges would flicker
    return share * math.sqrt(sigma_px**2 - sharp_px**2) if share > 0 else 0.0


def _sigma(
    luma: np.ndarray,
    middle_xy: tuple[float, float],
    right: tuple[float, float],
    half_size: tuple[int, int],
) -> float | None:
    """The blur of the strongest edges along the face: sigma, px; None where none is seen.

    half_size: of what is read, px.
    """
    (x, y), (cos, sin), (wide, high) = (round(place) for place in middle_xy), right, half_size
    if not (0 <= x < luma.shape[1] and 0 <= y < luma.shape[0]):
        return None
    to_luma = np.array([
        [cos, -sin, x - cos * wide + sin * high], [sin, cos, y - sin * wide - cos * high],
    ])  # fmt: skip
    # beyond the picture as at its border, which is no edge then
    seen = cv2.warpAffine(
        luma, to_luma, (2 * wide + 1, 2 * high + 1),
        flags=cv2.INTER_CUBIC | cv2.WARP_INVERSE_MAP, borderMode=cv2.BORDER_REPLICATE,
    )  # fmt: skip
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
    """(N, px) the squares of the differences of px above and below, of pictures (N, H, W)."""
    down = pictures[:, 2:] - pictures[:, :-2]
    down *= down
    steepness: np.ndarray = down.reshape(len(pictures), -1)
    return steepness
