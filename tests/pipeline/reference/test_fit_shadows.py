"""Layers fitted to the colours around the eyes: hair is no makeup, soft browns are no orange."""

from dataclasses import replace
from functools import cache
from unittest.mock import patch

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from makeup_video.kernels.colour import SRGB, to_linear
from makeup_video.pipeline import Look, apply_look, product
from makeup_video.pipeline.faces.net import read_array
from makeup_video.pipeline.look.ciede2000 import lab_of, linear_of_lab
from makeup_video.pipeline.look.finishes import in_words
from makeup_video.pipeline.look.look import Layer
from makeup_video.pipeline.look.params import rgb_of_hex
from makeup_video.pipeline.reference import fit_shadows as shadows
from makeup_video.pipeline.reference.fit_shadows import fit_shadows, shimmering
from makeup_video.pipeline.reference.flat_eyes import density, flat_places
from makeup_video.pipeline.reference.neutral_face import LUMINANCE, neutral_face
from makeup_video.pipeline.reference.photo_light import photo_light
from makeup_video.pipeline.reference.spread_shadows import Spread
from makeup_video.pipeline.reference.typical_skin import TypicalSkin
from people import portrait
from reference_photos import face, flat_eyes

LID = product((90, 58, 46), "matte", "eyes")
FULL = {"slot": "full"}
GREY = np.broadcast_to([50.0, 0.0, 0.0], (27, 24, 3))


def neutral_of(rgb8):
    return neutral_face(rgb8, face(), photo_light(rgb8, face()))


@cache
def bare():
    return neutral_of(portrait())


def opacity_read(rgb, above):
    """The opacity read above a height where one colour is painted from the lashes to the brow."""
    worn = replace(product(rgb, "matte", "eyes"), opacity=0.9)
    neutral = neutral_of(apply_look(portrait(), Look([Layer("eyeshadow", worn, FULL)]), [face()]))
    across, height = flat_places()
    there = np.ix_(height > above, (across > 0.2) & (across < 0.9))
    layers = fit_shadows(neutral, flat_eyes(neutral))
    return max((one.product.opacity * density(one)[there].max() for one in layers), default=0.0)


@pytest.mark.parametrize("hair", [(12, 10, 10), (40, 28, 22)])
def test_what_may_be_brow_hair_is_not_painted_below_the_brow(hair):
    assert opacity_read(hair, 1.5) < 0.15 < opacity_read(hair, 0.2)


def test_eyes_in_glaring_light_have_no_shadow():
    """All of their products would have to be white."""
    glare = np.full_like(flat_eyes(bare()), 4)
    assert fit_shadows(bare(), glare) == []


@pytest.mark.parametrize("shadow", [(20, 40, 150), (0, 110, 40), (110, 20, 160)])
def test_colours_that_no_hair_has_go_up_to_the_brow(shadow):
    assert opacity_read(shadow, 1.5) > 0.3


@settings(max_examples=10, deadline=None)
@given(st.floats(2, 8), st.floats(8, 16))
def test_soft_browns_are_less_yellow_than_they_are_seen(red, yellow):
    dense = density(Layer("eyeshadow", LID, FULL))[..., None]
    eyes = read_array("bare_eyes.npy").astype(np.float32)[..., :3]
    plain = np.array([72.0, 12.0, 14.0])
    skin = linear_of_lab(plain)

    def yellowness(more):
        brown = np.sqrt(linear_of_lab(plain + np.array([-14, red, more])) / skin)
        seen = (eyes * ((1 - dense) + dense * brown)).astype(np.float32)
        layers = fit_shadows(replace(bare(), skin=skin), seen)
        labs = lab_of(np.array([rgb_of_hex(one.product.hex) for one in layers]))
        amounts = np.array([one.product.opacity * density(one).mean() for one in layers])
        return float(amounts @ (labs[:, 2] - 14))

    less = yellowness(yellow)
    with patch.object(shadows, "_LESS_YELLOW", 0.0):
        as_seen = yellowness(yellow)
    assert yellowness(0) < less < as_seen  # still yellower than a brown without yellow


@pytest.mark.parametrize("black", [(0, 0, 0), (12, 10, 10), (0, 20, 8)])
def test_no_shadow_is_read_as_blacker_than_powder(black):
    worn = replace(product(black, "matte", "eyes"), opacity=1.0)
    neutral = neutral_of(apply_look(portrait(), Look([Layer("eyeshadow", worn, FULL)]), [face()]))
    read = [one.product for one in fit_shadows(neutral, flat_eyes(neutral))]
    lightness = [lab_of(np.array(rgb_of_hex(one.hex)))[0] for one in read if one.opacity > 0.5]
    assert lightness and 9 < min(lightness) < 16


