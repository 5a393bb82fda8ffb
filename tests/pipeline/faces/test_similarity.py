"""Similarities in complex numbers are those of matrices."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from makeup_video.pipeline.faces.similarity import (
    STAY,
    Similarity,
    distance,
    from_matrix,
    iod_of,
    middle_of,
)

numbers = st.complex_numbers(min_magnitude=0.01, max_magnitude=1000)
similarities = st.builds(Similarity, numbers, numbers)


def matrix_of(similarity: Similarity) -> np.ndarray:
    turn, shift = similarity
    return np.array([[turn.real, -turn.imag, shift.real], [turn.imag, turn.real, shift.imag]])


@given(similarities, similarities, numbers)
def test_the_first_map_is_done_first(second, first, place):
    both = second.after(first)
    assert both.of(place) == pytest.approx(second.of(first.of(place)), rel=1e-9, abs=1e-6)
    assert from_matrix(matrix_of(both)) == both
    xy = matrix_of(both) @ [place.real, place.imag, 1]
    assert complex(*xy) == pytest.approx(both.of(place), rel=1e-9, abs=1e-6)


@given(similarities, similarities)
def test_a_part_of_the_way_begins_and_ends_where_the_whole_does(a, b):
    assert a.towards(b, 0) == a
    assert np.allclose(a.towards(b, 1), b)


def test_a_frame_tells_where_a_face_is_and_how_far_two_are_apart():
    frame = Similarity(100 + 0j, 300 + 200j)
    assert iod_of(frame) == 100
    assert middle_of(frame) == pytest.approx(300 + 242j)
    assert distance(frame, frame) == 0
    assert distance(frame, Similarity(frame.turn, frame.shift + 30)) == pytest.approx(0.3)
    assert distance(frame, STAY) > 2
    turned = Similarity(frame.turn * 1j, 0j)
    turned = Similarity(turned.turn, middle_of(frame) - middle_of(turned))
    assert distance(frame, turned) == pytest.approx(np.pi / 2)
