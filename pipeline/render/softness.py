"""How soft a picture is at a face, so that makeup's edges are no sharper than the rest of it."""

import math
from collections.abc import Sequence

import cv2
import numpy as np
from makeup_video.kernels.light import LightPlanes
from makeup_video.pipeline.faces.face import Face
from makeup_video.pipeline.faces.topology import EYE_CORNERS

FADE_PER_SIGMA = 3.46  # the width of a border that is as soft as a blur of sigma 1
# A rectangle of the luma plane is read around the middle of the eyes and of the mouth: half its
# width and height in IOD.
_EYES_REACH, _MOUTH_REACH = (0.6, 0.2), (0.38, 0.25)
_LEAST_PX, _MOST_PX = 7.0, 200.0  # bounds of these halves, px of the plane
_AGAIN_SIGMA, _AGAIN_PX = 1.5, 9  # sigma and width of a second blur, which reveals the first
_BORDER_PX = 2  # px of the rectangle's border that do not count: the second blur mirrors there
_SEEN = 0.01  # share of the mean luma: the least difference of px two rows apart that is an edge
_SOFTEST = 6.0  # sigma, px of the plane: a larger blur can hardly be measured
# Up to this sigma a picture counts as sharp, and its makeup stays as it is: _SHARP in IOD, or
# _SHARP_PX in px of the plane where that is more, since a px has a size, too. From _ALL_FROM times
# this sigma on, all of the blur counts.
_SHARP, _SHARP_PX, _ALL_FROM = 0.016, 0.75, 1.3


def softness_of(light: LightPlanes, face: Face) -> dict[str, float]:
    """How much more blurred than a sharp picture this one is at the lips and at the eyes.

    Returns a sigma in px of the frame for each of these regions, by name; 0 for a sharp picture.

    The strongest edges across the face, as most edges of lips and lids are, are compared with the
    same edges blurred once more (Zhuo and Sim, Defocus map estimation from a single image, 2011).
    So defocus, enlargement and motion up and down the face count. A moving mouth does not blur the
    eyes. Shut eyes have no sharp edges, so they get the mouth's sigma where it is smaller.
    light: the planes that the light on the face is read from.
    """
    # measured in depth, too: a face that turns away gets narrower, but the picture no sharper
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
    """How much more blurred than a sharp picture a place is: sigma, px of the frame.

    None where the blur is not known.
    right: unit vector to the right of the face.
    reach: half the width and height of the rectangle that is read, in IOD.
    """
    x_scale, x_offset, y_scale, y_offset = light.to_luma
    scale = math.sqrt(x_scale * y_scale)
    middle = middle_xy[0] * x_scale + x_offset, middle_xy[1] * y_scale + y_offset
    wide, high = (min(max(half * unit * scale, _LEAST_PX), _MOST_PX) for half in reach)
    sigma = _sigma(light.planes[0], middle, right, (round(wide), round(high)))
    if sigma is None:
        return None
    sigma_px, sharp_px = sigma / scale, max(_SHARP * unit, _SHARP_PX / scale)
    share = min((sigma_px / sharp_px - 1) / (_ALL_FROM - 1), 1.0)  # a step would flicker
    return share * math.sqrt(sigma_px**2 - sharp_px**2) if share > 0 else 0.0


def _sigma(
    luma: np.ndarray,
    middle_xy: tuple[float, float],
    right: tuple[float, float],
    half_size: tuple[int, int],
) -> float | None:
    """The blur of the strongest edges across the face: sigma, px; None where no edge is seen.

    half_size: half the width and height of the rectangle that is read, px.
    """
    (x, y), (cos, sin), (wide, high) = (round(place) for place in middle_xy), right, half_size
    if not (0 <= x < luma.shape[1] and 0 <= y < luma.shape[0]):
        return None
    to_luma = np.array([
        [cos, -sin, x - cos * wide + sin * high], [sin, cos, y - sin * wide - cos * high],
    ])  # fmt: skip
    # the picture's border is repeated, so that the border itself is no edge
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
    # weights are 0 where only the second blur brings in an edge from beyond the border
    if divisor <= 0 or float(second.max()) <= (_SEEN * float(seen.mean())) ** 2:
        return None
    least = 1 + (_AGAIN_SIGMA / _SOFTEST) ** 2
    return _AGAIN_SIGMA / math.sqrt(max(float(weight @ first) / divisor, least) - 1)


def _steepness(pictures: np.ndarray) -> np.ndarray:
    """Pictures (N, H, W) -> (N, px): the squared difference between the px above and below each."""
    down = pictures[:, 2:] - pictures[:, :-2]
    down *= down
    steepness: np.ndarray = down.reshape(len(pictures), -1)
    return steepness
