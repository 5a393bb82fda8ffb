"""Makeup that is measured on a photo: what was painted is found again, on a real face."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from makeup_video.pipeline import Look, product
from makeup_video.pipeline.faces.net import read_array
from makeup_video.pipeline.look.ciede2000 import ciede2000, lab_of, linear_of_lab
from makeup_video.pipeline.look.kinds import KINDS
from makeup_video.pipeline.look.look import Layer
from makeup_video.pipeline.look.params import rgb_of_hex
from makeup_video.pipeline.reference.cheeks import see_cheeks
from makeup_video.pipeline.reference.fit_blush import fit_blush
from makeup_video.pipeline.reference.fit_lips import fit_lips, lip_pixels
from makeup_video.pipeline.reference.fit_shadows import fit_shadows
from makeup_video.pipeline.reference.flat_eyes import FLAT_HW, density
from makeup_video.pipeline.reference.flat_lips import flat_lips
from makeup_video.pipeline.reference.neutral_face import neutral_face
from makeup_video.pipeline.reference.photo_light import photo_light
from makeup_video.pipeline.reference.read_lipstick import LipstickForm, read_lipstick
from makeup_video.pipeline.render.apply_look import PaintPictures
from people import portrait
from reference_photos import face, flat_eyes

LID = product((90, 58, 46), "matte", "eyes")
LIPS = product((180, 40, 60), "satin", "lips")
COLOURS = [(20, 40, 150), (130, 20, 60), (25, 22, 24), (30, 110, 60)]


@cache
def painter():
    return PaintPictures()


def wearing(*layers):
    rgb8 = painter()(portrait(), Look(layers), [face()])
    return neutral_face(rgb8, face(), photo_light(rgb8, face()))


def lips_of(neutral, lips, probability=1.0, form=None):
    form = read_lipstick(neutral.rgb8, neutral.face) if form is None else form
    return fit_lips(neutral, lip_pixels(neutral), lips, flat_lips(neutral), form, probability)


def shadows_of(neutral):
    return fit_shadows(neutral, flat_eyes(neutral))


def blush_of(neutral):
    return fit_blush(neutral, see_cheeks(neutral), {})


def off(rgb, product_read):
    """CIEDE2000 between a colour and that of a product."""
    read = product_read.red, product_read.green, product_read.blue
    return float(ciede2000(lab_of(np.array(rgb)), lab_of(np.array(read))))


def test_the_skin_is_one_in_roots_of_skin():
    neutral = wearing()
    np.testing.assert_allclose(neutral.roots(neutral.skin), 1, atol=1e-6)


@cache
def wearing_nothing():
    return wearing()


@pytest.mark.parametrize("rgb", COLOURS)
def test_an_opaque_lipstick_is_found_again(rgb):
    worn = replace(product(rgb, "matte", "lips"), opacity=0.95)
    read = lips_of(wearing(Layer("lipstick", worn)), replace(LIPS, gloss=0.0)).product
    assert off(rgb, read) < 7 and read.opacity > 0.8


@settings(max_examples=6, deadline=None)
@given(st.floats(0, 0.3), st.floats(0.7, 1.2))
def test_a_glossier_lipstick_is_read_as_glossier(dull, glossy):
    worn = product((180, 40, 60), "satin", "lips")
    one, other = (
        lips_of(wearing(Layer("lipstick", replace(worn, gloss=gloss))), LIPS).product.gloss
        for gloss in (dull, glossy)
    )
    assert one + 0.1 < other


def test_a_dark_rim_is_found_and_an_even_lipstick_has_none():
    worn = replace(product((230, 140, 140), "matte", "lips"), opacity=0.95)
    rimmed = Layer("lipstick", worn, {"rim": 1.0, "rim_color": "#200810"})
    lips = lips_of(wearing(rimmed), LIPS)
    whole, rim = (
        lab_of(np.array(rgb_of_hex(colour)))[0]
        for colour in (lips.product.hex, lips.shape["rim_color"])
    )
    assert lips.shape["rim"] > 0.5 and rim < whole - 18
    assert "rim" not in lips_of(wearing(Layer("lipstick", worn)), LIPS).shape


@settings(max_examples=8, deadline=None)
@given(st.floats(10, 150), st.floats(0, 60), st.floats(0, 60))
def test_no_rim_is_more_vivid_than_its_lipstick(red, green, blue):
    worn = replace(product((225, 150, 140), "matte", "lips"), opacity=0.95)
    rim = {"rim": 1.0, "rim_color": product((red, green, blue), "matte", "lips").hex}
    lips = lips_of(wearing(Layer("lipstick", worn, rim)), LIPS)
    hues = [
        np.linalg.norm(lab_of(np.array(rgb_of_hex(colour)))[1:])
        for colour in (lips.product.hex, lips.shape.get("rim_color", lips.product.hex))
    ]
    assert hues[1] <= hues[0] + 1


def test_a_gradient_is_found_again_with_its_colour():
    worn = replace(product((190, 20, 50), "matte", "lips"), opacity=0.95)
    read = lips_of(wearing(Layer("lipstick", worn, {"gradient": 0.8})), LIPS)
    even = lips_of(wearing(Layer("lipstick", worn)), LIPS)
    assert read.shape["gradient"] > even.shape["gradient"] + 0.2
    assert off((190, 20, 50), read.product) < 8


@pytest.mark.parametrize(
    ("rgb", "softer"), [((235, 150, 140), True), ((190, 20, 50), False), ((70, 20, 40), False)]
)
def test_only_a_light_lipstick_that_is_unsure_ends_softly(rgb, softer):
    worn = replace(product(rgb, "matte", "lips"), opacity=0.95)
    seen = wearing(Layer("lipstick", worn))
    even = LipstickForm(0.0, 0.0)
    sure, likely, unsure = (lips_of(seen, LIPS, p, even).shape["gradient"] for p in (1.0, 0.8, 0.4))
    assert sure < likely < unsure if softer else sure == likely == unsure


@given(read=st.floats(0, 1.5), fade=st.floats(0, 0.95))
@settings(max_examples=10, deadline=None)
def test_the_larger_gloss_counts_and_the_gradient_as_read(read, fade):
    glossy = replace(product((180, 40, 60), "gloss", "lips"), gloss=0.9)
    seen = wearing(Layer("lipstick", glossy))
    shown = lips_of(seen, LIPS, form=LipstickForm(0.0, 0.0)).product.gloss
    lips = lips_of(seen, LIPS, form=LipstickForm(read, fade))
    assert shown > 0.1 and lips.product.gloss == pytest.approx(max(read, shown), abs=1e-3)
    assert lips.shape["gradient"] == pytest.approx(fade, abs=1e-3)


@pytest.mark.parametrize("rgb", COLOURS)
def test_an_opaque_shadow_is_found_again_on_the_lid(rgb):
    worn = replace(product(rgb, "matte", "eyes"), opacity=0.9)
    layers = shadows_of(wearing(Layer("eyeshadow", worn, {"slot": "lid"})))
    assert 1 <= len(layers) <= KINDS["eyeshadow"].most
    lid = density(Layer("eyeshadow", worn, {"slot": "lid"})) > 0.8
    before = flat_eyes(wearing_nothing())[lid].mean(0)
    seen = flat_eyes(wearing(Layer("eyeshadow", worn, {"slot": "lid"})))[lid].mean(0)
    again = flat_eyes(wearing(*layers))[lid].mean(0)
    one, other = seen - before, again - before
    assert one @ other > 0.85 * np.linalg.norm(one) * np.linalg.norm(other)  # the same hue
    assert 0.5 < np.linalg.norm(other) / np.linalg.norm(one) < 2


@pytest.mark.parametrize("slot", ["crease", "outer", "under", "full"])
def test_a_dark_shadow_darkens_the_same_place_again(slot):
    worn = replace(product((60, 20, 40), "matte", "eyes"), opacity=0.9)
    layer = Layer("eyeshadow", worn, {"slot": slot})
    seen, before = flat_eyes(wearing(layer)), flat_eyes(wearing_nothing())
    again = flat_eyes(wearing(*shadows_of(wearing(layer))))
    there = density(layer) > 0.7
    assert np.abs(again - seen)[there].mean() < 0.6 * np.abs(before - seen)[there].mean()


@given(st.floats(0, 1))
@settings(max_examples=6, deadline=None)
def test_a_shadow_below_the_eye_is_read_however_likely(probability):
    worn = replace(product((200, 70, 70), "matte", "eyes"), opacity=0.7)
    neutral = wearing(*(Layer("eyeshadow", worn, {"slot": slot}) for slot in ("full", "under")))
    read = fit_shadows(neutral, flat_eyes(neutral), probability)
    below = density(Layer("eyeshadow", worn, {"slot": "under"})) > 0.7
    assert max(one.product.opacity * density(one)[below].mean() for one in read) > 0.1


@given(st.integers(60, 120), st.integers(150, 220))
@settings(max_examples=10, deadline=None)
def test_below_a_grey_shadow_no_red_one_is_read(grey, red):
    above = replace(product((grey, grey, grey + 10), "matte", "eyes"), opacity=0.8)
    below = replace(product((red, 60, 50), "matte", "eyes"), opacity=0.7)
    neutral = wearing(
        Layer("eyeshadow", above, {"slot": "full"}), Layer("eyeshadow", below, {"slot": "under"})
    )
    there = density(Layer("eyeshadow", below, {"slot": "under"})) > 0.7

    def redness(eyes):
        return float(np.median(eyes[there][:, 0] / eyes[there][:, 1]))

    again = flat_eyes(wearing(*shadows_of(neutral)))
    assert redness(again) < 1.08 * redness(flat_eyes(wearing_nothing()))


@pytest.mark.parametrize("slot", ["full", "outer"])
def test_a_soft_grey_is_not_read_as_black(slot):
    dense = density(Layer("eyeshadow", LID, {"slot": slot}))[..., None]
    bare = read_array("bare_eyes.npy").astype(np.float32)[..., :3]
    seen = (1 - dense) * bare + dense * np.float32(0.5)  # half the root of the skin's light
    layers = fit_shadows(wearing_nothing(), seen)
    assert layers
    for layer in layers:
        read = layer.product
        assert lab_of(np.array([read.red, read.green, read.blue]))[0] > 20


@settings(max_examples=6, deadline=None)
@given(st.floats(0, 1), st.floats(0, 1))
def test_a_less_likely_shadow_is_painted_sheerer(one, other):
    neutral = wearing(Layer("eyeshadow", product((60, 20, 40), "matte", "eyes"), {"slot": "lid"}))
    seen = flat_eyes(neutral)
    sheer, more = (
        max(layer.product.opacity for layer in fit_shadows(neutral, seen, probability))
        for probability in sorted((one, other))
    )
    assert sheer <= more + 0.01


def test_a_blush_reddens_the_cheeks_again():
    (read,) = blush_of(wearing(Layer("blush", product((200, 30, 60), "matte", "blush"))))
    assert read.product.red > read.product.green + 100


@settings(max_examples=8, deadline=None)
@given(st.integers(150, 230), st.integers(60, 130), st.floats(0.3, 1))
def test_an_orange_blush_is_read_as_no_more_orange(red, green, opacity):
    worn = replace(product((red, green, green - 40), "matte", "blush"), opacity=opacity)
    for read in blush_of(wearing(Layer("blush", worn))):
        seen = read.product
        assert seen.green - seen.blue <= 40 and seen.red - seen.green >= 30


@given(st.floats(0.5, 1.6), st.floats(-0.015, 0.015))
def test_cheeks_like_bare_ones_have_no_blush_in_any_light(light, warm):
    cheeks = see_cheeks(wearing_nothing())
    roots = light * cheeks.film().bare * [1 + warm, 1, 1 - warm]
    assert fit_blush(wearing_nothing(), replace(cheeks, roots=roots), {}) == []


@settings(max_examples=10, deadline=None)
@given(st.integers(0, 10**6))
def test_any_picture_gives_layers_that_can_be_worn(seed):
    noise = np.random.default_rng(seed).integers(0, 256, portrait().shape, np.uint8)
    neutral = neutral_face(noise, face(), photo_light(noise, face()))
    assert flat_eyes(neutral).shape == (*FLAT_HW, 3)
    layers = [*shadows_of(neutral), *blush_of(neutral), lips_of(neutral, LIPS)]
    assert Look.from_dict(Look(layers).to_dict()) == Look(layers)


def test_lips_that_are_not_seen_keep_what_the_net_reads():
    neutral = wearing_nothing()
    away = replace(neutral, face=replace(neutral.face, points_px=neutral.face.points_px + 1e4))
    hidden = replace(away.face, lips=replace(away.face.lips, logits=away.face.lips.logits - 99))
    gone = replace(neutral, face=hidden)
    assert lip_pixels(gone) is None and lips_of(gone, LIPS).product == LIPS


def test_a_violet_blush_is_found_again():
    worn = product((70, 50, 230), "matte", "blush")
    (read,) = blush_of(wearing(Layer("blush", worn)))
    assert read.product.blue > read.product.red > read.product.green


@pytest.mark.parametrize("light", [0.6, 1.7])
def test_a_blush_keeps_its_colour_in_light_from_the_side(light):
    worn = wearing(Layer("blush", product((200, 30, 60), "matte", "blush")))
    cheeks = see_cheeks(worn)
    (read,) = fit_blush(worn, cheeks, {})
    lit = replace(cheeks, roots=cheeks.roots * np.float32(np.sqrt(light)))
    (again,) = fit_blush(worn, lit, {})
    assert again.product.red > again.product.green + 60
    assert abs(hue(again.product) - hue(read.product)) < 25


def hue(product_read):
    """The angle of a product's colour in CIELAB, degrees."""
    lab = lab_of(np.array([product_read.red, product_read.green, product_read.blue]))
    return float(np.degrees(np.arctan2(lab[2], lab[1])))


