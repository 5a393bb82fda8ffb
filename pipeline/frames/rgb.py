"""Converts an RGB picture in memory to a Frame, and its changed pixels back."""

from collections.abc import Sequence
from dataclasses import replace
from fractions import Fraction

import av
import numpy as np
from av.video.reformatter import ColorRange, Colorspace
from makeup_video.kernels.colour import DISPLAY_P3
from makeup_video.pipeline.frames.colour_tags import ColourTags
from makeup_video.pipeline.frames.frame import Frame
from makeup_video.pipeline.frames.orientation import UPRIGHT, Orientation

PICTURE_TICK = Fraction(1, 1)
# BT.709, full range, the transfer of sRGB.
PICTURE_TAGS = ColourTags(1, 2, 13, 1)
P3_PICTURE_TAGS = replace(PICTURE_TAGS, primaries=DISPLAY_P3)


def to_frame(
    stored: np.ndarray,
    orientation: Orientation = UPRIGHT,
    tags: ColourTags = PICTURE_TAGS,
) -> Frame:
    """The stored pixels as an 8-bit 4:4:4 frame.

    stored: (H, W, 1 to 4) uint8 or uint16: grey, grey and alpha, BGR or BGRA; alpha is left out.
    tags: PICTURE_TAGS or P3_PICTURE_TAGS.
    """
    eight = as_uint8(stored)
    bgr = np.repeat(eight[..., :1], 3, axis=2) if eight.shape[2] < 3 else eight[..., :3]
    picture = av.VideoFrame.from_ndarray(np.ascontiguousarray(bgr), format="bgr24").reformat(
        format="yuv444p", dst_colorspace=Colorspace.ITU709, dst_color_range=ColorRange.JPEG
    )
    picture.pts = 0
    turn_degrees, is_mirrored, _ = orientation
    return Frame(picture, 0, PICTURE_TICK, tags, turn_degrees, is_mirrored)


def as_uint8(codes: np.ndarray) -> np.ndarray:
    """uint8 or uint16 codes as the nearest uint8 codes; uint8 ones as they are."""
    return codes if codes.dtype == np.uint8 else (codes / 257 + 0.5).astype(np.uint8)


def merge(stored: np.ndarray, frame: Frame, before: Sequence[np.ndarray]) -> np.ndarray:
    """The stored pixels, with those that painting changed converted back from the frame.

    stored: as for to_frame. before: the frame's planes before painting. Returns `stored` itself
    when nothing changed.
    """
    import cv2  # late: videos do not pass here, and need not load it

    changed = np.zeros(stored.shape[:2], bool)
    for old, new in zip(before, frame.planes, strict=True):
        changed |= old != new
    x, y, width, height = cv2.boundingRect(changed.view(np.uint8))
    if not width:
        return stored
    bgr = frame.picture.reformat(
        format="bgr24", src_colorspace=Colorspace.ITU709, src_color_range=ColorRange.JPEG
    ).to_ndarray()
    out = stored if stored.shape[2] >= 3 else with_colour(stored)
    scale = 1 if out.dtype == np.uint8 else 257
    out = out.copy()
    box = np.s_[y : y + height, x : x + width]  # picking pixels of a whole picture is slow
    painted = bgr[box].astype(out.dtype) * scale
    np.copyto(out[box][..., :3], painted, where=changed[box][..., None])
    return out


def with_colour(grey: np.ndarray) -> np.ndarray:
    """Grey (H, W, 1 or 2) -> BGR or BGRA (H, W, 3 or 4)."""
    colour = np.repeat(grey[..., :1], 3, axis=2)
    return np.concatenate([colour, grey[..., 1:]], axis=2)
