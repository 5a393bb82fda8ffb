"""How lipstick shines and fades, as a net reads it from the mouth."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from makeup_video.pipeline import Layer, Look, apply_look, find_faces, product
from makeup_video.pipeline.faces.topology import MOUTH_CORNERS
from makeup_video.pipeline.look.kinds import KINDS
from makeup_video.pipeline.reference import read_lipstick as read_lipstick_module
from makeup_video.pipeline.reference.read_lipstick import (
    MOUTH_PX,
    MOUTH_WH,
    lipstick_numbers,
    mouth_input,
    mouth_place,
    read_lipstick,
)
from people import portrait
from reference_photos import dots_at, face


def wearing(gloss=0.0, **shape):
    """The portrait with a red lipstick."""
    worn = replace(product((190, 20, 50), "satin", "lips"), gloss=gloss)
    return apply_look(portrait(), Look([Layer("lipstick", worn, shape)]), [face()])


@settings(max_examples=6, deadline=None)
@given(st.floats(0, 0.3), st.floats(0.6, 1))
def test_lipstick_that_fades_more_is_read_so(little, much):
    one, other = (read_lipstick(wearing(gradient=fade), face()).gradient for fade in (little, much))
    assert 0 <= one < other <= 1


@settings(max_examples=6, deadline=None)
@given(st.floats(0, 0.2), st.floats(0.9, 1.3))
def test_glossier_lipstick_is_read_as_glossier(dull, glossy):
    one, other = (lipstick_numbers(wearing(gloss), face())[0] for gloss in (dull, glossy))
    assert one < other


def test_a_mirrored_photo_has_about_the_same_form():
    seen = wearing(0.8, gradient=0.7)
    mirrored = np.ascontiguousarray(seen[:, ::-1])
    read, again = (
        lipstick_numbers(rgb8, found)
        for rgb8, found in ((seen, face()), (mirrored, find_faces(mirrored)[0]))
    )
    # the points differ by half a pixel of the input, which changes how its highlights look
    assert again == pytest.approx(read, abs=0.35)


@pytest.mark.parametrize("scale", [0.4, 1.0, 3.0])
def test_the_input_has_the_corners_of_the_mouth_level(scale):
    seen = mouth_input(*dots_at(MOUTH_CORNERS, scale))
    assert seen.shape == (*MOUTH_WH[::-1], 3) and seen.dtype == np.uint8
    half = MOUTH_WH[0] // 2
    corners = []
    for part in (seen[:, :half, 0], seen[:, half:, 0]):
        y, x = np.argwhere(part > 0.5 * part.max()).mean(0)
        corners.append((x, y))
    (left, first), (right, second) = corners
    assert first == pytest.approx(second, abs=1 + 1 / scale)
    assert right + half - left == pytest.approx(MOUTH_PX, abs=1 + 2 / scale)


def test_a_mouth_without_width_still_has_an_input():
    points = face().points_px.copy()
    points[MOUTH_CORNERS[1]] = points[MOUTH_CORNERS[0]]
    to_px = mouth_place(replace(face(), points_px=points))
    assert np.isfinite(to_px).all() and abs(np.linalg.det(to_px[:, :2])) > 0


def test_the_lips_lie_about_the_middle_row_of_the_input():
    to_px = mouth_place(face())
    middle = face().points_px[[0, 17], :2].mean(0, dtype=np.float64)
    _, row = np.linalg.solve(to_px[:, :2], middle - to_px[:, 2])
    assert row == pytest.approx((MOUTH_WH[1] - 1) / 2, abs=0.01)


def form_of(gloss, fade):
    """The form that is read when the net returns these numbers."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(read_lipstick_module, "lipstick_numbers", lambda *_: np.array((gloss, fade)))
        return read_lipstick(portrait(), face())


@given(gloss=st.floats(-2, 6), fade=st.floats(-2, 6), more=st.floats(0, 3))
def test_what_is_painted_stays_in_range_and_never_falls(gloss, fade, more):
    one, other = form_of(gloss, fade), form_of(gloss + more, fade + more)
    dials = {dial.name: dial for dial in KINDS["lipstick"].dials}
    for form in (one, other):
        assert dials["gradient"].low <= form.gradient <= dials["gradient"].high
        assert 0 <= form.gloss <= 3
    assert one.gloss <= other.gloss and one.gradient <= other.gradient
