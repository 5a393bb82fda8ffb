"""Draws the faces that were found onto a frame's planes, so that people can judge them by eye.

Points of lips are green, of eyes yellow, others white. Lips are tinted by their mask. Number, score
and mouth score are above each face as the viewer sees it, or as near as the picture's edge allows.
"""

from collections.abc import Sequence
from typing import Any

import cv2
import numpy as np
from makeup_video.pipeline.faces.face import POINTS, Face, FrameFaces
from makeup_video.pipeline.faces.lip_mask import lip_mask_part
from makeup_video.pipeline.faces.topology import EYE, LIPS, RIGHT_EYE
from makeup_video.pipeline.frames.frame import Frame
from makeup_video.pipeline.offline.points_file import PointsFile

# Y', Cb, Cr as 8-bit limited-range codes: close enough for a drawing, whatever the matrix
_WHITE, _GREEN, _YELLOW = (235, 128, 128), (150, 44, 21), (210, 16, 146)
_TINT, _TINT_OPACITY = (63, 102, 240), 0.55  # of the lips: dark red


class DrawFaces:
    """A stage that draws faces on their frame, and writes their points when a file is given."""

    def __init__(self, points_file: PointsFile | None = None) -> None:
        self.points_file = points_file
        self._colours = np.full((POINTS, 3), _WHITE)
        self._colours[EYE] = self._colours[RIGHT_EYE] = _YELLOW
        self._colours[LIPS] = _GREEN

    def __call__(self, item: FrameFaces) -> Frame:
        if self.points_file is not None:
            self.points_file.write(item)
        if item.faces:
            planes = item.frame.writable_planes()
            for face in item.faces:
                _tint(planes, item.frame, face)
                _draw_points(planes, item.frame, face, self._colours)
                _draw_label(planes, item.frame, face)
        return item.frame


def _codes(frame: Frame, colours: Any) -> np.ndarray:
    """8-bit codes, scaled to the frame's depth."""
    codes: np.ndarray = np.asarray(colours) << max(frame.bit_depth - 8, 0)
    return codes


