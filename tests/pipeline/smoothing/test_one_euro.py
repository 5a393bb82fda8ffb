import numpy as np
import pytest
from makeup_video.pipeline.smoothing.one_euro import OneEuro

STARTS, COUNTS = np.array([0, 3]), np.array([3.0, 2.0])
NOISE = np.array([1e-4, 1e-4])


def new_filter():
    return OneEuro(STARTS, COUNTS)


def test_the_first_value_passes_unchanged():
    assert (new_filter()(np.ones(5, np.float32), 0.033, NOISE) == 1).all()


def test_at_rest_the_filter_is_a_low_pass_of_minimum_cutoff():
    smooth = new_filter()
    for _ in range(5):
        shares = smooth(np.ones(5, np.float32), 1 / 30, NOISE)
    turn = 2 * np.pi * 1.0 / 30
    np.testing.assert_allclose(shares, turn / (1 + turn))


def test_only_the_part_that_moves_follows_at_once():
    smooth = new_filter()
    still, jump = np.zeros(5, np.float32), np.array([0, 0, 0, 1, 1], np.float32)
    smooth(still, 1 / 30, NOISE)
    shares = smooth(jump, 1 / 30, NOISE)
    assert shares[0] < 0.2 and shares[1] > 0.9


def test_less_noise_lets_the_same_motion_through_sooner():
    jump = np.full(5, 0.04, np.float32)
    shares = []
    for noise in (NOISE, NOISE / 100):
        smooth = new_filter()
        smooth(np.zeros(5, np.float32), 1 / 30, noise)
        shares.append(smooth(jump, 1 / 30, noise))
    assert (shares[1] > shares[0] + 0.1).all()


def test_noise_alone_hardly_lifts_the_cutoff():
    rng = np.random.default_rng(0)
    smooth, shares = new_filter(), []
    for _ in range(300):
        shares.append(smooth(rng.normal(0, 0.01, 5).astype(np.float32), 1 / 30, NOISE))
    rest = 2 * np.pi / 30 / (1 + 2 * np.pi / 30)
    assert np.median(shares) == pytest.approx(rest) and np.mean(shares) < 1.8 * rest


def test_the_values_given_are_not_changed():
    smooth, x = new_filter(), np.arange(5, dtype=np.float32)
    smooth(x, 1 / 30, NOISE)
    smooth(x + 1, 1 / 30, NOISE)
    assert (x == np.arange(5)).all()
