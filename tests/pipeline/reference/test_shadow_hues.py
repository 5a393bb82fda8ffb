"""Hues of eyeshadow that are light or skin rather than makeup: rims of black, blue, red lids."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from makeup_video.kernels.colour import SRGB, to_linear
from makeup_video.pipeline.reference import fit_shadows as shadows
from makeup_video.pipeline.reference.neutral_face import neutral_face
from makeup_video.pipeline.reference.photo_light import photo_light
from makeup_video.pipeline.reference.spread_shadows import Spread
from makeup_video.pipeline.reference.typical_skin import TypicalSkin
from people import portrait
from reference_photos import face


def typical():
    return TypicalSkin.of(neutral_face(portrait(), face(), photo_light(portrait(), face())), 1.0)


def beside_black(rgb, share):
    """CIELAB of typical skin, of an eyeshadow on it, and of what it becomes beside black."""
    skin = typical()
    roots = np.sqrt(to_linear(np.array([rgb, (28, 28, 28)]) / 255, SRGB) / skin.linear)
    densities = np.stack([np.full((27, 24), 0.5), np.full((27, 24), 0.5 * share)])
    calmed = shadows._calm_beside_black(Spread(roots, densities, np.ones(2)), skin)
    np.testing.assert_array_equal(calmed[1], roots[1])
    return skin.lab(np.ones(3)), skin.lab(roots[0]), skin.lab(calmed[0])


@settings(max_examples=30, deadline=None)
@given(st.integers(200, 240), st.integers(100, 130), st.integers(90, 120), st.floats(0.6, 2))
def test_soft_reds_beside_much_black_are_less_vivid(red, green, blue, share):
    plain, lab, calm = beside_black((red, green, blue), share)
    assert calm[0] == pytest.approx(lab[0], abs=1e-3)
    np.testing.assert_allclose(calm[1:] - plain[1:], 0.6 * (lab - plain)[1:], atol=1e-3)


@pytest.mark.parametrize("rgb", [(200, 20, 30), (60, 110, 200), (90, 160, 110), (60, 30, 25)])
def test_vivid_cold_and_dark_colours_beside_black_stay(rgb):
    _, lab, calm = beside_black(rgb, 2.0)
    np.testing.assert_allclose(calm, lab, atol=1e-3)


def test_reds_beside_little_black_stay():
    _, lab, calm = beside_black((210, 110, 100), 0.2)
    np.testing.assert_allclose(calm, lab, atol=1e-3)


@given(st.floats(20, 80), st.floats(-60, 20), st.floats(-60, 20))
def test_no_product_is_much_bluer_than_it_looks(lightness, looks_blue, green):
    skin = typical()
    looks = np.broadcast_to([lightness, 0.0, looks_blue], (27, 24, 3))
    found = Spread(skin.roots_of(np.array([[50.0, green, -30]])), np.ones((1, 27, 24)), np.ones(1))
    before, after = skin.lab(found.roots)[0], skin.lab(shadows._no_bluer(found, looks, skin))[0]
    bluest = 2.5 * min(looks_blue, 0) - 8
    wanted = before.copy()
    if bluest > before[2]:
        wanted[2] = bluest
        if before[2] < before[1] < 0:  # teal stays teal
            wanted[1] *= bluest / before[2]
    wanted = skin.lab(skin.roots_of(wanted))  # the nearest colour inside sRGB
    np.testing.assert_allclose(after, wanted, atol=0.1)


def kept_below(redder, lid=(0.0, 12.0, 3.0), shade=1.0):
    """What is kept below the eye where skin is redder by this much; the first row is shaded."""
    skin = typical()
    labs = np.tile(skin.lab(np.ones(3)), (27, 24, 1))
    plain = labs[0, 0].copy()
    labs[:18] += lid
    labs[18:, :, 1] += redder
    labs[18:, :, 1] += lid[1]
    roots = skin.roots_of(labs)
    roots[18] *= np.sqrt(shade)
    shown = shadows._no_redder_below(roots, skin)
    np.testing.assert_allclose(shown[:18], roots[:18], atol=1e-3)
    return skin.lab(shown)[19:, 8, 1] - plain[1] - max(lid[1], 0)


@settings(max_examples=30, deadline=None)
@given(st.floats(0, 30))
def test_only_clear_red_below_the_eye_is_makeup(redder):
    kept = kept_below(redder)
    assert (kept >= -1e-3).all() and (kept <= redder + 1e-3).all()
    if redder <= 6:
        np.testing.assert_allclose(kept, 0, atol=1e-3)
    if redder >= 13:
        np.testing.assert_allclose(kept, redder, atol=1e-3)


@given(st.floats(0, 5), st.floats(0.02, 0.2))
def test_kohl_and_shade_make_no_red_lower_lid_makeup(redder, shade):
    np.testing.assert_allclose(kept_below(redder, shade=shade), 0, atol=1e-3)


@given(st.floats(14, 30), st.floats(4, 30))
def test_red_below_a_blue_or_bare_lid_is_skin(redder, bluer):
    for lid in ((0, 12, -bluer), (0, 0, 0)):
        np.testing.assert_allclose(kept_below(redder, lid=lid), 0, atol=1e-3)
