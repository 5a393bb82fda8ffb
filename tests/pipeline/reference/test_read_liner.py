"""The form of an eyeliner, as a net reads it from the outer corners of the eyes."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from makeup_video.pipeline import Layer, Look, apply_look, find_faces, product
from makeup_video.pipeline.faces.topology import EYE_CORNERS
from makeup_video.pipeline.reference.read_liner import (
    CORNER_WH,
    CORNER_XY,
    corner_inputs,
    read_liner,
)
from people import portrait
from reference_photos import face


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
    points = face().points_px * np.float32([scale, scale, scale])
    size = tuple(int(scale * side) for side in portrait().shape[:2])
    dots = np.zeros((*size, 3), np.uint8)
    for at in EYE_CORNERS:
        x, y = np.rint(points[at, :2]).astype(int).tolist()
        cv2.circle(dots, (x, y), max(2, round(2 * scale)), (255, 255, 255), -1)
    inputs, widths_px = corner_inputs(dots, replace(face(), points_px=points))
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