@settings(max_examples=12, deadline=None)
@given(st.sampled_from(["full", "outer", "lid"]), st.floats(12, 26), st.floats(5, 8))
def test_dark_brown_on_tanned_skin_in_warm_light_is_not_blue(slot, lightness, red):
    skin = linear_of_lab(np.array([66.0, 17.0, 22.0]))
    brown = np.sqrt(linear_of_lab(np.array([lightness, red, 0.5 * red])) / skin)
    dense = density(Layer("eyeshadow", LID, {"slot": slot}))[..., None]
    bare = read_array("bare_eyes.npy").astype(np.float32)[..., :3]
    seen = (1 - dense) * bare + dense * brown.astype(np.float32)
    warm = replace(wearing_nothing(), skin=skin, light=np.array([1.15, 1.0, 0.85]))
    layers = fit_shadows(warm, seen)
    assert layers
    for layer in layers:
        read = layer.product
        assert lab_of(np.array([read.red, read.green, read.blue]))[2] > -6


def test_a_pink_shadow_in_soft_light_is_no_white_veil():
    worn = replace(product((230, 90, 110), "matte", "eyes"), opacity=0.7)
    layer = Layer("eyeshadow", worn, {"slot": "full"})
    neutral = wearing(layer)
    seen, dense = flat_eyes(neutral), density(layer) > 0.5
    again = flat_eyes(wearing(*fit_shadows(neutral, 1.2 * seen)))
    redness, read = ((cells[..., 0] - cells[..., 1])[dense] for cells in (seen, again))
    share = (read / redness)[redness > 0.05]  # not on the rims of the glasses
    assert len(share) > 200 and np.median(share) > 0.9 and np.quantile(share, 0.05) > 0.6


