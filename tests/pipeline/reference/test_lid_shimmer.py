"""Shimmer on lids that are laid flat: bright specks count, even light and dark lashes do not."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from makeup_video.pipeline.reference.flat_lids import (
    FLAT_WH,
    flat_heights,
    flat_places_across,
)
from makeup_video.pipeline.reference.lid_shimmer import fine_highlights, lid_shimmer

WIDE, HIGH = FLAT_WH
COLOURS = st.tuples(*[st.integers(40, 200)] * 3)


def even(rgb):
    return np.broadcast_to(np.uint8(rgb), (HIGH, WIDE, 3)).copy()


def with_specks(lids, rgb, share, seed=0):
    """Specks of two pixels on this share of the lids."""
    there = np.random.default_rng(seed).random((HIGH, WIDE)) < share / 2
    lids[there | np.roll(there, 1, 1)] = rgb
    return lids


@given(COLOURS)
def test_even_lids_are_matte(rgb):
    assert lid_shimmer(even(rgb)) == 0


@given(COLOURS, st.integers(0, 255))
def test_soft_light_is_no_shimmer(rgb, more):
    """As on a lid that is a ball: brightest in its middle."""
    across = np.exp(-np.square(flat_places_across() / 0.3))
    down = np.exp(-np.square((flat_heights() - 0.6) / 0.5))
    lit = even(rgb) + more * (down[:, None] * across)[..., None]
    assert lid_shimmer(np.uint8(np.minimum(lit, 255))) == 0


@given(COLOURS, st.floats(0, 0.4))
def test_dark_lashes_are_no_shimmer(rgb, share):
    lashes = np.random.default_rng(0).random(WIDE) < share
    lids = even(rgb)
    lids[:, lashes] = np.uint8(rgb) // 4
    assert lid_shimmer(lids) == 0


@pytest.mark.parametrize("rgb", [(60, 40, 60), (150, 100, 80), (60, 110, 160)])
def test_the_brighter_specks_are_the_more_a_lid_shimmers(rgb):
    brighter = [np.minimum(np.array(rgb) + more, 255) for more in (0, 25, 50, 80)]
    found = [fine_highlights(with_specks(even(rgb), one, 0.2)) for one in brighter]
    assert found == sorted(found) and found[-1] > found[0] + 0.15
    assert lid_shimmer(with_specks(even(rgb), brighter[-1], 0.2)) > 0.5


def test_specks_beside_the_lids_do_not_count():
    lids, specks = even((120, 90, 80)), with_specks(even((120, 90, 80)), (255, 255, 255), 0.3)
    beside = np.abs(flat_places_across()) > 0.55
    lids[:, beside] = specks[:, beside]
    off = (flat_heights() < -0.1) | (flat_heights() > 2.1)
    lids[off] = specks[off]
    assert lid_shimmer(lids) == 0


@given(st.integers(0, 2**32 - 1))
def test_any_picture_has_a_shimmer_in_range(seed):
    lids = np.random.default_rng(seed).integers(0, 256, (HIGH, WIDE, 3), np.uint8)
    assert 0 <= lid_shimmer(lids) <= 1
    assert lid_shimmer(lids[:, ::-1]) == pytest.approx(lid_shimmer(lids), abs=0.05)


def test_rows_and_columns_are_those_of_flat_lids():
    heights, across = flat_heights(), flat_places_across()
    assert heights.shape == (HIGH,) and (np.diff(heights) < 0).all() and 0 in heights
    assert across.shape == (WIDE,) and (across == across[::-1]).all()
    assert across[0] == pytest.approx(0.92) and across[WIDE // 2] == pytest.approx(-0.72)
