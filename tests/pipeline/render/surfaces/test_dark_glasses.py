"""Dark glasses: eye makeup is not painted on them, but behind clear ones it is."""

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from layers import SLOTS, shadow
from lit_faces import face_at, light, points
from makeup_video.pipeline import Layer, Look, apply_look, product
from makeup_video.pipeline.faces.face import FrameFaces
from makeup_video.pipeline.faces.topology import EYE, RIGHT_EYE
from makeup_video.pipeline.render.scene import FaceScene
from makeup_video.pipeline.render.scene_light import light_of
from makeup_video.pipeline.render.surfaces.eyes import EYES
from people import frame_of, portrait

LEFT, RIGHT = EYE[:16], RIGHT_EYE[:16]
LINER = Layer("eyeliner", product((18, 14, 14), "matte", "liner"), {"wing": 0.3})


def lenses(eyes, line_px=-1):
    """The portrait's lenses as a mask, filled or as frames of a width: (H, W) 0..1."""
    mask = np.zeros(portrait().shape[:2], np.uint8)
    for eye in eyes:
        x, y = points()[eye, :2].mean(0)
        wide = np.ptp(points()[eye, 0])
        middle, axes = (round(x), round(y + 0.15 * wide)), (round(0.85 * wide), round(0.65 * wide))
        cv2.ellipse(mask, middle, axes, 0, 0, 360, 1, line_px)
    return mask[..., None].astype(np.float32)


def behind(share, eyes=(LEFT, RIGHT), line_px=-1):
    """The portrait with a share of its codes behind glass."""
    return np.rint(portrait() * (1 - (1 - share) * lenses(eyes, line_px))).astype(np.uint8)


def amount(rgb8):
    return EYES.amount(FaceScene(face_at(points()), light(rgb8), {}))


def change(rgb8, layer):
    painted = apply_look(rgb8, Look([layer]), [face_at(points())])
    return np.abs(painted.astype(int) - rgb8).max()


@pytest.mark.parametrize("layer", [*map(shadow, SLOTS), LINER], ids=[*SLOTS, "liner"])
def test_no_eye_makeup_is_painted_on_black_lenses(layer):
    assert change(portrait(), layer) > 20
    assert change(behind(0.15), layer) == 0


@settings(max_examples=15, deadline=None)
@given(shares=st.tuples(*[st.floats(0.1, 1.0)] * 2))
def test_the_darker_the_lenses_the_less_is_painted(shares):
    darker, lighter = sorted(shares)
    assert 0 <= amount(behind(darker)) <= amount(behind(lighter)) + 1e-6
    assert amount(behind(max(lighter, 0.85))) == 1


def test_frames_of_clear_glasses_do_not_hide_the_eyes():
    assert amount(behind(0.1, line_px=3)) == 1


@pytest.mark.parametrize("eye", [LEFT, RIGHT])
def test_a_shadow_on_one_side_does_not_hide_the_eyes(eye):
    assert amount(behind(0.1, (eye,))) == 1


def test_eyes_beyond_the_picture_count_as_seen():
    top = int(points()[LEFT, 1].max()) + 25  # below the eyes: only the lower face is left
    cut = np.ascontiguousarray(portrait()[top:])
    face = face_at(points() - np.array([0, top, 0], np.float32))
    (below,) = light_of(FrameFaces(frame_of(cut), (face,)))
    assert EYES.amount(FaceScene(face, below, {})) == 1
