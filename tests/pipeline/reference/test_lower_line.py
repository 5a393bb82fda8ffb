"""The lower line of an eyeliner, told by how dark the skin below the eye is."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from makeup_video.pipeline import Layer, Look, apply_look, product
from makeup_video.pipeline.reference.estimate import estimate
from makeup_video.pipeline.reference.flat_eyes import FLAT_HW
from makeup_video.pipeline.reference.lower_line import darkness, lower_line
from people import portrait
from reference_photos import face

LIGHT = st.floats(0.05, 1.5)


def eyes_of(near, elsewhere=1.0):
    """Flat eyes whose skin has one root of light below the eye, and another one elsewhere."""
    eyes = np.full((*FLAT_HW, 3), elsewhere, np.float32)
    eyes[20:22] = near
    return eyes


@given(LIGHT, LIGHT)
def test_darkness_is_that_of_the_skin_below_the_eye(near, elsewhere):
    expected = 0.3 * np.log(elsewhere) - np.log(near)
    assert darkness(eyes_of(near, elsewhere)) == pytest.approx(expected, abs=1e-5)


@given(LIGHT, LIGHT)
def test_the_darker_the_skin_the_sooner_there_is_a_line(one, other):
    low, high = sorted((one, other))
    assert lower_line(eyes_of(low)) >= lower_line(eyes_of(high))


def test_bare_and_hidden_eyes_have_no_lower_line():
    assert lower_line(eyes_of(0.9)) == lower_line(None) == 0
    assert lower_line(eyes_of(0.3)) > 0


def test_an_eye_with_smoke_below_is_read_with_a_lower_line():
    black = product((12, 10, 10), "matte", "eyes")
    liner = Layer("eyeliner", product((12, 10, 10), "matte", "liner"), {"thickness": 0.3})
    below = Layer("eyeshadow", black, {"slot": "under"})
    read = {}
    for name, layers in (("line", [liner]), ("smoke", [below, liner])):
        made_up = apply_look(portrait(), Look(layers), [face()])
        (read[name],) = estimate(made_up, face()).look.of("eyeliner")
    assert "lower" not in read["line"].shape and read["smoke"].shape["lower"] > 0
