"""Short looks into a video file: whether it plays, how many frames it has, one of its pictures."""

from collections.abc import Generator
from contextlib import closing
from fractions import Fraction
from pathlib import Path

import av
import cv2
import numpy as np
from makeup_video.pipeline.errors import DecodeError, InputError
from makeup_video.pipeline.frames.colour_tags import ColourTags, is_full_range, resolve
from makeup_video.pipeline.frames.display_matrix import turn_of
from makeup_video.pipeline.frames.transform import ffmpeg_matrix, ffmpeg_range
from makeup_video.pipeline.media.input_file import VideoSource, open_video, packets_of


def plays(path: Path, frames: int | None = None) -> bool:
    """Whether the file opens as a video and its first frame can be decoded.

    frames: how many frames its header must declare, if it declares any; None: any number.
    """
    try:
        with closing(open_video(path)) as source:
            declared = source.video.frames
            if frames is not None and declared and declared != frames:
                return False
            return next(source.container.decode(source.video), None) is not None
    except (InputError, av.FFmpegError):
        return False


def declared_frames(path: Path) -> int:
    """How many frames a video has by its header, else by its length and rate; 0 if unknown.

    Raises InputError.
    """
    with closing(open_video(path)) as source:
        return source.expected_frames or 0


def picture_at(path: Path, start_seconds: float, latest_seconds: float) -> np.ndarray:
    """The picture of a video at latest_seconds after start_seconds, or the last one before.

    start_seconds: counted from where a player begins.  latest_seconds should be short: all frames
    up to there are decoded.
    Returns (H, W, 3) uint8, B'G'R', upright, with square pixels. Raises InputError, DecodeError,
    and UsageError for an unknown colour matrix.
    """
    with closing(open_video(path)) as source:
        first = float(source.start_seconds) + start_seconds
        last = None
        try:
            if start_seconds:
                source.container.seek(round(first * av.time_base))
            for last in _pictures(source):
                if last.time is not None and last.time >= first + latest_seconds:
                    break
        except av.FFmpegError as error:
            if last is None:  # a damaged file may have some pictures
                raise DecodeError(f"{path} cannot be decoded: {error.strerror}") from error
        if last is None:
            raise DecodeError(f"{path} has no frame at {start_seconds:g} s")
        try:
            return _shown(last, source.video.sample_aspect_ratio or Fraction(1))
        except av.FFmpegError as error:  # for example for pixels with 32 bits
            raise DecodeError(f"{path} cannot be decoded: {error.strerror}") from error


def _pictures(source: VideoSource) -> Generator[av.VideoFrame, None, None]:
    for packet in packets_of(source.container, source.video):
        yield from packet.decode()


def _shown(picture: av.VideoFrame, aspect: Fraction) -> np.ndarray:
    """(H, W, 3) uint8 B'G'R' as players show it; oblong pixels shrink along their longer side."""
    if picture.format.is_rgb or picture.format.has_palette:
        bgr8 = picture.to_ndarray(format="bgr24")
    else:
        coding = resolve(ColourTags.of(picture), picture.width, picture.height, bit_depth=8)
        is_full = is_full_range(picture.color_range, picture.format.name)
        bgr8 = picture.reformat(
            format="bgr24",
            src_colorspace=ffmpeg_matrix(coding),
            src_color_range=ffmpeg_range(is_full),
        ).to_ndarray()
    size_wh = picture.width * min(float(aspect), 1), picture.height / max(float(aspect), 1)
    wide, high = (max(1, round(side)) for side in size_wh)
    square = cv2.resize(bgr8, (wide, high), interpolation=cv2.INTER_AREA)
    return np.ascontiguousarray(np.rot90(square, turn_of(picture) // 90))
