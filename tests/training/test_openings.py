"""Mouths that are opened further in training crops have an exact border, and keep their lips."""

import cv2
import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from makeup_video.training.faces.openings import LIP_LEFT_PX, Openings, widened, without_gaps

_H, _W = 80, 112


def mouth(gap_px: float) -> np.ndarray:
    """A mask as in Batch: an ellipse of lips around an opening, whose upper half is teeth.

    gap_px: half the height of the opening.
    """
    whole, opening = np.zeros((2, _H, _W), np.uint8)
    cv2.ellipse(whole, (56, 40), (34, 18), 0, 0, 360, 255, -1, cv2.LINE_AA)
    cv2.ellipse(opening, (56, 40), (24, round(gap_px)), 0, 0, 360, 255, -1, cv2.LINE_AA)
    teeth = np.where(np.arange(_H)[:, None] < 40, opening, 0).astype(np.uint8)
    return np.dstack([whole, opening, teeth, np.full((_H, _W), 255, np.uint8)])


@given(gap=st.floats(3, 12), seed=st.integers(0, 999))
@settings(max_examples=40, deadline=None)
def test_an_opening_grows_within_the_lips(gap, seed):
    mask = mouth(gap)
    wider = widened(mask[..., 0], mask[..., 1], np.random.default_rng(seed))
    assert wider.min() >= 0
    assert wider.max() <= 1
    to_skin = cv2.distanceTransform((mask[..., 0] > 127).astype(np.uint8), cv2.DIST_L2, 5)
    assert not wider[to_skin < LIP_LEFT_PX].any()


@given(gap=st.floats(4, 12), seed=st.integers(0, 999))
@settings(max_examples=40, deadline=None)
def test_pixels_change_only_where_the_mask_says(gap, seed):
    rng = np.random.default_rng(seed)
    openings = Openings(rng, chance=1.0)
    rgb8 = rng.integers(0, 256, (_H, _W, 3)).astype(np.uint8)
    mask, before = mouth(gap), mouth(gap)
    drawn = openings(rgb8, mask)
    assert (mask[..., 1] >= before[..., 1]).all()
    assert (mask[..., [0, 3]] == before[..., [0, 3]]).all()
    assert (drawn == rgb8)[mask[..., 1] == 0].all()


@given(gap=st.floats(6, 12), seed=st.integers(0, 999))
@settings(max_examples=40, deadline=None)
def test_a_wider_opening_has_the_teeth_of_what_fills_it(gap, seed):
    openings = Openings(np.random.default_rng(seed), chance=1.0)
    mask = mouth(gap)
    rgb8 = np.where(mask[..., 2:3] > 127, 240, 20).astype(np.uint8).repeat(3, axis=2)
    drawn = openings(rgb8, mask).astype(float).mean(-1)
    inside, teeth = mask[..., 1] > 250, mask[..., 2]
    shown = drawn[inside & (teeth > 230)], drawn[inside & (teeth < 25)]
    assert min(map(len, shown)) > 30
    # What fills the opening is darker in the shade of the lips, tongue as well as teeth.
    assert np.median(shown[0]) > 2 * np.median(shown[1])


def test_an_opening_without_a_mouth_stays_as_it_is():
    openings, mask = Openings(np.random.default_rng(0), chance=1.0), mouth(9)
    rgb8 = np.full((_H, _W, 3), 90, np.uint8)
    openings(rgb8, mouth(9))  # a texture to fill with
    mask[..., 0] = 0
    before = mask.copy()
    assert (openings(rgb8, mask) == rgb8).all() and (mask == before).all()


def test_a_shut_mouth_stays_as_it_is():
    openings = Openings(np.random.default_rng(0), chance=1.0)
    rgb8 = np.full((_H, _W, 3), 90, np.uint8)
    mask = mouth(5)
    mask[..., 1] = 0
    assert openings(rgb8, mask) is rgb8
    assert not mask[..., 1].any()


def test_gaps_take_the_nearest_known_pixel():
    rgb8 = np.zeros((5, 9, 3), np.uint8)
    rgb8[:, 0], rgb8[:, 8] = 10, 200
    known = np.zeros((5, 9), bool)
    known[:, [0, 8]] = True
    filled = without_gaps(rgb8, known)
    assert (filled[:, :4] == 10).all()
    assert (filled[:, 5:] == 200).all()
