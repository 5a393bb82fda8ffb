"""Before and after beside each other, as the viewer sees them: in videos and in pictures."""

import struct
from collections.abc import Callable
from typing import Any

import av
import numpy as np
from av.video.reformatter import Interpolation
from makeup_video.pipeline.frames.frame import Frame, plane_views
from makeup_video.pipeline.media.hdr import side_data

# Counter-clockwise degrees to upright -> (axis along which the halves lie in the stored picture,
# whether the one that the viewer sees on the left comes first).
_LAYOUTS = {0: (1, True), 90: (0, True), 180: (1, False), 270: (0, False)}
# The same for EXIF orientations, which also mirror: where row 0 and column 0 are (Exif 2.32, 4.6.5)
_EXIF_LAYOUTS = {
    1: (1, True), 2: (1, False), 3: (1, False), 4: (1, True),
    5: (0, True), 6: (0, False), 7: (0, False), 8: (0, True),
}  # fmt: skip


class SideBySide:
    """Any stage that ends in a Frame -> the same, twice as wide: as it came in, and as it went out.

    As the viewer sees it the untouched picture is on the left; a film that is stored lying on its
    side is stacked. Where a half would end within a chroma sample (odd sizes), its last column or
    row is repeated up to whole samples.
    """

    def __init__(self, paint: Callable[[Any], Frame]) -> None:
        self.paint = paint

    def __call__(self, item: Any) -> Frame:
        frame: Frame = item if isinstance(item, Frame) else item.frame
        axis, before_first = _layout(frame)
        both = _room_for_two(frame, axis)
        halves = [np.array_split(plane, 2, axis) for plane in plane_views(both, frame.bit_depth)]
        # copied at once: painting changes this very memory
        _fill([pair[not before_first] for pair in halves], frame)
        painted = self.paint(item)
        _fill([pair[before_first] for pair in halves], painted)
        return Frame(both, frame.pts, frame.time_base, frame.tags, frame.rotation_degrees)


def side_by_side(before: np.ndarray, after: np.ndarray, exif_orientation: int = 1) -> np.ndarray:
    """Two stored pictures (H, W, C) of one shape and dtype as one, exactly, so that the viewer sees
    `before` on the left once the EXIF orientation (1 to 8) is applied."""
    axis, before_first = _EXIF_LAYOUTS.get(exif_orientation, _EXIF_LAYOUTS[1])
    return np.concatenate([before, after] if before_first else [after, before], axis)


def _layout(frame: Frame) -> tuple[int, bool]:
    matrix = side_data(frame.picture, "DISPLAYMATRIX")
    if matrix is None:
        return _LAYOUTS[frame.rotation_degrees]
    # it may mirror too; a column x, y of the stored picture is shown at a * x + c * y
    a, _, _, c = struct.unpack("9i", matrix)[:4]
    return (1, a > 0) if abs(a) >= abs(c) else (0, c > 0)


def _room_for_two(frame: Frame, axis: int) -> av.VideoFrame:
    """A picture for both halves, with the field order and side data of the frame's."""
    across, down = frame.chroma
    if frame.picture.interlaced_frame:
        down *= 2  # rows of the second half must keep their field
    width, height = -(-frame.width_px // across) * across, -(-frame.height_px // down) * down
    # reformat is the one way to a larger picture that keeps these; every pixel is overwritten
    return frame.picture.reformat(
        width=width * (1 + axis), height=height * (2 - axis), interpolation=Interpolation.POINT
    )


def _fill(half: list[np.ndarray], frame: Frame) -> None:
    """Copy the planes, edges repeated."""
    for new, old in zip(half, frame.planes, strict=True):
        height, width = old.shape[:2]
        new[:height, :width] = old
        new[height:, :width] = old[-1:]
        new[:, width:] = new[:, width - 1 : width]
