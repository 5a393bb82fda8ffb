"""The film model: the product that it asks for shows as wanted, and bounds hold."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from makeup_video.pipeline.reference.product_film import ProductFilm, bounded

ROOTS = st.lists(st.floats(0.05, 1.5), min_size=3, max_size=3).map(np.array)
SHARE = st.floats(0.1, 1)


@given(ROOTS, ROOTS, SHARE, SHARE, SHARE)
def test_the_product_shows_as_what_was_seen(bare, seen, cover, response, opacity):
    film = ProductFilm(bare, np.array(cover), np.array(response))
    roots = film.product_for(seen, opacity)
    shown = (1 - opacity * cover) * bare + opacity * response * roots
    np.testing.assert_allclose(shown, seen, atol=1e-9)


@given(st.integers(0, 10**6), st.integers(1, 4))
def test_least_squares_within_bounds_cannot_be_bettered(seed, count):
    rng = np.random.default_rng(seed)
    parts = rng.random((40, count)) + 0.1 * np.eye(40, count)
    wanted, most = rng.normal(0.5, 1, (40, 3)), np.array([0.8, 1.0, 1.5])
    normal, right = parts.T @ parts, parts.T @ wanted
    found = bounded(normal, right, most)
    assert (found >= 0).all() and (found <= most).all()

    def error(x):
        return ((parts @ x - wanted) ** 2).sum()

    for _ in range(20):
        other = np.clip(found + rng.normal(0, 0.2, found.shape), 0, most)
        assert error(found) < error(other) * 1.02
