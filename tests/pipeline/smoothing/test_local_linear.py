"""Local linear regression over similar moments."""

import numpy as np
from heads import HEAD_PX
from hypothesis import given, settings
from hypothesis import strategies as st
from makeup_video.pipeline.smoothing.face_space import LIPS_PART, PARTS, PATCH_PART, PLACE_PART
from makeup_video.pipeline.smoothing.local_linear import local_linear_taps
from noisy_heads import measure_noise


@given(
    steps=st.lists(st.floats(1e-6, 1.0), min_size=8, max_size=8),
    hidden=st.sets(st.integers(0, 8)),
    now=st.integers(0, 8),
)
@settings(deadline=None)
def test_taps_sum_to_one_and_skip_hidden_moments(steps, hidden, now):
    _, readings, level = measure_noise(HEAD_PX[60:69])
    from_now = np.concatenate([[0], np.cumsum(steps)])
    from_now -= from_now[now]
    from_now[list(hidden - {now})] = np.nan
    taps = local_linear_taps(readings.apart, from_now.tolist(), now, level.variance())
    assert np.isfinite(taps).all()
    np.testing.assert_allclose(taps.sum(1), 1, atol=1e-6)
    assert (taps[:, list(hidden - {now})] == 0).all()


def test_a_moment_alone_is_not_smoothed():
    _, readings, level = measure_noise(HEAD_PX[:3])
    from_now = np.array([np.nan, 0, np.nan])
    taps = local_linear_taps(readings.apart, from_now.tolist(), 1, level.variance())
    np.testing.assert_allclose(taps, [[0, 1, 0]] * len(PARTS))


def test_lids_have_no_steady_speed():
    """A line through both sides of a blink would only make the blink shallower."""
    seconds = np.arange(-4, 5) / 30
    apart = np.stack([np.square(seconds[:, None] - seconds)] * len(PARTS))  # of a steady motion
    taps = local_linear_taps(apart, seconds.tolist(), 4, np.full(len(PARTS), 1e-6))
    assert (taps[:, 4] > 0.99).tolist() == [False, True, True, False, False, False, False]


def test_the_patch_follows_lips_that_move():
    moment = np.arange(9)
    apart = np.zeros((len(PARTS), 9, 9))
    apart[LIPS_PART] = (moment[:, None] + moment) % 2  # lips that jump to and fro
    taps = local_linear_taps(apart, ((moment - 4) / 30).tolist(), 4, np.full(len(PARTS), 1e-6))
    assert np.abs(taps[PATCH_PART, 1::2]).max() < 1e-6 < taps[PLACE_PART, 1::2].min()