def _draw_points(
    planes: tuple[np.ndarray, ...], frame: Frame, face: Face, colours: np.ndarray
) -> None:
    """Draw a square of its colour at each point: luma pixels, and the chroma samples under them."""
    size = float(np.ptp(face.points_px[:, 0]))
    radius = max(0, round(size / 400))
    steps = np.arange(-radius, radius + 1)
    centre = np.rint(face.points_px[:, :2]).astype(int)
    x, y = np.broadcast_arrays(
        centre[:, 0, None, None] + steps, centre[:, 1, None, None] + steps[:, None]
    )
    inside = (x >= 0) & (y >= 0) & (x < frame.width_px) & (y < frame.height_px)
    x, y, of_point = x[inside], y[inside], inside.nonzero()[0]
    codes = _codes(frame, colours)[of_point]
    planes[0][y, x] = codes[:, 0]
    across, down = frame.chroma
    for plane, column in _chroma_views(planes, (1, 2)):
        plane[y // down, x // across] = codes[:, column]


def _chroma_views(
    planes: tuple[np.ndarray, ...], values: Sequence[int]
) -> list[tuple[np.ndarray, int]]:
    """Cb and Cr as (h, w) views, each with its value, also of NV12; none of a grey picture."""
    if len(planes) < 2:
        return []
    if planes[1].ndim == 3:
        return [(planes[1][..., 0], values[0]), (planes[1][..., 1], values[1])]
    return [(planes[1], values[0]), (planes[2], values[1])]


def _tint(planes: tuple[np.ndarray, ...], frame: Frame, face: Face) -> None:
    """Mix the tint into the lips by the lip mask."""
    xy = face.points_px[LIPS, :2]
    margin = 0.1 * np.ptp(xy[:, 0])
    low = np.maximum(np.floor(xy.min(0) - margin), 0).astype(int) // 2 * 2
    high = np.ceil(xy.max(0) + margin).astype(int)
    high = np.minimum(high, [frame.width_px, frame.height_px])
    if (high <= low).any():
        return
    w, h = int(high[0] - low[0]), int(high[1] - low[1])
    weight = lip_mask_part(face, (int(low[0]), int(low[1])), (w, h)) * _TINT_OPACITY
    codes = _codes(frame, _TINT).tolist()
    _mix(planes[0][low[1] : high[1], low[0] : high[0]], weight, codes[0])
    across, down = frame.chroma
    for plane, code in _chroma_views(planes, codes[1:]):
        part = plane[low[1] // down :, low[0] // across :][: -(-h // down), : -(-w // across)]
        small = cv2.resize(weight, part.shape[1::-1], interpolation=cv2.INTER_AREA)
        _mix(part, small, code)


def _mix(plane: np.ndarray, weight: np.ndarray, code: int) -> None:
    plane[:] = np.rint(plane + weight * (code - plane.astype(np.float32))).astype(plane.dtype)


def _draw_label(planes: tuple[np.ndarray, ...], frame: Frame, face: Face) -> None:
    """Draw number and scores above the face's upper left corner, upright as the viewer sees it.

    The label stays within the picture; a face outside has none.
    """
    turns = frame.rotation_degrees // 90
    stored_wh = np.array([frame.width_px, frame.height_px])
    upright_wh = stored_wh[::-1] if turns % 2 else stored_wh
    xy = _turned(face.points_px[:, :2], stored_wh, turns)
    if frame.is_mirrored:
        xy = _mirrored(xy, upright_wh)
    low, high = xy.min(0), xy.max(0)
    if (high < 0).any() or (low >= upright_wh).any():
        return
    label = _label(face, size_px=float(np.ptp(xy[:, 0])), width_px=int(upright_wh[0]))
    label = label[: upright_wh[1]]
    label_wh = np.array(label.shape[::-1])
    corner = np.clip(low.astype(int) - [0, label_wh[1] + 4], 0, upright_wh - label_wh)
    corners = np.stack([corner, corner + label_wh - 1])
    if frame.is_mirrored:
        label, corners = label[:, ::-1], _mirrored(corners, upright_wh)
    label = np.rot90(label, -turns)
    x, y = _turned(corners, upright_wh, -turns).min(0)
    height, width = label.shape
    planes[0][y : y + height, x : x + width] = _codes(frame, label.astype(planes[0].dtype))
    across, down = frame.chroma
    rect = np.s_[y // down : -(-(y + height) // down), x // across : -(-(x + width) // across)]
    for plane, code in _chroma_views(planes, _codes(frame, (128, 128)).tolist()):
        plane[rect] = code


def _label(face: Face, size_px: float, width_px: int) -> np.ndarray:
    """(h, w) uint8: white on black, sized for a face of size_px, at most width_px wide."""
    text = f"{face.track_id}  {face.score:.2f}  mouth {face.mouth_visible:.2f}"
    font, scale = cv2.FONT_HERSHEY_SIMPLEX, max(0.4, size_px / 400)
    wide = cv2.getTextSize(text, font, scale, 1)[0][0] + 4
    scale *= min(1.0, width_px / wide)
    (w, h), base = cv2.getTextSize(text, font, scale, 1)
    label = np.full((h + base + 4, w + 4), 16, np.uint8)
    cv2.putText(label, text, (2, h + 2), font, scale, 235, 1, cv2.LINE_AA)
    return label[:, :width_px]


def _mirrored(xy: np.ndarray, size_wh: np.ndarray) -> np.ndarray:
    """Where pixels (N, 2) of a picture of that size are after left and right change places."""
    return np.stack([size_wh[0] - 1 - xy[:, 0], xy[:, 1]], axis=-1)


def _turned(xy: np.ndarray, size_wh: np.ndarray, quarter_turns: int) -> np.ndarray:
    """Where pixels (N, 2) of a picture of that size are after counter-clockwise quarter turns."""
    (width, height), (x, y) = size_wh, xy.T
    for _ in range(quarter_turns % 4):
        x, y, width, height = y, width - 1 - x, height, width
    return np.stack([x, y], axis=-1)
