"""Lids of a shut eye meet.

The eye net learned from MediaPipe's points, whose lids stay apart on a shut eye by up to a seventh
of its width. There a slit of bare lid would be left between shadow and liner above and below. So
where the lids lie close together, a logistic model of the eye's points and of the colours on and
around the slit tells whether the eye is shut (training/faces/fit_shut_eyes.py).
"""

import cv2
import numpy as np
from makeup_video.pipeline.faces.topology import EYE_CONTOUR

# Opening in widths of the eye. From the first on an eye is open; below the second only the model
# decides.
_OPEN, _NARROW = 0.17, 0.14
# Log-odds up to which lids stay where they are, and from which on they meet.
_STAY, _MEET = -0.5, 1.5
_TOGETHER = 0.3  # of the other eye's log-odds: eyes blink together
_LASHES = 0.7  # of the way from the upper to the lower lid: there lies the line where they meet
_LID = np.arange(len(EYE_CONTOUR))  # places in EYE
_LOWER = np.arange(1, 8)  # from the outer to the inner corner, without these
_UPPER = 16 - _LOWER
# Rows of the colours: widths of the eye above the upper and below the lower lid, where skin is
# seen, and shares of the way between the lids.
_BESIDE = np.array([0.09, 0.18])
_BETWEEN = np.linspace(0, 1, 6)
_DARKEST = 8.0  # added to code values before logarithms are taken: darker ones are noise
_COLOURS = np.array([[0.3, 0.59, 0.11], [1, -1, 0], [0, -1, 1]])  # brightness, red, blue
NUMBERS = 317


def close_shut_eyes(
    points: np.ndarray, crops: np.ndarray, weights: np.ndarray, span: float
) -> None:
    """Let the lids of shut eyes meet, in place.

    points: (N, 53, 3) of EYE, in IOD from the middle of the crop. crops: (N, H, W, 3) uint8,
    R'G'B', of eyes at the left of the face, or mirrored ones. weights: (NUMBERS + 1,) of the model,
    the constant last. span: width of a crop in IOD.
    """
    openings = [opening_of(eye) for eye in points]
    if min(openings) >= _OPEN:
        return
    odds = [
        float(weights[:-1] @ numbers_of(eye, crop, span) + weights[-1]) if opening < _OPEN else 0.0
        for eye, crop, opening in zip(points, crops, openings, strict=True)
    ]
    for eye, own, opening in zip(points, odds, openings, strict=True):
        sure = own + _TOGETHER * (sum(odds) - own)
        share = min(max((sure - _STAY) / (_MEET - _STAY), 0.0), 1.0)
        share *= min(max((_OPEN - opening) / (_OPEN - _NARROW), 0.0), 1.0)
        upper, lower = eye[_UPPER], eye[_LOWER]
        meet = upper + _LASHES * (lower - upper)
        eye[_UPPER] = upper + share * (meet - upper)
        eye[_LOWER] = lower + share * (meet - lower)


def opening_of(eye: np.ndarray) -> float:
    """How far an eye (53, 3) is open, in its widths."""
    return float((eye[_LOWER, 1] - eye[_UPPER, 1]).max()) / _width(eye)


def numbers_of(eye: np.ndarray, crop: np.ndarray, span: float) -> np.ndarray:
    """(NUMBERS,) that the model reads: the points in widths of the eye from the middle of its lids,
    the opening, and logarithms of colours beside that of the skin around."""
    places = (eye[:, :2] - eye[_LID, :2].mean(0)) / _width(eye)
    colours = _colours(eye, crop, span)
    return np.concatenate([places.ravel(), [opening_of(eye)], colours.ravel()])


def _width(eye: np.ndarray) -> float:
    x, y = (eye[8, :2] - eye[0, :2]).tolist()
    return max(float(np.hypot(x, y)), 1e-6)


def _colours(eye: np.ndarray, crop: np.ndarray, span: float) -> np.ndarray:
    """(10, 7, 3): rows from above the upper lid to below the lower one."""
    upper, lower = eye[_UPPER, :2], eye[_LOWER, :2]
    down = _BESIDE[:, None, None] * [0, _width(eye)]
    between = upper + _BETWEEN[:, None, None] * (lower - upper)
    h, w = crop.shape[:2]
    places = np.concatenate([upper - down[::-1], between, lower + down]) * (w / span)
    x, y = np.moveaxis(places + np.array([w - 1, h - 1]) / 2, -1, 0).astype(np.float32)
    seen = cv2.remap(
        crop.astype(np.float32), x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE
    )
    colours = np.log(seen + _DARKEST) @ _COLOURS.T
    skin = np.concatenate([colours[: len(_BESIDE)], colours[-len(_BESIDE) :]])
    beside: np.ndarray = colours - np.median(skin.reshape(-1, 3), axis=0)
    return beside
