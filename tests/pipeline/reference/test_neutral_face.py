"""Tests of pipeline/reference/neutral_face.py: the plain skin that colours are compared with."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from makeup_video.pipeline.reference.neutral_face import PLAIN_SKIN, filled, neutral_face
from makeup_video.pipeline.reference.photo_light import photo_light
from people import portrait
from reference_photos import face

CODE = st.integers(0, 60)


def skin_of(rgb8):
    return neutral_face(rgb8, face(), photo_light(portrait(), face())).skin


def covered(place, rgb):
    rgb8 = portrait().copy()
    rgb8[filled(face(), [place], rgb8.shape, mirrored=True)] = rgb
    return rgb8


@settings(max_examples=8, deadline=None)
@given(st.sampled_from([PLAIN_SKIN[0], PLAIN_SKIN[2]]), st.tuples(CODE, CODE, CODE))
def test_hair_or_a_beard_over_skin_is_no_skin(place, rgb):
    hidden = skin_of(covered(place, rgb))
    assert (hidden > 0.9 * skin_of(portrait())).all()
    np.testing.assert_allclose(hidden, skin_of(covered(place, (0, 0, 0))), rtol=0.01)


@pytest.mark.parametrize(("place", "share"), [*zip(PLAIN_SKIN, (0.9, 0.78, 0.78), strict=True)])
def test_skin_in_less_light_is_skin(place, share):
    """0.9 of the code is about 0.8 of the light, 0.78 half of it. Skin is a median, which need not
    move in every colour."""
    rgb8 = portrait()
    there = filled(face(), [place], rgb8.shape, mirrored=True)
    dim = np.where(there[..., None], (rgb8 * share).astype(np.uint8), rgb8)
    darker, skin = skin_of(dim), skin_of(rgb8)
    assert (darker <= skin).all() and darker.sum() < skin.sum()


def test_light_hair_over_the_forehead_is_no_skin():
    rgb8 = portrait()
    beside = np.median(rgb8[filled(face(), PLAIN_SKIN[2:], rgb8.shape, mirrored=True)], axis=0)
    hair = 0.72 * beside  # hardly half of the light
    assert (skin_of(covered(PLAIN_SKIN[0], hair)) > 0.9 * skin_of(rgb8)).all()
