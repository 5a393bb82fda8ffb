"""The portrait under other lights, and the light estimated from it."""

from functools import cache

import numpy as np
import pytest
from makeup_video.kernels.colour import SRGB, to_encoded, to_linear
from makeup_video.kernels.program import Device
from makeup_video.pipeline import find_faces
from makeup_video.pipeline.faces.face import Face, FrameFaces, LipPatch
from makeup_video.pipeline.frames.frame import coding_of
from makeup_video.pipeline.render.scene_light import light_of
from makeup_video.pipeline.render.skin_light import STRENGTHS
from makeup_video.pipeline.render.surfaces.face import face_kernel, face_surface
from people import frame_of, portrait

NO_LIPS = LipPatch(np.zeros((80, 112), np.float32), np.eye(2, 3))


@cache
def points():
    """(478, 3) points of the portrait's face."""
    (face,) = find_faces(portrait())
    return face.points_px


def face_at(points_px, track_id=0):
    return Face(points_px.astype(np.float32), 1.0, 1.0, track_id, NO_LIPS)


_device = cache(Device)


def surface_made(face, frame):
    """A face's surface on a frame, the light there, and its mean; None without a surface."""
    return face_surface(face, frame, coding_of(frame), face_kernel(_device()))


def lit(*gain):
    """The portrait under another light: linear red, green and blue times gain."""
    linear = to_linear(portrait() / 255, SRGB) * gain
    return np.rint(to_encoded(np.clip(linear, 0, 1), SRGB) * 255).astype(np.uint8)


def light(rgb8, **layout):
    return light_of(FrameFaces(frame_of(rgb8, **layout), (face_at(points()),)))[0]


def assert_sane(light):
    assert STRENGTHS[0] * 0.999 <= light.strength <= STRENGTHS[1] * 1.001
    assert np.isfinite(light.environment).all() and (light.environment >= 0).all()
    assert (light.colour > 0.1).all() and (light.colour < 4).all()
    assert np.linalg.norm(light.direction) == pytest.approx(1, abs=1e-5)
    assert light.direction[2] < -0.3
