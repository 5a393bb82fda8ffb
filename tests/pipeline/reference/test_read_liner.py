"""The form of an eyeliner, as a net reads it from the outer corners of the eyes."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from makeup_video.pipeline import Layer, Look, apply_look, find_faces, product
from makeup_video.pipeline.faces.topology import EYE_CORNERS
from makeup_video.pipeline.look.kinds import KINDS
from makeup_video.pipeline.reference import read_liner as read_liner_module
from makeup_video.pipeline.reference.liner import liner
from makeup_video.pipeline.reference.makeup_numbers import ReadLayer
from makeup_video.pipeline.reference.read_liner import (
    CORNER_WH,
    CORNER_XY,
    LinerForm,
    Wing,
    corner_inputs,
    read_liner,
)
from people import portrait
from reference_photos import dots_at, face


def lined(**shape):
    """The portrait with a black liner."""
    black = product((12, 10, 10), "matte", "liner")
    return apply_look(portrait(), Look([Layer("eyeliner", black, shape)]), [face()])


@pytest.mark.parametrize("length", [0.2, 0.3, 0.45])
@pytest.mark.parametrize("angle", [15.0, 30.0, 45.0])
def test_a_wing_is_read_with_length_and_angle(length, angle):
    wing = read_liner(lined(wing=length, wing_angle=angle), face()).wing
    assert wing is not None
    assert wing.length == pytest.approx(length, abs=0.12)
    assert wing.angle == pytest.approx(angle, abs=15)
    assert wing.is_sure or length < 0.3


@pytest.mark.parametrize("thickness", [0.06, 0.12, 0.3])
def test_a_liner_without_a_wing_and_bare_eyes_have_none(thickness):
    assert read_liner(lined(thickness=thickness), face()).wing is None
    assert read_liner(portrait(), face()).wing is None


def test_a_mirrored_photo_has_the_same_wing():
    winged = lined(wing=0.35, wing_angle=30.0)
    other = np.ascontiguousarray(winged[:, ::-1])
    wing, mirrored = read_liner(winged, face()).wing, read_liner(other, find_faces(other)[0]).wing
    assert wing is not None and mirrored is not None
    assert mirrored.length == pytest.approx(wing.length, abs=0.06)


@pytest.mark.parametrize("scale", [0.4, 1.0, 3.0])
def test_inputs_have_the_outer_corner_in_its_place(scale):
    inputs, widths_px = corner_inputs(*dots_at(EYE_CORNERS, scale))
    assert inputs.shape == (2, *CORNER_WH[::-1], 3) and (widths_px > 0).all()
    for one in inputs:
        y, x = np.argwhere(one[..., 0] > 0.5 * one.max()).mean(0)
        assert (x, y) == pytest.approx(CORNER_XY, abs=1 + 1 / scale)


def test_an_eye_that_is_turned_away_does_not_count():
    winged = lined(wing=0.35, wing_angle=30.0)
    points = face().points_px.copy()
    inner, outer = points[362, :2], points[263, :2]
    points[362, :2] = outer + 0.5 * (inner - outer)  # half as wide: seen from the side
    hidden = winged.copy()
    x, y = outer.astype(int)
    hidden[y - 60 : y + 60, x - 20 :] = 128
    turned = replace(face(), points_px=points)
    assert read_liner(hidden, turned) == read_liner(winged, turned)


def form_of(numbers, eyeshadow=0.0):
    """The form that is read when the net returns these numbers."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(read_liner_module, "liner_numbers", lambda *_: np.array(numbers))
        return read_liner(portrait(), face(), eyeshadow)


@given(log_odds=st.floats(-4, 6), less=st.floats(0, 1), more=st.floats(0, 1))
def test_the_likelier_eyeshadow_the_surer_a_wing_must_be(log_odds, less, more):
    shares, numbers = sorted((less, more)), (log_odds, 0.3, 0.1, 0.15)
    with_less, with_more = (form_of(numbers, share).wing for share in shares)
    assert with_more is None or with_less == with_more


def test_smoke_hides_a_wing_of_which_the_net_is_hardly_sure():
    assert form_of((1.0, 0.3, 0.1, 0.15), 0.5).wing is not None
    assert form_of((1.0, 0.3, 0.1, 0.15), 1.0).wing is None
    assert form_of((4.0, 0.3, 0.1, 0.15), 1.0).wing.is_sure


@given(length=st.floats(-2, 3), angle=st.floats(-3, 3), low=st.floats(-1, 2), high=st.floats(-1, 2))
def test_dials_stay_in_range_and_thicker_lines_stay_thicker(length, angle, low, high):
    dials = {dial.name: dial for dial in KINDS["eyeliner"].dials}
    forms = [form_of((5.0, length, angle, thickness)) for thickness in sorted((low, high))]
    for form in forms:
        shape = {"thickness": form.thickness, "wing": form.wing.length}
        shape["wing_angle"] = form.wing.angle
        for name, value in shape.items():
            assert dials[name].low <= value <= dials[name].high
    assert forms[0].thickness <= forms[1].thickness


def test_a_layer_of_eyeliner_has_the_form_that_was_read():
    read = ReadLayer("eyeliner", "", 0.9, (20.0, 10.0, 10.0), {})
    plain = liner(read, LinerForm(0.2))
    assert plain.shape == {"thickness": 0.2}
    whole = liner(read, LinerForm(0.1, Wing(0.3, -5.0)), lower=0.45)
    assert whole.shape == {"thickness": 0.1, "lower": 0.45, "wing": 0.3, "wing_angle": -5.0}
    assert liner(read, LinerForm(0.2), probability=0.3).product.opacity < plain.product.opacity
