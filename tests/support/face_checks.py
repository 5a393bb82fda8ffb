"""Runs pictures through the tracker, and checks the faces it finds."""

import numpy as np
from makeup_video.pipeline import Face, FindFaces
from makeup_video.pipeline.faces.topology import EYE_CORNERS
from people import frame_of


def inter_ocular(points: np.ndarray) -> float:
    a, b = points[list(EYE_CORNERS), :2]
    return float(np.linalg.norm(a - b))


def error_percent(face: Face, true: np.ndarray, index=slice(None)) -> float:
    off = np.linalg.norm(face.points_px[index, :2] - true[index], axis=1)
    return 100 * float(off.mean()) / inter_ocular(true)


def run(pictures, finder: FindFaces | None = None, *, first_pts=0, **how):
    """FrameFaces of each picture, tracked as a video."""
    finder = finder or FindFaces()
    return [finder(frame_of(p, first_pts + index, **how)) for index, p in enumerate(pictures)]


def middle(face: Face) -> np.ndarray:
    return face.points_px[:, :2].mean(0)


def wall() -> np.ndarray:
    y, x = np.mgrid[0:360, 0:640]
    return np.dstack([(90 + 80 * np.sin(x / 25) * np.cos(y / 30)).astype(np.uint8)] * 3)


def assert_sound(faces, size_wh):
    for face in faces:
        assert np.isfinite(face.points_px).all()
        assert face.points_px.dtype == np.float32
        assert 0 <= face.score <= 1
        assert 0 <= face.mouth_visible <= 1
        assert np.ptp(face.points_px[:, 0]) > 10
        middle_x, middle_y = middle(face)
        assert -200 < middle_x < size_wh[0] + 200
        assert -200 < middle_y < size_wh[1] + 200
