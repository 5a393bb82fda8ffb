"""Shimmer on lids that are laid flat: bright specks count, even light and dark lashes do not."""

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from makeup_video.pipeline.faces.face import moved, resized
from makeup_video.pipeline.reference.flat_lids import (
    FLAT_WH,
    flat_places_across,
    flat_rings,
)
from makeup_video.pipeline.reference.lid_shimmer import fine_highlights, lid_shimmer, lids_of
from makeup_video.pipeline.reference.photo_light import photo_light
from people import portrait
from reference_photos import face

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
    """Such light is brightest in the middle of the lid, as on a ball."""
    across = np.exp(-np.square(flat_places_across() / 0.3))
    down = np.exp(-np.square((flat_rings() - 0.6) / 0.5))
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
    off = (flat_rings() < -0.1) | (flat_rings() > 2.1)
    lids[off] = specks[off]
    assert lid_shimmer(lids) == 0


@given(COLOURS, st.integers(0, 2**32 - 1), st.floats(0, 0.3))
def test_a_mirrored_photo_shimmers_as_much(rgb, seed, share):
    lids = with_specks(even(rgb), (235, 230, 225), share, seed)
    assert fine_highlights(lids[:, ::-1]) == pytest.approx(fine_highlights(lids), abs=1e-5)


@settings(max_examples=10, deadline=None)
@given(st.floats(0.7, 2.5))
def test_a_larger_photo_shimmers_as_much(scale):
    rgb8 = portrait().copy()
    rgb8[np.random.default_rng(0).random(rgb8.shape[:2]) < 0.05] = 255
    large, found = (enlarged(rgb8, face(), 2 * more) for more in (1, scale))
    light = photo_light(*large)
    one, other = (fine_highlights(lids_of(*each, light)) for each in (large, found))
    assert one > 0.05 and other == pytest.approx(one, rel=0.1)


def enlarged(rgb8, seen, scale):
    larger = cv2.resize(rgb8, None, fx=scale, fy=scale, interpolation=cv2.INTER_LINEAR)
    return larger, resized(seen, scale, scale)


def test_lids_beyond_the_border_are_not_read():
    light = photo_light(portrait(), face())
    assert lids_of(portrait(), face(), light).shape == (HIGH, WIDE, 3)
    for shift in (3000.0, -3000.0):
        beyond = moved(face(), np.array([[1, 0, shift], [0, 1, 0]]))
        assert lids_of(portrait(), beyond, light) is None


def test_rows_and_columns_are_those_of_flat_lids():
    rings, across = flat_rings(), flat_places_across()
    assert rings.shape == (HIGH,) and (np.diff(rings) < 0).all() and 0 in rings
    assert across.shape == (WIDE,) and (across == across[::-1]).all()
    assert across[0] == pytest.approx(0.92) and across[WIDE // 2] == pytest.approx(-0.72)
