"""How decoded pictures of a video become upright: FFmpeg's display matrix."""

import math
import struct

import av
from makeup_video.pipeline.frames.side_data import side_data

_MATRIX = struct.Struct("=9i")


def matrix_of(picture: av.VideoFrame) -> tuple[int, ...] | None:
    """The nine numbers of a picture's display matrix, by rows; None when it has none.

    Columns 1 and 2 give the display's x and y of a stored pixel (x, y, 1).
    """
    matrix = side_data(picture, "DISPLAYMATRIX")
    return None if matrix is None else _MATRIX.unpack(matrix)


def turn_of(picture: av.VideoFrame) -> int:
    """The counter-clockwise turn, 0, 90, 180 or 270 degrees, that makes a decoded picture upright.

    Reads the display matrix itself: PyAV's `rotation` takes a picture that is mirrored left to
    right for one that is turned by 180 degrees.
    """
    return turn_and_mirror_of(picture)[0]


def turn_and_mirror_of(picture: av.VideoFrame) -> tuple[int, bool]:
    """The result of `turn_of`, and whether left and right change places after that turn."""
    matrix = matrix_of(picture)
    if matrix is None:
        return 0, False
    right_by_x, down_by_x, _, right_by_y, down_by_y, *_ = matrix
    turn_degrees = round(-math.degrees(math.atan2(down_by_x, down_by_y)) / 90) * 90 % 360
    return turn_degrees, right_by_x * down_by_y < right_by_y * down_by_x
