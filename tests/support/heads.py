"""Faces and frames for tests: a talking, turning, blinking head with known true points."""

from fractions import Fraction
from pathlib import Path

import av
import numpy as np
from makeup_video.pipeline.faces.face import PATCH_SPAN, Face, FrameFaces, LipPatch
from makeup_video.pipeline.faces.topology import LIPS
from makeup_video.pipeline.frames.colour_tags import ColourTags
from makeup_video.pipeline.frames.frame import Frame

_FILE = np.load(Path(__file__).parents[2] / "samples" / "in_points.npz")
HEAD_PX = _FILE["points"] * float(_FILE["unit"])  # (300, 478, 2), 30 frames a second
IOD_PX = float(np.linalg.norm(HEAD_PX[0, 33] - HEAD_PX[0, 263]))  # outer eye corners
UPPER_LID, LOWER_LID = 159, 145
_PICTURE = av.VideoFrame(16, 16, "yuv420p")


def frame(pts, time_base=Fraction(1, 30)):
    return Frame(_PICTURE, pts, time_base, ColourTags())


def lip_logits(hw=(80, 112)):
    """(H, W) float32: an ellipse of lipstick, 4 in its middle."""
    y, x = np.mgrid[0 : hw[0], 0 : hw[1]].astype(np.float32)
    u, v = (x - hw[1] / 2) / (0.31 * hw[1]), (y - hw[0] / 2) / (0.22 * hw[0])
    return 4 - 6 * (u * u + v * v)


_LOGITS = lip_logits()


def face(points_px, track_id=0, logits=_LOGITS, to_px=None, score=0.9, mouth_visible=1.0):
    """A face with these points, (478, 2) or (478, 3), and a crop around its lips."""
    points_px = np.asarray(points_px)
    if points_px.shape[1] == 2:
        # any plausible depth
        z = 0.3 * np.abs(points_px[:, 0] - points_px[:, 0].mean())
        points_px = np.column_stack([points_px, z])
    if to_px is None:
        h, w = logits.shape
        step = PATCH_SPAN * np.linalg.norm(points_px[33, :2] - points_px[263, :2]) / w
        x, y = points_px[LIPS, :2].mean(0)
        to_px = np.array([[step, 0, x - (w - 1) / 2 * step], [0, step, y - (h - 1) / 2 * step]])
    patch = LipPatch(logits.astype(np.float32), to_px)
    return Face(points_px.astype(np.float32), score, mouth_visible, track_id, patch)


def run_stage(stage, items):
    """All outputs of a stage, in order."""
    out = [result for result in map(stage, items) if result is not None]
    return out + list(getattr(stage, "drain", tuple)())


def frames_of(faces, time_base=Fraction(1, 30), every=1):
    """One face per frame; None is a frame without a face."""
    return [
        FrameFaces(frame(index * every, time_base), () if item is None else (item,))
        for index, item in enumerate(faces)
    ]


def xy_px(items):
    """(N, 478, 2) points of the first face of each item, px."""
    return np.array([item.faces[0].points_px[:, :2] for item in items], np.float64)


def rms(error_px, points=slice(None)):
    """Root mean square of an (N, 478, 2) error, over frames, points and both axes."""
    return float(np.sqrt((error_px[:, points] ** 2).mean()))
