"""FrameFaces -> Frame: draws what was found onto the planes, for people to judge by eye.

Points of lips green, of eyes yellow, others white; lips tinted by their mask; number, score and
mouth score above each face.
"""

import json
from collections.abc import Iterable
from pathlib import Path
from typing import IO, Any

import cv2
import numpy as np
from makeup_video.pipeline.face import POINTS, Face, FrameFaces
from makeup_video.pipeline.faces import lip_mask_window
from makeup_video.pipeline.frame import Frame
from makeup_video.pipeline.target import write_errors
from makeup_video.pipeline.topology import EYE, LIPS, RIGHT_EYE

# Y', Cb, Cr as 8-bit limited-range codes: only a drawing, right enough in every matrix
_WHITE, _GREEN, _YELLOW = (235, 128, 128), (150, 44, 21), (210, 16, 146)
_TINT, _TINT_OPACITY = (63, 102, 240), 0.55  # of the lips: dark red


class DrawFaces:
    """FrameFaces -> Frame; also writes the points as JSON when a file is given."""

    def __init__(self, points_file: "PointsFile | None" = None) -> None:
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


class PointsFile:
    """{"frames": [{pts, seconds, faces: [...]}, ...]}, written one frame a line as they come."""

    def __init__(self, path: Path) -> None:
        self.path = path
        self._file: IO[str] | None = None  # opened when the first frame has come through

    def write(self, item: FrameFaces) -> None:
        """Raises OutputError when the file cannot be written."""
        frame = item.frame
        line = {
            "pts": frame.pts,
            "seconds": float(frame.pts * frame.time_base),
            "cut": item.cut,
            "faces": [_as_json(face) for face in item.faces],
        }
        with write_errors(self.path):
            if self._file is None:
                self._file = self.path.open("w", encoding="utf-8")
                self._file.write(_JSON_BEGINS)
            else:
                self._file.write(",\n")
            self._file.write(json.dumps(line))

    def close(self) -> None:
        if self._file is not None:
            with write_errors(self.path), self._file:
                self._file.write(_JSON_ENDS)


_JSON_BEGINS = '{"unit": "px of the stored picture; x, y, z", "frames": [\n'
_JSON_ENDS = "\n]}\n"


def _as_json(face: Face) -> dict[str, Any]:
    return {
        "id": face.track_id,
        "score": round(face.score, 4),
        "mouth_visible": round(face.mouth_visible, 4),
        "points_px": np.round(face.points_px.astype(float), 2).tolist(),
    }


def _codes(frame: Frame, colour: Iterable[int]) -> list[int]:
    """8-bit codes in the frame's own depth."""
    return [int(code) << max(frame.bit_depth - 8, 0) for code in colour]


def _draw_points(
    planes: tuple[np.ndarray, ...], frame: Frame, face: Face, colours: np.ndarray
) -> None:
    size = float(np.ptp(face.points_px[:, 0]))
    radius = max(0, round(size / 400))
    for (x, y), colour in zip(face.points_px[:, :2], colours, strict=True):
        low = np.rint([x - radius, y - radius]).astype(int)
        _fill(planes, frame, low, low + 2 * radius + 1, _codes(frame, colour))


def _fill(
    planes: tuple[np.ndarray, ...], frame: Frame, low: np.ndarray, high: np.ndarray,
    codes: list[int],
) -> None:  # fmt: skip
    """Lay a colour over luma px low..high, and over the chroma samples under them."""
    (x0, y0), (x1, y1) = np.maximum(low, 0), np.maximum(high, 0)
    planes[0][y0:y1, x0:x1] = codes[0]
    across, down = frame.chroma
    window = np.s_[y0 // down : -(-y1 // down), x0 // across : -(-x1 // across)]
    for plane, code in _chroma_views(planes, codes):
        plane[window] = code


def _chroma_views(planes: tuple[np.ndarray, ...], codes: list[int]) -> list[tuple[np.ndarray, int]]:
    """Cb and Cr as (h, w) views with a code for each, also of NV12; none of a grey picture."""
    if len(planes) < 2:
        return []
    if planes[1].ndim == 3:
        return [(planes[1][..., 0], codes[1]), (planes[1][..., 1], codes[2])]
    return [(planes[1], codes[1]), (planes[2], codes[2])]


def _tint(planes: tuple[np.ndarray, ...], frame: Frame, face: Face) -> None:
    """Mix a colour into the lips by the lip mask."""
    xy = face.points_px[LIPS, :2]
    margin = 0.1 * np.ptp(xy[:, 0])
    low = np.maximum(np.floor(xy.min(0) - margin), 0).astype(int) // 2 * 2
    high = np.ceil(xy.max(0) + margin).astype(int)
    high = np.minimum(high, [frame.width_px, frame.height_px])
    if (high <= low).any():
        return
    w, h = int(high[0] - low[0]), int(high[1] - low[1])
    weight = lip_mask_window(face, (int(low[0]), int(low[1])), (w, h)) * _TINT_OPACITY
    codes = _codes(frame, _TINT)
    _mix(planes[0][low[1] : high[1], low[0] : high[0]], weight, codes[0])
    across, down = frame.chroma
    for plane, code in _chroma_views(planes, codes):
        part = plane[low[1] // down :, low[0] // across :][: -(-h // down), : -(-w // across)]
        small = cv2.resize(weight, part.shape[1::-1], interpolation=cv2.INTER_AREA)
        _mix(part, small, code)


def _mix(plane: np.ndarray, weight: np.ndarray, code: int) -> None:
    plane[:] = np.rint(plane + weight * (code - plane.astype(np.float32))).astype(plane.dtype)


def _draw_label(planes: tuple[np.ndarray, ...], frame: Frame, face: Face) -> None:
    """Number and scores beside the face's upper left corner, upright as the viewer sees it."""
    text = f"{face.track_id}  {face.score:.2f}  mouth {face.mouth_visible:.2f}"
    size = float(np.ptp(face.points_px[:, 0]))
    scale = max(0.4, size / 400)
    (w, h), base = cv2.getTextSize(text, cv2.FONT_HERSHEY_SIMPLEX, scale, 1)
    label = np.zeros((h + base + 4, w + 4), np.uint8)
    label[:] = 16
    cv2.putText(label, text, (2, h + 2), cv2.FONT_HERSHEY_SIMPLEX, scale, 235, 1, cv2.LINE_AA)
    label = np.rot90(label, -frame.rotation_degrees // 90)
    x, y = np.maximum(face.points_px[:, :2].min(0) - [0, label.shape[0] + 4], 0).astype(int)
    luma = planes[0][y : y + label.shape[0], x : x + label.shape[1]]
    if luma.size:
        part = label[: luma.shape[0], : luma.shape[1]].astype(luma.dtype)
        luma[:] = part << max(frame.bit_depth - 8, 0)
        corner = np.array([x, y])
        grey = _codes(frame, (0, 128, 128))
        across, down = frame.chroma
        window = np.s_[
            corner[1] // down : -(-(y + part.shape[0]) // down),
            corner[0] // across : -(-(x + part.shape[1]) // across),
        ]
        for plane, code in _chroma_views(planes, grey):
            plane[window] = code
