"""Eyeshadow that one eye alone wears."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from makeup import close_up, close_up_scene, paint_planes, product
from makeup_video.pipeline.errors import LookError
from makeup_video.pipeline.look.kinds import KINDS
from makeup_video.pipeline.look.look import Layer, Look

SLOTS = tuple(KINDS["eyeshadow"].slots)
MOST = KINDS["eyeshadow"].most
GREEN, VIOLET = product(red=0, green=90, blue=40), product(red=90, green=0, blue=140)


def shadow(worn, eye, slot="lid"):
    return Layer("eyeshadow", worn, {"slot": slot, "eye": eye})


def painted(*layers):
    return np.stack([plane.astype(int) for plane in paint_planes(close_up_scene(), Look(layers))])


def halves(planes):
    """Left and right of the bridge of the nose, in the picture: the wearer's right and left."""
    _, points = close_up()
    middle = round(float(points[168, 0]))
    return planes[..., :middle], planes[..., middle:]


@pytest.mark.parametrize("slot", SLOTS)
@pytest.mark.parametrize("eye", ["left", "right"])
def test_the_other_eye_stays_bare(eye, slot):
    bare, both = halves(painted()), halves(painted(shadow(GREEN, "both", slot)))
    one = halves(painted(shadow(GREEN, eye, slot)))
    worn = ["right", "left"].index(eye)
    assert (one[worn] == both[worn]).all() and (one[worn] != bare[worn]).any()
    assert (one[1 - worn] == bare[1 - worn]).all()


@pytest.mark.parametrize("slot", SLOTS)
def test_in_a_mirrored_picture_each_eye_is_still_the_wearers(slot):
    scene, look = close_up_scene(), Look([shadow(GREEN, "right", slot)])
    scene = replace(scene, frame=replace(scene.frame, is_mirrored=True))
    got = np.stack([plane.astype(int) for plane in paint_planes(scene, look)])
    assert (got == painted(shadow(GREEN, "left", slot))).all()


@settings(max_examples=10, deadline=None)
@given(st.sampled_from(SLOTS), st.sampled_from(SLOTS))
def test_each_eye_wears_its_own(first, second):
    right, left = halves(painted(shadow(GREEN, "right", first), shadow(VIOLET, "left", second)))
    assert (right == halves(painted(shadow(GREEN, "both", first)))[0]).all()
    assert (left == halves(painted(shadow(VIOLET, "both", second)))[1]).all()


def test_the_same_on_each_eye_is_the_same_on_both():
    layers = [GREEN, VIOLET]
    apart = [shadow(one, eye) for eye in ("left", "right") for one in layers]
    wanted = painted(*[shadow(one, "both") for one in layers])
    assert (painted(*apart) == wanted).all()


@settings(max_examples=30, deadline=None)
@given(st.lists(st.sampled_from(["both", "left", "right"]), max_size=2 * MOST + 1))
def test_an_eye_has_at_most_so_many_layers(eyes):
    layers = [shadow(GREEN, eye) for eye in eyes]
    on_each = [sum(one != other for one in eyes) for other in ("left", "right")]
    if max(on_each) > MOST:
        with pytest.raises(LookError, match=f"at most {MOST} layers of eyeshadow"):
            Look(layers)
        with pytest.raises(LookError, match=f"at most {MOST} layers of eyeshadow"):
            Look.from_dict({"version": 2, "layers": [layer.to_dict() for layer in layers]})
    else:
        assert Look.from_dict(Look(layers).to_dict()) == Look(layers)