@given(st.floats(0, 0.12), st.floats(0, 0.12), st.floats(0, 0.12), st.floats(0.05, 0.85))
def test_sheer_black_darkens_skin_as_much_as_before(red, green, blue, opacity):
    skin = TypicalSkin.of(bare(), 1.0)
    root = np.array([red, green, blue])
    lighter, denser = shadows._no_blacker(root, opacity, skin)
    assert denser >= opacity and (lighter >= root).all()
    before, after = (
        part * (1 - np.sqrt(one**2 @ LUMINANCE))
        for part, one in ((opacity, root), (denser, lighter))
    )
    assert after == pytest.approx(before) or denser == 1.0


@given(st.floats(0.02, 0.98), st.floats(-20, -5), st.floats(1.15, 1.6))
def test_few_cold_cells_make_no_product_cold_if_light_is_warm(share, b, red):
    """The whites of the eyes, beside a brown lid, are as cold in warm light as blue shadow is."""
    skin = TypicalSkin.of(bare(), 1.0)
    plain, dense = skin.lab(np.ones(3)), np.ones((1, 27, 24))
    labs = np.tile(plain, (27 * 24, 1))
    cold = labs[: round(share * len(labs))]
    cold[:, 2] = b
    seen = skin.roots_of(labs).reshape(27, 24, 3)
    blue = skin.roots_of(np.array([[50.0, 0.0, -60.0]]))
    found = Spread(blue, dense, np.ones(1))
    light = np.array([red, 1.0, 1.0])
    least = skin.lab(shadows._no_colder(found, seen, GREY, skin, light))[0, 2]
    assert least >= 4 * b - 0.1
    if share < 0.04:  # less than a twentieth
        assert least == pytest.approx(plain[2], abs=0.1)
    elif share < 0.24:  # less than a quarter
        assert least >= b - 0.1
    elif share > 0.26:
        assert least == pytest.approx(max(4 * b, skin.lab(blue)[0, 2]), abs=0.1)


@example(20.0, 4.0, 29.0, 20.0)
@given(st.floats(20, 80), st.floats(4, 30), st.floats(4, 30), st.floats(20, 80))
def test_what_looks_warm_in_a_photo_is_painted_no_colder(lightness, red, yellow, fitted):
    """Dark brown is as much less yellow than warm skin as blue is than pale skin."""
    painted = painted_blue(fitted, np.broadcast_to([lightness, red, yellow], (27, 24, 3)))
    as_dark = np.array([red, yellow]) * min(fitted / lightness, 1)
    skin = TypicalSkin.of(bare(), 1.0)
    # a colour outside sRGB is painted as the nearest one inside
    in_gamut = skin.lab(skin.roots_of(np.array([fitted, *as_dark])))
    np.testing.assert_allclose(painted, in_gamut, atol=0.1)


@given(st.floats(-2, 6), st.floats(0, 0.01))
def test_a_hardly_warmer_look_makes_a_hardly_warmer_product(red, more):
    blues = [
        painted_blue(50, np.broadcast_to([50, one, 12], (27, 24, 3)))[2]
        for one in (red, red + more)
    ]
    assert 0 <= blues[1] - blues[0] + 1e-3 < 0.1


@given(st.floats(20, 80), st.floats(-40, 30), st.floats(-60, 0))
def test_what_looks_blue_in_a_photo_is_painted_blue(lightness, red, blue):
    looks = np.broadcast_to([lightness, red, blue], (27, 24, 3))
    np.testing.assert_array_equal(painted_blue(50, looks), painted_blue(50, GREY))


def painted_blue(lightness, looks):
    """CIELAB of what a fitted blue product becomes in neutral light; looks: CIELAB in the photo."""
    skin = TypicalSkin.of(bare(), 1.0)
    found = Spread(skin.roots_of(np.array([[lightness, 0, -20]])), np.ones((1, 27, 24)), np.ones(1))
    roots = shadows._no_colder(found, np.ones((27, 24, 3)), looks, skin, np.ones(3))
    return skin.lab(roots)[0]


def test_in_cool_light_products_stay_as_cold_as_fitted():
    skin = TypicalSkin.of(bare(), 1.0)
    found = Spread(skin.roots_of(np.array([[50.0, 0, -60]])), np.ones((1, 27, 24)), np.ones(1))
    seen = np.ones((27, 24, 3))
    same = shadows._no_colder(found, seen, GREY, skin, np.array([0.9, 1.0, 1.1]))
    np.testing.assert_array_equal(same, found.roots)


def vividness(off, probability):
    """How many times further from bare eyes a colour as light as they are is painted than seen."""
    bare_eyes = np.full((27, 24, 3), 0.8)
    off = np.array(off) - np.array(off) @ LUMINANCE
    seen = bare_eyes + 0.1 * off / np.linalg.norm(off)
    painted = shadows._shaded(seen, bare_eyes, probability)
    return float(np.ptp(painted, axis=-1)[0, 0] / np.ptp(seen, axis=-1)[0, 0])


