"""Tests of pipeline/reference/spread_shadows.py: colours of eyeshadow lie where they are seen."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from makeup_video.pipeline.look.kinds.density_map import HW, heights, places_across
from makeup_video.pipeline.reference.first_shadows import first_shadows
from makeup_video.pipeline.reference.shadow_cells import shadow_cells
from makeup_video.pipeline.reference.spread_shadows import MOST, spread

WHITE = np.full(3, 1.2)
across, height = np.meshgrid(places_across(), np.concatenate([heights(True), heights(False)]))


def seen_with(*shares_and_roots):
    """Bare eyes with colours on them: pairs of a share (27, 24) and a root of light."""
    film = shadow_cells().film
    seen = film.bare.astype(np.float64)
    for share, root in shares_and_roots:
        change = film.response[..., None] * np.array(root) - film.cover[..., None] * film.bare
        seen = seen + share[..., None] * change
    return np.maximum(seen, 0)


def found_in(seen):
    cells = shadow_cells()
    return spread(seen, cells, *first_shadows(seen, cells, WHITE), WHITE)


def shown(found):
    """What bare eyes look like with the layers that were found."""
    film = shadow_cells().film
    seen = film.bare.astype(np.float64)
    for root, density, opacity in zip(found.roots, found.densities, found.opacities, strict=True):
        lies = (opacity * density)[..., None]
        own = film.response[..., None] * root
        seen = seen * (1 - lies * film.cover[..., None]) + lies * own
    return seen


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 10**6), st.floats(0, 1.2))
def test_whatever_is_seen_gives_a_few_layers_that_can_be_worn(seed, most):
    found = found_in(np.random.default_rng(seed).uniform(0, most, (*HW, 3)))
    assert len(found.roots) == len(found.densities) == len(found.opacities) <= MOST
    for values, high in ((found.roots, 1.2), (found.densities, 1), (found.opacities, 1)):
        assert np.isfinite(values).all()
        assert values.min(initial=0) >= 0 and values.max(initial=0) <= high + 1e-5


def test_bare_eyes_wear_hardly_anything():
    found = found_in(seen_with())
    assert np.abs(shown(found) - shadow_cells().film.bare).max() < 0.03


COLOURS = st.tuples(*3 * [st.floats(0.05, 0.6)])  # darker than skin: a pale one may be light


@settings(max_examples=20, deadline=None)
@given(COLOURS, COLOURS, st.floats(0.3, 0.7))
def test_two_colours_side_by_side_are_both_found(inner, outer, border):
    on_lid = (height > 0) & (height < 1.1) & (across > 0.1) & (across < 0.95)
    seen = seen_with((on_lid & (across < border), inner), (on_lid & (across >= border), outer))
    off, was = shown(found_in(seen)) - seen, seen - shadow_cells().film.bare
    weights = shadow_cells().weights[on_lid, None]
    left, before = ((weights * one[on_lid] ** 2).sum() for one in (off, was))
    assert left < 0.35 * before


@settings(max_examples=20, deadline=None)
@given(st.floats(1.3, 1.9), st.floats(0.05, 0.3))
def test_what_is_dark_below_the_brow_alone_is_its_hair(low, root):
    seen = seen_with((0.8 * (height > low), (root, root, root)))
    found = found_in(seen)
    crease = (height > 0) & (height < 1.2)
    lies = (found.opacities[:, None, None] * found.densities).sum(0)
    assert lies[height > low].max() < lies[crease].max() + 0.15


@pytest.mark.parametrize("place", [across > 1.2, height < -0.8])
def test_hair_and_shade_away_from_the_eye_are_left_out(place):
    found = found_in(seen_with((0.8 * place, (0.1, 0.1, 0.1))))
    assert (found.opacities[:, None, None] * found.densities).sum(0)[place].max() < 0.25


@settings(max_examples=10, deadline=None)
@given(st.floats(0.2, 0.5), COLOURS)
def test_without_a_liner_lashes_are_no_shadow(reach, lid):
    on_lid = ((height > 0) & (height < 1.2) | (height < 0) & (height > -0.6)) & (across > 0)
    lashes = (np.abs(height) < reach) & (across > 0) & (across < 1)
    seen = seen_with((0.5 * (on_lid & ~lashes), lid), (1.0 * lashes, (0.0, 0.0, 0.0)))
    cells = shadow_cells()
    first = first_shadows(seen, cells, WHITE)
    lit = [
        shown(spread(seen, cells, *first, WHITE, lined))[lashes].mean() for lined in (True, False)
    ]
    assert lit[1] >= lit[0] - 0.01
    if min(lid) > 0.4:
        assert lit[1] > lit[0] + 0.02


@settings(max_examples=10, deadline=None)
@given(COLOURS)
def test_what_is_dark_beside_a_sure_wing_is_the_wing(lid):
    everywhere = 0.5 * ((np.abs(height) < 1.2) & (across > 0.1) & (across < 1.5))
    dark = 0.9 * ((np.abs(height) < 0.6) & (across > 0.5) & (across < 1.5))
    seen = seen_with((everywhere, lid), (dark, (0.0, 0.0, 0.0)))
    cells = shadow_cells()
    first = first_shadows(seen, cells, WHITE)
    without, beside = (spread(seen, cells, *first, WHITE, True, winged) for winged in (False, True))
    is_dark = without.roots.max(1) < 0.1
    np.testing.assert_array_equal(beside.roots, without.roots)
    beyond = np.broadcast_to(across > 1.35, height.shape)
    inside = np.broadcast_to(across < 0.9, height.shape)
    assert beside.densities[is_dark][:, beyond].max(initial=0) < 0.02
    if is_dark.any():
        assert without.densities[is_dark][:, beyond & (dark > 0)].max() > 0.02
    np.testing.assert_allclose(
        beside.densities[is_dark][:, inside], without.densities[is_dark][:, inside], atol=0.15
    )
