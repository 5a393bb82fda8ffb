"""Tests of pipeline/look/kinds/density_map.py: a map as text, and what lies where."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from looks import density_maps
from makeup_video.pipeline.errors import LookError
from makeup_video.pipeline.look.kinds.density_map import (
    HW,
    check_text,
    density_at,
    from_text,
    heights,
    places_across,
    to_text,
)
from makeup_video.pipeline.look.kinds.fields import EyeChart

FULL = to_text(np.ones(HW))


def chart(across, height):
    return EyeChart(height >= 0, np.float32([[[across]]]), np.float32([[[height]]]))


def at(text, across, height):
    return float(density_at(chart(across, height), text)[0, 0, 0])


@given(density_maps())
def test_a_map_survives_as_text_to_one_level(densities):
    text = to_text(densities)
    check_text(text, "map")
    assert np.abs(from_text(text) - densities).max() <= 0.5 / 61 + 1e-6
    assert to_text(from_text(text)) == text


@given(density_maps(), st.integers(0, HW[0] - 1), st.integers(0, HW[1] - 1))
def test_each_cell_has_its_place(densities, row, column):
    places = np.concatenate([heights(True), heights(False)])
    found = at(to_text(densities), places_across()[column], places[row])
    assert found == pytest.approx(densities[row, column], abs=0.01)


@given(density_maps(), st.floats(-2, 3), st.floats(-4, 4))
def test_a_density_is_a_share_wherever_it_is_asked_for(densities, across, height):
    assert -1e-6 <= at(to_text(densities), across, height) <= 1 + 1e-6


@given(st.floats(-0.4, 1.6), st.floats(2.5, 4) | st.floats(-4, -1.7))
def test_a_map_ends_beyond_its_rows(across, height):
    assert at(FULL, across, height) == 0


@given(st.floats(-0.4, 1.6), st.floats(-1.3, 2.1))
def test_a_full_map_is_full_up_to_its_last_rows(across, height):
    assert at(FULL, across, height) == pytest.approx(1)


WRONG = [FULL[1:], FULL + " ", FULL.replace(" ", "", 1), "!" + FULL[1:], FULL.replace(" ", "\n")]


@pytest.mark.parametrize("text", [*WRONG, None, 3, ["Z"], "nose", " ", {}])
def test_what_is_no_map_is_refused_in_one_line(text):
    with pytest.raises(LookError, match=r"^shape\.map must be 27 rows of 24 characters") as caught:
        check_text(text, "shape.map")
    assert "\n" not in str(caught.value)


def test_an_empty_text_is_no_map():
    check_text("", "shape.map")
