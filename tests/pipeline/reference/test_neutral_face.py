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


@pytest.mark.parametrize("place", PLAIN_SKIN)
def test_skin_in_half_the_light_is_skin(place):
    rgb8 = portrait()
    there = filled(face(), [place], rgb8.shape, mirrored=True)
    # 0.78 of the code is about half of the light
    dim = np.where(there[..., None], (rgb8 * 0.78).astype(np.uint8), rgb8)
    assert (skin_of(dim) < skin_of(rgb8)).all()
