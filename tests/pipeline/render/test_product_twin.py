"""Products under a scene's light: from parameters to the numbers of the kernel."""

from dataclasses import astuple

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from makeup import codings, lights, params, places, product, white_light
from makeup_video.kernels.colour import HLG, PQ, Coding, product_linear
from makeup_video.pipeline.render.product_material import LUMINANCE
from makeup_video.pipeline.render.product_twin import SkinAxes, material
from makeup_video.pipeline.render.scene import SceneLight

FACING = SkinAxes(np.eye(2), 200.0)


def lit(light=None, amount=1.0, axes=FACING, coding=None, **given_params):
    return material(
        product(**given_params), amount, light or white_light(), axes, coding or Coding()
    )


def lamp(colour=(1.0, 1.0, 1.0), strength=1.0, direction=(0, -0.5, -(0.75**0.5))):
    return SceneLight(
        np.array(colour, np.float32), strength, np.array(direction, np.float32),
        white_light().environment,
    )  # fmt: skip


def test_under_white_light_a_product_has_its_own_colour():
    want = product_linear((180, 0, 46), Coding())
    np.testing.assert_allclose(lit().product, want, rtol=1e-6)
    wide = Coding(9, primaries=9)
    np.testing.assert_allclose(lit(coding=wide).product, want)  # mixed in sRGB's primaries


@pytest.mark.parametrize("adaptation", [0.0, 0.5, 1.0])
def test_the_light_colours_the_product_as_far_as_it_adapts(adaptation):
    warm = lamp((1.3, 0.95, 0.6), 0.5)
    under_white, under_warm = (
        np.array(lit(light, red=90, green=80, blue=70, light_adaptation=adaptation).product)
        for light in (None, warm)
    )
    want = 1 + adaptation * (np.array([1.3, 0.95, 0.6]) * 0.5 - 1)
    np.testing.assert_allclose(under_warm / under_white, want, rtol=1e-6)


@pytest.mark.parametrize("name", ["opacity", "reflection", "own_highlights", "glint"])
def test_strength_scales_what_is_laid_on(name):
    full, half = (
        np.array(getattr(lit(amount=a, gloss=1, reflection=0.6), name)) for a in (1.0, 0.5)
    )
    np.testing.assert_allclose(half, 0.5 * full)


def test_shimmer_fades_with_a_product_that_is_hardly_there():
    sparkles = [sum(lit(shimmer=1, opacity=o).sparkle) for o in (0.0, 0.1, 0.5, 1.0)]
    assert sparkles[0] == 0 and (np.diff(sparkles) > 0).all()


def test_sparkles_finer_than_a_pixel_are_not_drawn():
    small, large = (lit(shimmer=1, axes=SkinAxes(np.eye(2), px)) for px in (15.0, 900.0))
    assert sum(small.sparkle) == 0 and sum(large.sparkle) > 0


SIZES = np.geomspace(10, 2000, 4000)  # px between the eyes, in steps of an eighth of a percent


@pytest.mark.parametrize("size", [0.0, 0.3, 1.0])
def test_sparkles_survive_codecs_on_faces_of_any_size(size):
    seen = [lit(shimmer=1, shimmer_size=size, axes=SkinAxes(np.eye(2), px)) for px in SIZES]
    strength = np.array([max(m.sparkle) for m in seen])
    cell_px = np.array([px / m.cells for m, px in zip(seen, SIZES, strict=True)])
    radius_px = np.array([m.spot**0.5 for m in seen]) * cell_px
    assert radius_px[strength > 0].min() > 1.1 and strength.max() > 0.3
    # while sparkles are seen, the grid of cells never changes at once
    assert np.abs(np.diff(strength)).max() < 0.03 * strength.max()
    regrown = np.diff(np.log([m.cells for m in seen])) != 0
    assert regrown.any() or size == 1.0
    assert strength[:-1][regrown].max(initial=0) < 0.03 * strength.max()


@pytest.mark.parametrize("rgb", [(132, 40, 146), (180, 0, 46), (20, 60, 160)], ids=str)
def test_sparkles_and_sheen_of_deep_colours_keep_their_hue(rgb):
    red, green, blue = rgb
    m = lit(shimmer=1, shimmer_tint=0.4, red=red, green=green, blue=blue)
    own = product_linear(rgb, Coding())
    for light in (m.sparkle, m.glint):
        least, most = np.min(light), np.max(light)
        assert least < 0.3 * most and np.argmax(light) == np.argmax(own)


