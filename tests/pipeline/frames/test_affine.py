"""Affine maps as plain numbers equal those as arrays."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st
from makeup_video.pipeline.frames.affine import Affine, compose, invert

numbers = st.floats(-100, 100)
maps = st.builds(Affine, *[numbers] * 6)
small = st.builds(Affine, *[st.floats(-3, 3)] * 6)


def apply(affine: Affine, x: float, y: float) -> tuple[float, float]:
    across, down = affine.array() @ [x, y, 1]
    return float(across), float(down)


@given(maps)
def test_a_map_and_its_array_hold_the_same_numbers(affine):
    assert affine.array().shape == (2, 3)
    assert affine.array().dtype == np.float64
    assert Affine.from_array(affine.array()) == affine


@given(maps, maps, numbers, numbers)
def test_the_first_map_is_applied_first(second, first, x, y):
    want = apply(second, *apply(first, x, y))
    assert apply(second.after(first), x, y) == pytest.approx(want, rel=1e-9, abs=1e-4)
    np.testing.assert_allclose(
        second.after(first).array(), compose(second.array(), first.array()), atol=1e-9
    )


@given(maps, numbers, numbers)
def test_the_inverse_leads_back(affine, x, y):
    assume(abs(affine.area) > 0.1)
    moved = apply(affine, x, y)
    assert apply(affine.inverse(), *moved) == pytest.approx((x, y), abs=1e-3)
    assert affine.solve(*moved) == pytest.approx((x, y), abs=1e-3)
    np.testing.assert_allclose(
        affine.inverse().array(), invert(affine.array()), rtol=1e-6, atol=1e-6
    )


def test_a_map_without_an_inverse_is_inverted_to_zeros():
    flat = Affine(1.0, 2.0, 3.0, 2.0, 4.0, 5.0)
    assert flat.inverse() == (0, 0, 0, 0, 0, 0)
    assert not invert(flat.array()).any()


def test_several_maps_are_composed_at_once():
    double, shift = np.array([[2.0, 0, 0], [0, 2, 0]]), np.array([[1.0, 0, 5], [0, 1, 7]])
    several = compose(double, np.stack([shift, double]))
    assert several.shape == (2, 2, 3)
    np.testing.assert_array_equal(several[0], compose(double, shift))


@given(small, small)
def test_maps_in_plain_numbers_are_those_of_matrices(a, b):
    full = [np.array([[*m[:3]], [*m[3:]], [0, 0, 1]]) for m in (a, b)]
    np.testing.assert_allclose(a.after(b), (full[0] @ full[1])[:2].ravel(), atol=1e-12)
    if abs(np.linalg.det(full[0])) > 0.1:
        np.testing.assert_allclose(a.inverse(), np.linalg.inv(full[0])[:2].ravel(), atol=1e-9)
