"""The portrait as a reference photo, and readings of photos that are made up."""

from dataclasses import replace
from functools import cache

import cv2
import numpy as np
from makeup_video.pipeline import find_faces
from makeup_video.pipeline.reference.estimate import Estimate
from makeup_video.pipeline.reference.flat_eyes import eyes_of, mean_eye
from makeup_video.pipeline.reference.read_makeup import WORN_FROM
from people import portrait


@cache
def face():
    return find_faces(portrait())[0]


def flat_eyes(neutral):
    """The mean of a face's eyes, laid flat."""
    return mean_eye(eyes_of(neutral))


def dots_at(landmarks, scale):
    """A black picture with dots at some points of the portrait, scaled by `scale`; and the face."""
    points = face().points_px * np.float32([scale, scale, scale])
    size = tuple(int(scale * side) for side in portrait().shape[:2])
    dots = np.zeros((*size, 3), np.uint8)
    for at in landmarks:
        x, y = np.rint(points[at, :2]).astype(int).tolist()
        cv2.circle(dots, (x, y), max(2, round(2 * scale)), (255, 255, 255), -1)
    return dots, replace(face(), points_px=points)


def certain(look):
    """The estimate of a photo that surely shows this look."""
    return Estimate(look, {kind: 0.97 if look.of(kind) else 0.1 for kind in WORN_FROM})
