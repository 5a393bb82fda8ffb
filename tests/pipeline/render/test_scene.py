"""Scene lights check the shapes of their arrays, and give products on dark skin less light."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from makeup import white_light
from makeup_video.pipeline.render.scene import SceneLight


def test_white_light_is_white_and_from_the_viewers_side():
    light = white_light()
    assert (light.colour == 1).all() and light.strength == 1
    assert np.linalg.norm(light.direction) == pytest.approx(1)
    assert light.direction[2] < 0 and light.direction[1] < 0  # from the front and above


@pytest.mark.parametrize("wrong", [0, 1, 2])
def test_a_light_of_other_shapes_is_refused(wrong):
    parts = [np.ones(3), np.array([0, 0, -1.0]), np.zeros((16, 16, 3))]
    parts[wrong] = np.ones((4, 4))
    with pytest.raises(ValueError, match=r"\(16, 16, 3\)"):
        SceneLight(parts[0], 1.0, parts[1], parts[2])


@given(st.floats(0.15, 2.0), st.floats(1e-3, 1.0), st.floats(1.0, 1.3))
def test_darker_skin_gets_less_light_but_half_at_least(strength, skin, lighter):
    on_dark, on_light = (
        replace(white_light(), strength=strength, skin=luminance).strength_for_products
        for luminance in (skin, lighter * skin)
    )
    bounded = min(strength, 1.05)
    assert 0.44 * bounded < on_dark <= on_light <= bounded
    assert on_light <= lighter * on_dark * (1 + 1e-9)  # no step, or a video would flicker


@pytest.mark.parametrize("skin", [0.0, 0.3, 0.9])
def test_light_or_unknown_skin_gives_all_of_the_light(skin):
    light = replace(white_light(), strength=0.7, skin=skin)
    assert light.strength_for_products == 0.7


@given(st.floats(1.1, 2.0))
def test_products_do_not_glow_on_skin_that_seems_bright(strength):
    assert replace(white_light(), strength=strength, skin=0.9).strength_for_products < 1.1
