"""Converts an RGB picture in memory to a Frame, and its changed pixels back."""

from collections.abc import Sequence
from fractions import Fraction

import av
import cv2
import numpy as np
from av.video.reformatter import ColorRange, Colorspace
from makeup_video.kernels.colour import Coding, matrices
from makeup_video.pipeline.frames.colour_tags import ColourTags
from makeup_video.pipeline.frames.frame import Frame, plane_views

PICTURE_TICK = Fraction(1, 1)
# BT.709, full range, the transfer of sRGB.
PICTURE_TAGS = ColourTags(1, 2, 13, 1)
# Of PICTURE_TAGS, between codes of Y'CbCr and codes of R'G'B'
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
        self._rgb8 = rgb8.copy()
        self._before = cv2.split(cv2.transform(self._rgb8, _TO_CODES))
        height, width = rgb8.shape[:2]
        picture = av.VideoFrame(width, height, "yuv444p")
        for plane, codes in zip(plane_views(picture, 8), self._before, strict=True):
            plane[:] = codes
        pts = round(seconds / _TICK)
        self.frame = Frame(picture, pts, _TICK, PICTURE_TAGS)

    def painted(self) -> np.ndarray:
        """The picture, with the pixels that painting changed converted back; called once."""
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


def to_frame(stored: np.ndarray, rotation_degrees: int = 0) -> Frame:
    """The stored pixels as an 8-bit 4:4:4 frame, tagged PICTURE_TAGS.

    stored: (H, W, 1 to 4) uint8 or uint16: grey, grey and alpha, BGR or BGRA; alpha is left out.
    """
    eight = stored if stored.dtype == np.uint8 else (stored / 257 + 0.5).astype(np.uint8)
    bgr = np.repeat(eight[..., :1], 3, axis=2) if eight.shape[2] < 3 else eight[..., :3]
    picture = av.VideoFrame.from_ndarray(np.ascontiguousarray(bgr), format="bgr24").reformat(
        format="yuv444p", dst_colorspace=Colorspace.ITU709, dst_color_range=ColorRange.JPEG
    )
    picture.pts = 0
    return Frame(picture, 0, PICTURE_TICK, PICTURE_TAGS, rotation_degrees)


def merge(stored: np.ndarray, frame: Frame, before: Sequence[np.ndarray]) -> np.ndarray:
    """The stored pixels, with those that painting changed converted back from the frame.

    stored: as for to_frame. before: the frame's planes before painting. The very same array when
    nothing changed.
    """
    changed = np.zeros(stored.shape[:2], bool)
    for old, new in zip(before, frame.planes, strict=True):
        changed |= old != new
    if not changed.any():
        return stored
    bgr = frame.picture.reformat(
        format="bgr24", src_colorspace=Colorspace.ITU709, src_color_range=ColorRange.JPEG
    ).to_ndarray()
    out = stored if stored.shape[2] >= 3 else with_colour(stored)
    scale = 1 if out.dtype == np.uint8 else 257
    out = out.copy()
    out[..., :3][changed] = bgr[changed].astype(out.dtype) * scale
    return out


def with_colour(grey: np.ndarray) -> np.ndarray:
    """Grey (H, W, 1 or 2) -> BGR or BGRA (H, W, 3 or 4)."""
    colour = np.repeat(grey[..., :1], 3, axis=2)
    return np.concatenate([colour, grey[..., 1:]], axis=2)
