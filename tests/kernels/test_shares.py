"""The kernel that lays coats around the eyes against its numpy twin."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from makeup import close_up_scene, device
from makeup_video.kernels.paint import LAYERS
from makeup_video.kernels.shares import CHART_HEIGHT, CHART_ROWS, KEPT, ShareKernel
from makeup_video.kernels.surface import LID_HW
from makeup_video.pipeline.render.lay_coats import lay_coats
from makeup_video.pipeline.render.surfaces.surface import Charts
from makeup_video.pipeline.render.surfaces.unfolded import STEPS

ROWS = CHART_ROWS * CHART_HEIGHT + 1
UNFOLDED = st.lists(st.sampled_from([0, 1, STEPS // 2, STEPS]), min_size=2, max_size=2)
SIDES = st.sampled_from([(True, True), (True, False), (False, True)])


def eyes(steps=None):
    """Both eyes of the sample; steps: how far the lids are unfolded, if not as in the sample."""
    surfaces = [lit.surface for lit in close_up_scene().faces[0].regions["eyes"]]
    if steps is not None:
        surfaces[0].both.steps = steps
    return surfaces


def charts_of(seed, sides, count):
    """Smooth densities, because OpenCV looks them up at steps of 1/32 of a row."""
    rng = np.random.default_rng(seed)
    y, x = np.mgrid[:ROWS, : LID_HW[1]][..., None]
    slopes, starts = rng.uniform(-0.02, 0.02, (2, 2, count)), rng.uniform(-0.2, 1.2, (2, count))
    on_sides = [
        np.clip(start + slope[0] * y + slope[1] * x, 0, 1).astype(np.float32) if is_there else None
        for slope, start, is_there in zip(slopes, starts, sides, strict=True)
    ]
    return Charts(tuple(on_sides))


@settings(max_examples=60, deadline=None)
@given(
    st.integers(0, 9999), SIDES, st.lists(st.floats(0, 1), min_size=1, max_size=LAYERS), UNFOLDED
)  # fmt: skip
def test_coats_match_their_twin(seed, sides, opacities, steps):
    charts, (surface, _) = charts_of(seed, sides, len(opacities)), eyes(steps)
    got, want = surface.lay(charts, opacities, device()), lay_coats(surface, charts, opacities)
    near = {"atol": 2e-3, "rtol": 1e-4}
    assert (got.shares is None) == (want.shares is None) == (len(opacities) == 1)
    if want.shares is None:
        np.testing.assert_allclose(got.density, want.density, **near)
        return
    np.testing.assert_allclose(got.shares, want.shares, **near)
    np.testing.assert_allclose(got.seen, want.seen, atol=1, rtol=2e-3)
    assert (got.density != want.density).mean() < 0.01  # except densities nearly too faint


@pytest.mark.parametrize("sides", [(True, True), (True, False), (False, True)], ids=str)
def test_what_was_laid_stays_when_other_coats_are_laid(sides):
    """The coats of all faces are laid, one face after another, before any face is painted."""
    surface, _ = eyes()
    first, second = charts_of(1, sides, 3), charts_of(2, (True, True), 2)
    laid = surface.lay(first, [0.3, 0.5, 0.9], device())
    before = laid.shares.copy(), laid.density.copy()
    surface.lay(second, [0.1, 0.2], device())
    np.testing.assert_array_equal(laid.shares, before[0])
    np.testing.assert_array_equal(laid.density, before[1])
    again = surface.lay(first, [0.3, 0.5, 0.9], device())
    np.testing.assert_array_equal(again.shares, before[0])


def test_a_long_blink_keeps_few_charts_and_its_colours():
    charts, opacities = charts_of(4, (True, True), 2), [0.4, 0.8]
    for first in (*range(STEPS + 1), 0):
        surface, _ = eyes([first, (first + STEPS // 2) % STEPS])
        got, want = surface.lay(charts, opacities, device()), lay_coats(surface, charts, opacities)
        np.testing.assert_allclose(got.shares, want.shares, atol=2e-3, rtol=1e-4)
        assert len(charts.unfolded) <= KEPT
        assert len(device().once(ShareKernel)._charts[charts]) <= KEPT + 1  # and one below the eye


def test_one_shut_eye_leaves_the_other_as_it_is():
    charts = charts_of(3, (True, True), 2)
    (open_eyes, *_), (wink, *_) = [
        eyes(steps)[0].lay(charts, [0.5, 0.5], device()) for steps in ([0, 0], [0, STEPS])
    ]
    np.testing.assert_array_equal(wink[:, 0], open_eyes[:, 0])
    assert np.abs(wink[:, 1] - open_eyes[:, 1]).max() > 0.05


def test_an_opaque_coat_hides_those_below():
    surface, _ = eyes()
    charts = Charts((np.ones((ROWS, LID_HW[1], 3), np.float32), None))
    shares, seen, density = surface.lay(charts, [1.0, 1.0, 0.25], device())
    np.testing.assert_array_equal(shares[0], 0)
    np.testing.assert_array_equal(shares[1:].min((1, 2, 3)), [0.75, 1])
    np.testing.assert_allclose(seen, shares.sum((2, 3)).T)
    assert density.min() == 1
