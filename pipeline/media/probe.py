"""Short looks into a video file: whether it plays, how many frames it has, one of its pictures."""

from contextlib import closing
from pathlib import Path

import av
import numpy as np
from makeup_video.pipeline.errors import DecodeError, InputError
from makeup_video.pipeline.frames.display_matrix import turn_of
from makeup_video.pipeline.media.input_file import open_video


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
    """Return how many frames a video has by its header, 0 if unknown. Raises InputError."""
    with closing(open_video(path)) as source:
        return source.expected_frames or 0


def picture_at(path: Path, start_seconds: float, latest_seconds: float) -> np.ndarray:
    """The picture of a video at latest_seconds after start_seconds, or the last one before.

    start_seconds: counted from where a player begins.  latest_seconds should be short: all frames
    up to there are decoded.
    Returns (H, W, 3) uint8, B'G'R', upright. Raises InputError, DecodeError.
    """
    with closing(open_video(path)) as source:
        first = float(source.start_seconds) + start_seconds
        last = None
        try:
            if start_seconds:
                source.container.seek(round(first * av.time_base))
            for picture in source.container.decode(source.video):
                last = picture
                if picture.time is not None and picture.time >= first + latest_seconds:
                    break
        except av.FFmpegError as error:
            if last is None:  # a damaged file may have some pictures
                raise DecodeError(f"{path} cannot be decoded: {error.strerror}") from error
        if last is None:
            raise DecodeError(f"{path} has no frame at {start_seconds:g} s")
        turned = np.rot90(last.to_ndarray(format="bgr24"), turn_of(last) // 90)
        return np.ascontiguousarray(turned)