@given(st.floats(0.3, 1), st.floats(0.3, 1), st.floats(0, 0.7))
def test_warm_shadow_that_is_unsure_is_as_vivid_as_it_is_seen(red, blue, probability):
    warm = red, 0.0, -blue
    assert vividness(warm, probability) == pytest.approx(1, abs=0.06)
    assert vividness(warm, probability) < vividness(warm, 0.85) < vividness(warm, 1.0) - 0.05


@given(st.sampled_from([(1, -1, 0.5), (-1, 0, 1), (-1, 1, -1), (-1, 0.5, 0.5)]), st.floats(0, 1))
def test_pink_blue_and_green_are_as_vivid_however_sure(cool, probability):
    assert vividness(cool, 1.0) > 1.2
    assert vividness(cool, probability) == pytest.approx(vividness(cool, 1.0), abs=0.01)


def painted_lids(rgb):
    worn = replace(product(rgb, "matte", "eyes"), opacity=0.9)
    return neutral_of(apply_look(portrait(), Look([Layer("eyeshadow", worn, FULL)]), [face()]))


@settings(max_examples=10, deadline=None)
@given(st.floats(0.1, 1))
def test_shimmer_on_light_lids_has_a_deeper_colour(shimmer):
    neutral = painted_lids((120, 190, 200))
    flat = flat_eyes(neutral)
    matte, shining = (fit_shadows(neutral, flat, shimmer=one) for one in (0.0, shimmer))
    assert matte and all(one.product.gloss == one.product.shimmer == 0 for one in matte)
    assert any(one.product.gloss > 0 and one.product.shimmer > 0 for one in shining)
    for before, after in zip(matte, shining, strict=True):
        assert after.whole_shape == before.whole_shape
        assert after.product.opacity == before.product.opacity
        deeper, lighter = (np.array(rgb_of_hex(one.product.hex)) for one in (after, before))
        assert (deeper <= lighter).all()
        assert (deeper < lighter).any() == (after.product.shimmer > 0)


@settings(max_examples=10, deadline=None)
@given(st.floats(0, 1))
def test_dark_lids_stay_matte(shimmer):
    """Shine on them looks like grey dust."""
    neutral = painted_lids((30, 16, 40))
    layers = fit_shadows(neutral, flat_eyes(neutral), shimmer=shimmer)
    assert layers and all(one.product.shimmer == one.product.gloss == 0 for one in layers)


def test_shimmer_is_painted_where_the_inner_lid_is_light():
    neutral = painted_lids((120, 190, 200))
    flat = flat_eyes(neutral)
    across, _ = flat_places()
    dark_inside, dark_outside = flat.copy(), flat.copy()
    dark_inside[:, across < 0.4] *= 0.3
    dark_outside[:, across > 0.6] *= 0.3
    assert not shines(fit_shadows(neutral, dark_inside, shimmer=1.0))
    layers = fit_shadows(neutral, dark_outside, shimmer=1.0)
    assert shines(layers) and not shines([one for one in layers if luminance(one) < 0.03])


def test_no_eyeshadow_below_the_eye_shimmers():
    neutral = painted_lids((120, 190, 200))
    layers = fit_shadows(neutral, flat_eyes(neutral), shimmer=1.0)
    below = np.full((27, 24), 0.0)
    below[18:] = 0.8
    spread = Spread(np.full((1, 3), 0.9), below[None], np.array([0.8]))
    skin = TypicalSkin.of(neutral, 1.0)
    assert shines(layers)
    assert not shines(shadows._layers(spread, skin, 1.0, 1.0))


def shines(layers):
    return any(one.product.shimmer > 0 for one in layers)


def luminance(layer):
    return float(to_linear(np.array(rgb_of_hex(layer.product.hex)) / 255, SRGB) @ LUMINANCE)


@given(st.floats(0, 1), st.floats(0, 1))
def test_the_more_an_eyeshadow_shimmers_the_more_it_shines(one, other):
    less, more = (shimmering((120, 190, 200), each) for each in sorted((one, other)))
    assert less.gloss <= more.gloss and less.shimmer <= more.shimmer
    assert less.reflection <= more.reflection <= 0.05
    assert (less.red, less.green, less.blue) == (120, 190, 200) == (more.red, more.green, more.blue)


def test_shimmer_goes_from_matte_to_a_broad_sheen():
    matte, most = (shimmering((120, 190, 200), each) for each in (0.0, 1.0))
    assert matte == product((120, 190, 200), "matte", "eyes")
    assert most.gloss > 1.5 and most.shimmer > 0.5


@given(st.floats(0.076, 1), st.floats(0.05, 1))
def test_eyeshadow_that_shimmers_is_called_shimmering(shimmer, opacity):
    worn = replace(shimmering((120, 190, 200), shimmer), opacity=opacity)
    assert in_words(worn, "eyes").split(",")[0] in ("shimmering", "metallic")