@pytest.mark.parametrize("rgb", [(180, 0, 46), (180, 46, 0), (0, 0, 7)], ids=str)
def test_metals_without_a_primary_add_none_of_it(rgb):
    red, green, blue = rgb
    m = lit(shimmer=1, shimmer_tint=1, gloss=1, gloss_detail=0.0, red=red, green=green, blue=blue)
    for light in (m.product, m.glint, m.sparkle):
        assert min(light) == 0


def test_only_pale_products_have_silver_sparkles():
    pale, black = (lit(shimmer=1, shimmer_tint=0, red=c, green=c, blue=c).sparkle for c in (230, 4))
    assert min(pale) > 1.5 and max(black) < 0.2


def glint_of(red, green, blue):
    """The highlight of a product as a share of a white one's."""
    shining = {"gloss": 1, "gloss_detail": 0.0, "shimmer": 0}
    white = lit(red=255, green=255, blue=255, **shining).glint
    return np.array(lit(red=red, green=green, blue=blue, **shining).glint) / white


@given(st.floats(0, 255), st.floats(0, 255), st.floats(0, 255))
def test_a_highlight_has_the_hue_of_deep_products_alone(red, green, blue):
    """A white haze on deep lipstick looks like ash."""
    product, glint = product_linear((red, green, blue), Coding()), glint_of(red, green, blue)
    assert (glint <= 1 + 1e-6).all() and (glint >= 0.3 - 1e-6).all()
    assert glint.max() == pytest.approx(1)  # the product's brightest channel shines as before
    assert (np.diff(glint[np.argsort(product, kind="stable")]) >= -1e-6).all()
    if product @ LUMINANCE >= 0.13:
        assert glint == pytest.approx(1)


@given(st.floats(0, 255))
def test_grey_and_black_shine_as_white_does(code):
    assert glint_of(code, code, code) == pytest.approx(1)


def test_wine_shines_in_its_own_hue():
    red, green, blue = glint_of(90, 5, 20)
    assert red == pytest.approx(1) and green < 0.5 and blue < 0.5


def test_gloss_is_shared_between_own_and_synthetic_highlights():
    own, synthetic = lit(gloss=1, gloss_detail=1.0), lit(gloss=1, gloss_detail=0.0)
    assert own.own_highlights > 0 and sum(own.glint) == 0
    assert synthetic.own_highlights == 0 and min(synthetic.glint) > 0


def test_roughness_makes_highlights_broader_and_weaker():
    sharp, rough = (lit(gloss=1, gloss_roughness=r) for r in (0.0, 1.0))
    assert 0 < sharp.lobe < rough.lobe < 1
    assert rough.glint[0] < sharp.glint[0]


def test_a_highlight_lies_between_light_and_viewer():
    left = lamp(direction=(-0.6, 0, -0.8))
    x, y, z = lit(left).half_way
    assert x < -0.2 and abs(y) < 1e-6 and z > 0.8
    upside_down = SkinAxes(-np.eye(2), 200.0)
    assert lit(left, axes=upside_down).half_way[:2] == pytest.approx((-x, -y))


def test_hdr_has_room_for_highlights_beyond_white():
    sdr, pq, hlg = (lit(coding=Coding(9, False, transfer, 9, 10)) for transfer in (13, PQ, HLG))
    assert sdr.ceiling == 1 and pq.ceiling == hlg.ceiling > 1


@settings(max_examples=150, deadline=None)
@given(params(), st.floats(0, 1), lights(), places(), codings(), st.booleans())
def test_every_number_is_finite_and_in_its_range(p, amount, light, axes, coding, spares):
    m = material(p, amount, light, axes, coding, spares)
    assert np.isfinite(np.hstack(astuple(m))).all() and np.isfinite(np.hstack(m.record())).all()
    for share in (m.opacity, m.texture, m.undertone, m.reflection, m.shimmer):
        assert 0 <= share <= 1
    assert 0 < m.lobe < 1 and m.spot > 0 and m.cells > 0 and m.dark > 0
    assert np.linalg.norm(m.half_way) == pytest.approx(1) and m.half_way[2] > 0
    assert min(m.glint) >= 0 and m.own_highlights >= 0
    # a region reaches less than 8 eye distances, so that sparkle cells stay in range
    assert m.cells * 8 < 4096
