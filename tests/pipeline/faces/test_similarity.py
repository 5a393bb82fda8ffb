"""Similarities in complex numbers equal those in matrices."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from makeup_video.pipeline.faces.similarity import (
    STAY,
    Similarity,
    distance,
    iod_of,
    middle_of,
)

numbers = st.complex_numbers(min_magnitude=0.01, max_magnitude=1000)
similarities = st.builds(Similarity, numbers, numbers)


@given(similarities, similarities, numbers)
def test_the_first_map_is_done_first(second, first, place):
    both = second.after(first)
    assert both.apply(place) == pytest.approx(second.apply(first.apply(place)), rel=1e-9, abs=1e-6)
    xy = both.array() @ [place.real, place.imag, 1]
    assert complex(*xy) == pytest.approx(both.apply(place), rel=1e-9, abs=1e-6)


@given(similarities, similarities)
def test_interpolation_begins_and_ends_at_its_two_maps(a, b):
    assert a.towards(b, 0) == a
    assert np.allclose(a.towards(b, 1), b)


def test_a_pose_has_a_centre_a_size_and_a_distance():
    pose = Similarity(100 + 0j, 300 + 200j)
    assert iod_of(pose) == 100
    assert middle_of(pose) == pytest.approx(300 + 242j)
    assert distance(pose, pose) == 0
    assert distance(pose, Similarity(pose.turn, pose.shift + 30)) == pytest.approx(0.3)
    assert distance(pose, STAY) > 2
    turned = Similarity(pose.turn * 1j, 0j)
    turned = Similarity(turned.turn, middle_of(pose) - middle_of(turned))
    assert distance(pose, turned) == pytest.approx(np.pi / 2)
