"""Joins the pictures before and after painting into one, side by side as the viewer sees them."""

from collections.abc import Callable
from typing import Any

import av
import numpy as np
from av.video.reformatter import Interpolation
from makeup_video.pipeline.frames.frame import Frame, plane_views
from makeup_video.pipeline.frames.orientation import UPRIGHT, Orientation


class SideBySide:
    """Wraps a stage that returns a Frame: the new frame shows the old one and the stage's result.

    The viewer sees the untouched picture on the left; in a video stored turned by 90 degrees, the
    halves are stacked. Where a half would end within a chroma sample (odd sizes), its last
    column or row is repeated up to whole samples.
    """

    def __init__(self, paint: Callable[[Any], Frame]) -> None:
        self.paint = paint

    def __call__(self, item: Any) -> Frame:
        frame: Frame = item if isinstance(item, Frame) else item.frame
        axis, before_first = _halves(frame.rotation_degrees, frame.is_mirrored)
        both = _room_for_two(frame, axis)
        halves = [np.array_split(plane, 2, axis) for plane in plane_views(both, frame.bit_depth)]
        # copied first: painting changes this very memory
        _fill([pair[not before_first] for pair in halves], frame)
        painted = self.paint(item)
        _fill([pair[before_first] for pair in halves], painted)
        return Frame(
            both, frame.pts, frame.time_base, frame.tags, frame.rotation_degrees, frame.is_mirrored
        )


def side_by_side(
    before: np.ndarray, after: np.ndarray, orientation: Orientation = UPRIGHT
) -> np.ndarray:
    """Join two stored pictures (H, W, C) of one shape and dtype, every sample as it is.

    The viewer sees `before` on the left, once the picture is turned as its orientation says.
    """
    axis, before_first = _halves(orientation.turn_degrees, orientation.is_mirrored)
    return np.concatenate([before, after] if before_first else [after, before], axis)


def _halves(turn_degrees: int, is_mirrored: bool) -> tuple[int, bool]:
    """The axis of the stored picture along which the halves lie, and whether the viewer's left one
    comes first."""
    return (1 if turn_degrees % 180 == 0 else 0), (turn_degrees < 180) != is_mirrored


def _room_for_two(frame: Frame, axis: int) -> av.VideoFrame:
    """A picture for both halves, with the field order and side data of the frame's picture."""
    across, down = frame.chroma
    if frame.picture.interlaced_frame:
        down *= 2  # rows of the second half must keep their field
    width, height = -(-frame.width_px // across) * across, -(-frame.height_px // down) * down
    # Only reformat makes a larger picture that keeps field order and side data. All of its pixels
    # are overwritten.
    return frame.picture.reformat(
        width=width * (1 + axis), height=height * (2 - axis), interpolation=Interpolation.POINT
    )


def _fill(half: list[np.ndarray], frame: Frame) -> None:
    """Copy the frame's planes into one half; its last row and column fill what is left."""
    for new, old in zip(half, frame.planes, strict=True):
        height, width = old.shape[:2]
        new[:height, :width] = old
        new[height:, :width] = old[-1:]
        new[:, width:] = new[:, width - 1 : width]
