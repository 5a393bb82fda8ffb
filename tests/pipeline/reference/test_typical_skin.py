"""Colours beside the skin of a photo, and beside typical skin."""

from dataclasses import replace

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from makeup_video.kernels.colour import SRGB, to_encoded
from makeup_video.pipeline.look.ciede2000 import lab_of_linear, linear_of_lab
from makeup_video.pipeline.reference.neutral_face import LUMINANCE, neutral_face
from makeup_video.pipeline.reference.photo_light import photo_light
from makeup_video.pipeline.reference.typical_skin import TypicalSkin
from makeup_video.pipeline.render.skin_light import TYPICAL_SKIN
from people import portrait
from reference_photos import face

LIGHT = st.tuples(*[st.floats(0.02, 1)] * 3).map(np.array)


def skin_of(linear):
    neutral = neutral_face(portrait(), face(), photo_light(portrait(), face()))
    return TypicalSkin.of(replace(neutral, skin=np.asarray(linear)), 0.4)


@given(LIGHT)
def test_skin_stays_skin(seen):
    np.testing.assert_allclose(skin_of(seen).roots(np.ones(3)), 1, atol=1e-6)


@given(LIGHT)
def test_typical_skin_leaves_colours_as_they_are(roots):
    np.testing.assert_allclose(skin_of(TYPICAL_SKIN).roots(roots), roots, atol=0.01)


@given(LIGHT, LIGHT)
def test_a_colour_in_cielab_goes_back_to_its_roots(seen, roots):
    skin = skin_of(seen)
    np.testing.assert_allclose(skin.roots_of(skin.lab(roots)), roots, atol=1e-4)


@given(LIGHT)
def test_skin_is_taken_nearer_to_typical_skin(seen):
    here, typical = lab_of_linear(skin_of(seen).linear), lab_of_linear(np.array(TYPICAL_SKIN))
    before = np.abs(lab_of_linear(seen) - typical)
    assert (np.abs(here - typical) <= before + 1e-6).all()


@given(LIGHT, st.floats(0, 1))
def test_so_much_of_the_hue_of_skin_is_kept(seen, own):
    neutral = neutral_face(portrait(), face(), photo_light(portrait(), face()))
    neutral = replace(neutral, skin=np.asarray(seen))
    typical = lab_of_linear(np.array(TYPICAL_SKIN))
    skin = TypicalSkin.of(neutral, own)
    kept = lab_of_linear(skin.linear) - typical
    hue = own * (lab_of_linear(np.asarray(seen)) - typical)[1:]
    in_gamut = (skin.linear > 1e-3).all()
    assert not in_gamut or np.allclose(kept[1:], hue, atol=1e-3)


@given(st.floats(1, 60), st.floats(1, 10))
def test_darker_skin_keeps_as_much_of_its_darkness_or_more(darker, by):
    typical = lab_of_linear(np.array(TYPICAL_SKIN))
    kept = [
        (typical[0] - lab_of_linear(skin_of(linear_of_lab(typical - [off, 0, 0])).linear)[0]) / off
        for off in (darker, darker + by)
    ]
    assert kept[1] >= kept[0] - 1e-3 and kept[1] <= 1


@given(LIGHT, LIGHT)
def test_what_is_darker_than_skin_stays_darker(seen, share):
    skin = skin_of(seen)
    lightness = lab_of_linear(skin.roots(np.sqrt(share)) ** 2 * skin.linear)[0]
    assert lightness <= lab_of_linear(skin.linear)[0] + 1e-6


@given(st.floats(0.6, 1), st.floats(0.05, 1))
def test_grey_beside_too_light_skin_loses_as_much_light(light, share):
    skin = skin_of(np.full(3, light))
    grey = skin.roots(np.full(3, np.sqrt(share))) ** 2 * skin.linear @ LUMINANCE
    lost = float(skin.linear @ LUMINANCE) / light
    assert lost >= 1 or abs(float(grey) - lost * light * share) < 0.01


@given(LIGHT)
def test_codes_are_the_inverse_of_roots(linear):
    skin = skin_of((0.5, 0.3, 0.2))
    codes = skin.codes(np.sqrt(linear / skin.linear))
    np.testing.assert_allclose(codes, 255 * to_encoded(linear, SRGB), atol=2e-3)


@given(LIGHT)
def test_lab_returns_to_linear_light(linear):
    np.testing.assert_allclose(linear_of_lab(lab_of_linear(linear)), linear, atol=1e-9)
