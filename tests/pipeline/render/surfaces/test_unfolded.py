"""Eyeshadow on a lid that unfolds: dense along the lashes, and no bar with upright ends."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from makeup_video.kernels.shares import CHART_HEIGHT, CHART_ROWS
from makeup_video.kernels.surface import LID_HW
from makeup_video.pipeline.render.surfaces.surface import Charts
from makeup_video.pipeline.render.surfaces.unfolded import STEPS, step_of, unfolded, upper_charts

HW = CHART_ROWS * CHART_HEIGHT + 1, LID_HW[1]
CREASE = CHART_ROWS
COUNTS = st.integers(1, 4)
ANY_STEP = st.integers(0, STEPS)


def bar():
    """Dark from the lashes to above the crease, with upright ends."""
    chart = np.zeros((*HW, 1), np.float32)
    chart[: round(1.2 * CREASE), 22:34] = 1
    return chart


def any_chart(seed, count):
    """Cells of density, as large as those of a density map."""
    cells = np.random.default_rng(seed).uniform(0, 1, (-(-HW[0] // 8), -(-HW[1] // 2), count))
    return cells.repeat(8, 0).repeat(2, 1)[: HW[0], : HW[1]].astype(np.float32)


@given(st.floats(-1, 2), st.floats(0, 1))
def test_lids_unfold_as_an_eye_shuts(opening, less):
    assert 0 <= step_of(opening) <= step_of(opening - less) <= STEPS


@pytest.mark.parametrize(
    ("opening", "step"), [(0.25, 0), (0.4, 0), (0.125, STEPS // 2), (0, STEPS)]
)
def test_open_and_shut_eyes_are_the_ends(opening, step):
    assert step_of(opening) == step


def test_an_open_eye_keeps_its_chart():
    chart = bar()
    assert unfolded(chart, 0) is chart


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 9999), COUNTS, ANY_STEP)
def test_no_density_is_higher_or_lower_than_before(seed, count, step):
    before = any_chart(seed, count)
    after = unfolded(before, step)
    assert after.shape == before.shape and after.dtype == np.float32
    assert (after >= before.min((0, 1)) - 1e-5).all()
    assert (after <= before.max((0, 1)) + 1e-5).all()


@settings(max_examples=30, deadline=None)
@given(st.integers(0, 9999), COUNTS, st.integers(0, STEPS - 1))
def test_a_step_more_is_hardly_seen(seed, count, step):
    chart = unfolded(any_chart(seed, count), STEPS // 2)  # as soft as a map read from a photo
    assert np.abs(unfolded(chart, step + 1) - unfolded(chart, step)).max() < 0.06


def test_what_fades_upwards_still_does():
    """So no gap opens between the lashes and the crease."""
    falls = np.linspace(1, 0, HW[0], dtype=np.float32)[:, None, None]
    chart = np.tile(falls * falls, (1, HW[1], 1))
    for step in (1, STEPS // 2, STEPS):
        assert np.diff(unfolded(chart, step), axis=0).max() <= 1e-5


def test_a_bar_becomes_a_dome_on_a_shut_lid():
    shut = unfolded(bar(), STEPS)[..., 0]
    width = (shut > 0.5 * shut[0].max()).sum(1)
    assert width[0] >= 12 and width[round(0.8 * CREASE)] <= 10
    assert np.abs(np.diff(shut, axis=1)).max() < 0.25  # of 1 in one column
    middle = shut[:, 28]
    assert middle[0] > 0.95 and 0.2 < middle[CREASE] < 0.7
    assert np.abs(np.diff(middle)).max() < 0.04


def test_what_was_made_is_kept():
    charts = Charts((bar(), None))
    first, second = upper_charts(charts, [3, 3])
    assert first is second is upper_charts(charts, [3, 0])[0]
    np.testing.assert_array_equal(first, unfolded(bar(), 3))