def test_lips_beside_skin_that_is_too_dark_are_not_chalk():
    neutral = wearing(Layer("lipstick", replace(product((190, 70, 80), "matte", "lips"))))
    shaded = replace(neutral, skin=neutral.skin / 4)
    read = fit_lips(
        shaded, lip_pixels(neutral), LIPS, flat_lips(neutral), LipstickForm(0.2, 0.0)
    ).product
    lab = lab_of(np.array([read.red, read.green, read.blue]))
    assert lab[0] < 75 and lab[1] > 15


@given(st.floats(0, 1))
def test_blush_is_the_sheerer_the_less_likely_it_is(probability):
    neutral = wearing_nothing()
    cheeks = replace(see_cheeks(neutral), roots=see_cheeks(neutral).roots * [1.0, 0.85, 0.88])
    sure, doubtful = (
        [layer.product.opacity for layer in fit_blush(neutral, cheeks, {}, share)]
        for share in (1.0, probability)
    )
    assert len(sure) == len(doubtful) == 1
    assert 0.59 * sure[0] <= doubtful[0] <= sure[0]
    assert probability < 0.3 or doubtful == sure


@settings(max_examples=8, deadline=None)
@given(st.floats(10, 18), st.floats(0, 8))
def test_soft_browns_of_pale_skin_are_less_vivid(red, yellow):
    dense = density(Layer("eyeshadow", LID, {"slot": "full"}))[..., None]
    bare = read_array("bare_eyes.npy").astype(np.float32)[..., :3]

    def redness(lightness):
        """How much redder than skin the layers read for a brown are, weighted by their opacity."""
        plain = np.array([lightness, 10.0, 12.0])
        skin, off = linear_of_lab(plain), np.array([-12, red, yellow])
        brown = np.sqrt(linear_of_lab(plain + off) / skin)
        seen = (bare * ((1 - dense) + dense * brown)).astype(np.float32)
        layers = fit_shadows(replace(wearing_nothing(), skin=skin), seen)
        labs = lab_of(np.array([rgb_of_hex(one.product.hex) for one in layers]))
        amounts = np.array([one.product.opacity * density(one).mean() for one in layers])
        return float(amounts @ (labs[:, 1] - 10))

    assert redness(82.5) < redness(77.5)
