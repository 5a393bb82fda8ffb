"""Faces on even skin: scenes in which only the places of the face's points matter."""

from dataclasses import replace
from functools import cache

import numpy as np
from makeup import scene_of, true_face, white_light
from makeup_video.pipeline.faces.nets import load_nets
from makeup_video.pipeline.frames.frame import Frame
from makeup_video.pipeline.render.scene import FrameScene
from people import frame_of

SKIN = 200, 156, 130


@cache
def plain_frame(size_wh: tuple[int, int], pix_fmt: str = "yuv444p") -> Frame:
    wide, high = size_wh
    return frame_of(np.full((high, wide, 3), SKIN, np.uint8), pix_fmt=pix_fmt)


def plain_scene(points_px: np.ndarray, size_wh: tuple[int, int]) -> FrameScene:
    """A face with these points, (478, 2) or (478, 3), on even skin."""
    face = true_face(points_px[:, :2])
    if points_px.shape[1] == 3:
        face = replace(face, points_px=points_px.astype(np.float32))
    return scene_of(plain_frame(size_wh), (face,), white_light())


def turned_head(yaw_degrees: float, iod_px: float, middle_xy: tuple[float, float]) -> np.ndarray:
    """(478, 3) points of the mean face, px, turned to one side."""
    cos, sin = np.cos(np.radians(yaw_degrees)), np.sin(np.radians(yaw_degrees))
    turn = np.array([[cos, 0, sin], [0, 1, 0], [-sin, 0, cos]])
    points: np.ndarray = iod_px * load_nets().mean_face @ turn.T + (*middle_xy, 0)
    return points
