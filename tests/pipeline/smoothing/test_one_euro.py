import numpy as np
import pytest
from makeup_video.pipeline.smoothing.one_euro import OneEuro

STARTS, COUNTS = np.array([0, 3]), np.array([3.0, 2.0])
NOISE = np.array([1e-4, 1e-4])


def new(**options):
    given = {"min_cutoff_hz": 1.0, "rise_hz": 15.0, "speed_cutoff_hz": 15.0} | options
    return OneEuro(STARTS, COUNTS, **given)


def test_the_first_value_passes_unchanged():
    assert (new()(np.ones(5, np.float32), 0.033, NOISE) == 1).all()


def test_at_rest_the_filter_is_a_low_pass_of_minimum_cutoff():
    one = new()
    for _ in range(5):
        shares = one(np.ones(5, np.float32), 1 / 30, NOISE)
    turn = 2 * np.pi * 1.0 / 30
    np.testing.assert_allclose(shares, turn / (1 + turn))


def test_only_the_region_that_moves_follows_at_once():
    one = new()
    still, jump = np.zeros(5, np.float32), np.array([0, 0, 0, 1, 1], np.float32)
    one(still, 1 / 30, NOISE)
    shares = one(jump, 1 / 30, NOISE)
    assert shares[0] < 0.2 and shares[1] > 0.9


def test_less_noise_lets_the_same_motion_through_sooner():
    jump = np.full(5, 0.05, np.float32)
    shares = []
    for noise in (NOISE, NOISE / 100):
        one = new()
        one(np.zeros(5, np.float32), 1 / 30, noise)
        shares.append(one(jump, 1 / 30, noise))
    assert (shares[1] > shares[0] + 0.1).all()


def test_noise_alone_hardly_lifts_the_cutoff():
    rng = np.random.default_rng(0)
    one, seen = new(), []
    for _ in range(300):
        seen.append(one(rng.normal(0, 0.01, 5).astype(np.float32), 1 / 30, NOISE))
    rest = 2 * np.pi / 30 / (1 + 2 * np.pi / 30)
    assert np.median(seen) == pytest.approx(rest) and np.mean(seen) < 1.8 * rest


def test_the_values_given_are_not_changed():
    one, x = new(), np.arange(5, dtype=np.float32)
    one(x, 1 / 30, NOISE)
    one(x + 1, 1 / 30, NOISE)
    assert (x == np.arange(5)).all()
