"""An RGB picture that is painted as a frame of a video."""

from fractions import Fraction

import av
import cv2
import numpy as np
from makeup_video.kernels.colour import Coding, matrices
from makeup_video.pipeline.frames.frame import Frame, plane_views
from makeup_video.pipeline.frames.rgb import PICTURE_TAGS

# Matrices of PICTURE_TAGS, between codes of Y'CbCr and codes of R'G'B'.
_TO_RGB, _TO_CODES = matrices(Coding(1, True))
_TO_RGB, _TO_CODES = _TO_RGB * 255, _TO_CODES / [255, 255, 255, 1]
_TICK = Fraction(1, 1_000_000)


class RgbFrame:
    """A copy of an RGB picture, and the frame that is painted in its place.

    rgb8: (H, W, 3) uint8, R'G'B' as sRGB encodes it.  seconds: the frame's time.
    frame: 8 bits, 4:4:4, tagged PICTURE_TAGS, to be painted in place.

    The conversion is OpenCV's, which takes a quarter of the time of FFmpeg's; both round to the
    nearest code.
    """

    def __init__(self, rgb8: np.ndarray, seconds: float) -> None:
        self._rgb8 = np.array(rgb8, order="C")  # a plain array, no subclass such as a memory map
        self._before = cv2.split(cv2.transform(self._rgb8, _TO_CODES))
        height, width = rgb8.shape[:2]
        picture = av.VideoFrame(width, height, "yuv444p")
        for plane, codes in zip(plane_views(picture, 8), self._before, strict=True):
            plane[:] = codes
        pts = round(seconds / _TICK)
        self.frame = Frame(picture, pts, _TICK, PICTURE_TAGS)

    def painted(self) -> np.ndarray:
        """The picture, with the pixels that painting changed converted back. Call it once."""
        planes = self.frame.planes
        changed = np.zeros(planes[0].shape, np.uint8)
        for old, new in zip(self._before, planes, strict=True):
            changed |= np.asarray(cv2.compare(old, new, cv2.CMP_NE), np.uint8)
        x, y, width, height = cv2.boundingRect(changed)
        box = np.s_[y : y + height, x : x + width]
        if width:
            codes = cv2.merge([plane[box] for plane in planes])
            cv2.copyTo(cv2.transform(codes, _TO_RGB), changed[box], self._rgb8[box])
        return self._rgb8
