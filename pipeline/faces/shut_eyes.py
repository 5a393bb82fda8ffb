"""Makes the lids of a shut eye meet.

The eye net learned from MediaPipe's points, which leave the lids of a shut eye apart by up to a
seventh of the eye's width. Shadow and liner above and below would leave a slit of bare lid there.
So where the lids lie close together, a logistic model of the eye's points and of the colours on and
around the slit decides whether the eye is shut (training/faces/fit_shut_eyes.py).
"""

import cv2
import numpy as np
from makeup_video.pipeline.faces.topology import EYE, EYE_CONTOUR

# Opening in widths of the eye. From the first on an eye is open; below the second the model alone
# decides.
_OPEN, _NARROW = 0.2, 0.16
# Log-odds up to which lids stay where they are, and from which on they meet.
_STAY, _MEET = -0.5, 1.5
_TOGETHER = 0.5  # weight of the other eye's log-odds: eyes blink together
_MEETING_LINE = 0.7  # where lids meet, as a share of the way from the upper to the lower lid
_LID = slice(0, len(EYE_CONTOUR))  # places in EYE
_LOWER = slice(1, 8)  # from the outer to the inner corner, without the corners
_UPPER = slice(15, 8, -1)  # likewise
# Rows on which colours are read: on the skin above the upper and below the lower lid, at distances
# in widths of the eye, and between the lids, at shares of the way.
_BESIDE = np.array([0.09, 0.18])
_BETWEEN = np.linspace(0, 1, 6)
_DARKEST = 8.0  # added to code values before taking logarithms: darker codes are noise
_COLOURS = np.array([[0.3, 1, 0], [0.59, -1, -1], [0.11, 0, 1]])  # brightness, red, blue
_PLACES = 2 * len(EYE)
NUMBERS = _PLACES + 1 + 3 * (len(_BETWEEN) + 2 * len(_BESIDE)) * 7


def close_shut_eyes(
    points: np.ndarray, crops: np.ndarray, weights: np.ndarray, span: float
) -> None:
    """Let the lids of shut eyes meet, in place.

    points: (N, 53, 3) of EYE, in IOD from the middle of the crop. crops: (N, H, W, 3) uint8,
    R'G'B', of eyes at the left of the face, or mirrored eyes at its right. weights: (NUMBERS + 1,)
    of the model, the constant last. span: width of a crop in IOD.
    """
    # how much the model decides: 0 for an open eye, 1 for a narrow one
    narrow = [min(max((_OPEN - opening_of(eye)) / (_OPEN - _NARROW), 0.0), 1.0) for eye in points]
    if not any(narrow):
        return
    odds = [
        float(weights[:-1] @ numbers_of(eye, crop, span) + weights[-1]) if share else 0.0
        for eye, crop, share in zip(points, crops, narrow, strict=True)
    ]
    together = sum(own * share for own, share in zip(odds, narrow, strict=True))
    for eye, own, share in zip(points, odds, narrow, strict=True):
        sure = own + _TOGETHER * (together - own * share)
        share *= min(max((sure - _STAY) / (_MEET - _STAY), 0.0), 1.0)
        upper, lower = eye[_UPPER], eye[_LOWER]
        meet = upper + _MEETING_LINE * (lower - upper)
        eye[_UPPER] = upper + share * (meet - upper)
        eye[_LOWER] = lower + share * (meet - lower)


def opening_of(eye: np.ndarray) -> float:
    """How far an eye (53, 3) is open, in widths of the eye."""
    return float((eye[_LOWER, 1] - eye[_UPPER, 1]).max()) / _width(eye)


def numbers_of(eye: np.ndarray, crop: np.ndarray, span: float) -> np.ndarray:
    """The numbers that the model reads, (NUMBERS,).

    They are the points, in widths of the eye from the middle of its lids; the opening; and the
    logarithms of colours less those of the skin around.
    """
    numbers = np.empty(NUMBERS)
    places, colours = numbers[:_PLACES].reshape(-1, 2), numbers[_PLACES + 1 :]
    places[:] = eye[:, :2] - eye[_LID, :2].sum(0) * (1 / _LID.stop)
    places *= 1 / _width(eye)
    numbers[_PLACES] = opening_of(eye)
    colours[:] = _colours(eye, crop, span).ravel()
    return numbers


def _width(eye: np.ndarray) -> float:
    x, y = (eye[8, :2] - eye[0, :2]).tolist()
    return max(float(np.hypot(x, y)), 1e-6)


def _colours(eye: np.ndarray, crop: np.ndarray, span: float) -> np.ndarray:
    """Log colours relative to the skin, (10, 7, 3): from above the upper to below the lower lid."""
    upper, lower = eye[_UPPER, :2], eye[_LOWER, :2]
    down = _BESIDE[:, None, None] * [0, _width(eye)]
    between = upper + _BETWEEN[:, None, None] * (lower - upper)
    h, w = crop.shape[:2]
    places = np.concatenate([upper - down[::-1], between, lower + down]) * (w / span)
    places += (w - 1) / 2, (h - 1) / 2
    x, y = places.astype(np.float32).transpose(2, 0, 1)
    seen = cv2.remap(
        crop.astype(np.float32), x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE
    )
    colours = np.log(seen + _DARKEST) @ _COLOURS
    skin = np.concatenate([colours[: len(_BESIDE)], colours[-len(_BESIDE) :]]).reshape(-1, 3)
    skin.sort(axis=0)  # np.median takes four times as long
    middle = len(skin) // 2
    beside: np.ndarray = colours - 0.5 * (skin[middle - 1] + skin[middle])
    return beside
