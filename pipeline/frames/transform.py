"""Resized, turned and plain copies of FFmpeg's frames, with their time and colour tags."""

from fractions import Fraction

import av
import numpy as np
from av.video.reformatter import ColorRange, Colorspace
from makeup_video.kernels.colour import Coding
from makeup_video.pipeline.frames.colour_tags import FULL_RANGE
from makeup_video.pipeline.frames.frame import Frame, coding_of, plane_views

_SMPTE_170M = 6  # BT.601, 525 lines; same matrix as 5, for which FFmpeg's converter has a name


def squared(picture: av.VideoFrame, aspect: Fraction) -> av.VideoFrame:
    """A 4:2:0 copy with square pixels: the shorter side of the pixels is stretched.

    The picture itself when its pixels are square.
    """
    if aspect == 1:
        return picture
    wider, higher = max(aspect, Fraction(1)), max(1 / aspect, Fraction(1))
    width = round(picture.width * wider / 2) * 2
    height = round(picture.height * higher / 2) * 2
    out = picture.reformat(width=width, height=height)  # keeps side data, which holds the rotation
    return with_tags(out, picture)


def fitted(picture: av.VideoFrame, size_wh: tuple[int, int]) -> av.VideoFrame:
    """A 4:2:0 copy of size_wh: scaled as large as fits, with black bars around it."""
    (wide, high), scale = size_wh, min(size_wh[0] / picture.width, size_wh[1] / picture.height)
    inner_wh = [max(2, round(side * scale / 2) * 2) for side in (picture.width, picture.height)]
    inner_wh = [min(inner_wh[0], wide), min(inner_wh[1], high)]
    small = picture.reformat(width=inner_wh[0], height=inner_wh[1])
    out = av.VideoFrame(wide, high, picture.format.name)
    full = picture.color_range == FULL_RANGE
    left, top = ((outer - inner) // 4 * 2 for outer, inner in zip(size_wh, inner_wh, strict=True))
    for index, (new, old) in enumerate(
        zip(plane_views(out, 8), plane_views(small, 8), strict=True)
    ):
        new[:] = 128 if index else (0 if full else 16)
        step = 2 if index else 1
        rows, columns = old.shape
        new[top // step : top // step + rows, left // step : left // step + columns] = old
    return with_tags(out, picture)


def upright(frame: Frame) -> av.VideoFrame:
    """An upright copy, for outputs that cannot carry a rotation; 8-bit 4:2:0.

    The frame's own picture when it has no rotation.
    """
    turns = frame.rotation_degrees // 90
    if not turns:
        return frame.picture
    size = frame.width_px, frame.height_px
    out = av.VideoFrame(*(size if turns == 2 else size[::-1]), frame.pix_fmt)
    for new, old in zip(plane_views(out, 8), frame.planes, strict=True):
        new[:] = np.rot90(old, turns)
    return with_tags(out, frame.picture)


def copied(picture: av.VideoFrame) -> av.VideoFrame:
    """A copy in its own memory; 8-bit 4:2:0."""
    out = av.VideoFrame(picture.width, picture.height, picture.format.name)
    for new, old in zip(plane_views(out, 8), plane_views(picture, 8), strict=True):
        new[:] = old
    return with_tags(out, picture)


def with_tags(out: av.VideoFrame, picture: av.VideoFrame) -> av.VideoFrame:
    """`out`, with the time and the colour tags of `picture`."""
    out.colorspace, out.color_range = picture.colorspace, picture.color_range
    out.color_primaries, out.color_trc = picture.color_primaries, picture.color_trc
    if picture.pts is not None:
        out.pts, out.time_base = picture.pts, picture.time_base
    return out


def upright_rgb(frame: Frame) -> np.ndarray:
    """An upright copy, (H, W, 3) uint8 R'G'B', of an 8-bit frame that other threads may read."""
    coding = coding_of(frame)
    # a copy: PyAV keeps its converter with a picture, and changes the picture's tags meanwhile
    picture = copied(frame.picture).reformat(
        format="rgb24",
        src_colorspace=ffmpeg_matrix(coding),
        src_color_range=ffmpeg_range(coding.full_range),
    )
    return np.ascontiguousarray(np.rot90(picture.to_ndarray(), frame.rotation_degrees // 90))


def ffmpeg_matrix(coding: Coding) -> Colorspace:
    """The Y'CbCr matrix of a coding, as FFmpeg's converter names it."""
    return Colorspace.ITU601 if coding.matrix == _SMPTE_170M else Colorspace(coding.matrix)


def ffmpeg_range(full_range: bool) -> ColorRange:
    """The range of codes, as FFmpeg's converter names it."""
    return ColorRange.JPEG if full_range else ColorRange.MPEG
