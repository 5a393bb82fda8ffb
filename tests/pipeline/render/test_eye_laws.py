"""What holds for every look: the eyeball stays as it is, and lids are followed."""

import numpy as np
import pytest
from laws import OPEN_MOUTHS, WORN, sample_scenes, share_changed, true_px
from layers import SLOTS
from makeup import (
    close_up,
    inside,
    paint_planes,
    product,
    scene_of,
    true_face,
    weights_of,
    white_light,
)
from makeup_video.pipeline.faces.topology import EYE_CONTOUR, RIGHT_EYE
from makeup_video.pipeline.look.look import Layer, Look
from people import frame_of


@pytest.mark.parametrize("slot", SLOTS)
@pytest.mark.parametrize("number", OPEN_MOUTHS)
def test_eye_shadow_is_never_on_the_eyeball(number, slot):
    scene = sample_scenes()[number]
    scene = scene_of(scene.frame, (true_face(true_px(number)),))
    worn = WORN.with_kind("eyeshadow", [Layer("eyeshadow", WORN.eyes, {"slot": slot})])
    old, new = scene.frame.planes[0], paint_planes(scene, worn)[0]
    assert (old != new).any()
    for contour in (EYE_CONTOUR, RIGHT_EYE[:16]):
        within = inside(true_px(number)[contour], old.shape, 0.5)
        assert within.sum() > 500
        np.testing.assert_array_equal(new[within], old[within])


@pytest.mark.parametrize("number", OPEN_MOUTHS)
def test_found_lids_are_right_to_two_pixels(number):
    for contour in (EYE_CONTOUR, RIGHT_EYE[:16]):
        assert share_changed(number, contour, 2, WORN) < 0.01


def test_eye_shadow_follows_a_blink(monkeypatch):
    """Frame 75 has closed eyes: the lid is painted down to where the eye was."""
    reach = []
    for number in (60, 75):
        rgb8, points = close_up(number, (200, 60, 440, 300))
        scene = scene_of(frame_of(rgb8), (true_face(points),), white_light())
        weight = weights_of(scene, Look(eyes=product()), monkeypatch)
        corners = points[[33, 133]].mean(0)
        column = weight[:, round(corners[0])]
        reach.append(np.flatnonzero(column > 0.3).max() - corners[1])
    assert reach[1] > reach[0] + 3
