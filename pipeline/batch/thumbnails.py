"""Small pictures of an input and of its output at the same moment."""

from pathlib import Path

import cv2
import numpy as np
from makeup_video.pipeline.errors import DecodeError, MakeupVideoError
from makeup_video.pipeline.frames.rgb import as_uint8
from makeup_video.pipeline.images.heif import is_heif
from makeup_video.pipeline.images.picture_file import decode_picture, is_picture, read_bytes
from makeup_video.pipeline.media.probe import picture_at

_LONGEST_PX = 240
_QUALITY = 80  # of JPEG
_LATEST_SECONDS = 1.0  # later moments take long to reach: all frames before them are decoded


def thumbnails(source: str, output: str, start_seconds: float) -> tuple[bytes | None, bytes | None]:
    """JPEG files of input and output, upright and at most 240 px on the longer side.

    start_seconds: the moment of the input at which the output begins.
    None in place of a picture that cannot be read: a page of results can do without the picture.
    """
    return thumbnail(Path(source), start_seconds), thumbnail(Path(output), is_own=True)


def thumbnail(path: Path, start_seconds: float = 0.0, *, is_own: bool = False) -> bytes | None:
    """A JPEG file of a picture, or of a moment of a video up to a second after start_seconds.

    is_own: as for read_bytes.
    """
    try:
        if is_picture(path):
            bgr8 = _picture(path, is_own)
        else:
            bgr8 = picture_at(path, start_seconds, _LATEST_SECONDS)
    except MakeupVideoError:
        return None
    height, width = bgr8.shape[:2]
    share = min(1.0, _LONGEST_PX / max(height, width))
    size_wh = max(1, round(width * share)), max(1, round(height * share))
    small = cv2.resize(bgr8, size_wh, interpolation=cv2.INTER_AREA)
    _, data = cv2.imencode(".jpg", small, [cv2.IMWRITE_JPEG_QUALITY, _QUALITY])
    return data.tobytes()


def _picture(path: Path, is_own: bool) -> np.ndarray:
    """A picture file upright, (H, W, 3) uint8 B'G'R'. Raises InputError, DecodeError."""
    data = read_bytes(path, is_own=is_own)
    if is_heif(data):
        stored, _ = decode_picture(data, path)
        return as_uint8(stored)[..., :3]
    upright = cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR)
    if upright is None:
        raise DecodeError(f"{path} cannot be decoded")
    return upright
