"""Layers that are composed beforehand look as if they were painted one after another."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from makeup import FLAT, any_codes, flat_surface, lights, paint_codes, params, product, white_light
from makeup_video.kernels.colour import Coding
from makeup_video.kernels.material import Varying, made_up, skin_at
from makeup_video.pipeline.look.finishes import product as finished
from makeup_video.pipeline.render.blend_layers import blend
from makeup_video.pipeline.render.product_material import SkinAxes, material

FACING = SkinAxes(np.eye(2), 700.0)
HW = (6, 9)
SKIN = np.array([0.45, 0.24, 0.16])
DARK_ROOM = np.zeros((3, 16, 16))
V, U = np.mgrid[: HW[0], : HW[1]] * 0.011
densities = st.integers(0, 999).map(
    lambda seed: np.random.default_rng(seed).uniform(-0.2, 1.2, HW).clip(0, 1).astype(np.float32)
)
layered = st.lists(st.tuples(densities, params()), min_size=1, max_size=4)


def lit(params, light=None):
    return material(params, 1.0, light or white_light(), FACING, Coding())


def whole(value=1.0):
    return np.full(HW, value, np.float32)


def on(light, weight, m, maps=None, shade=1.0):
    """Put a product on light (H, W, 3) that has no texture of its own."""
    coarse = light @ np.array(m.luminance)
    skin = skin_at(coarse, 0.2, 0 * coarse, 0 * coarse, DARK_ROOM, m)
    skin.shade = np.full(HW, shade)
    varying = None
    if maps is not None:
        varying = Varying(np.moveaxis(maps[:3], 0, -1), maps[3], np.moveaxis(maps[4:7], 0, -1), maps[7])  # fmt: skip
    return made_up(light, weight, U, V, skin, m, varying)


def one_after_another(layers, shade=1.0):
    light = np.broadcast_to(SKIN, (*HW, 3))
    for density, m in layers:
        light = on(light, density, m, shade=shade)
    return light


def blended(layers):
    return blend(np.stack([density for density, _ in layers]), [m for _, m in layers])


def at_once(layers, shade=1.0):
    maps, m = blended(layers)
    return on(np.broadcast_to(SKIN, (*HW, 3)), whole(), m, maps.astype(float), shade)


@settings(max_examples=100, deadline=None)
@given(
    st.lists(st.tuples(densities, params(**FLAT, undertone=0.0)), min_size=1, max_size=4),
    st.sampled_from([0.3, 1.0]),
)
def test_films_at_once_are_films_one_after_another(films, shade):
    """To a thousandth of white: the maps are float32, and where hardly anything lies, they take
    the mean colour of all layers. Undertone, which each film would take from the film below, and
    light beyond the mean of the region, which is clipped softly, are left out."""
    layers = [(density, lit(p)) for density, p in films]
    np.testing.assert_allclose(at_once(layers, shade), one_after_another(layers, shade), atol=1e-3)


@pytest.mark.parametrize("finish", ["satin", "gloss", "metallic", "shimmer"])
@pytest.mark.parametrize("region", ["lips", "eyes"])
def test_finishes_at_once_look_as_one_after_another(finish, region):
    """A deep matte colour outside, a finish on the rest, half over each other. What differs is the
    undertone, and light that is added under half a film: most for a sparkle, 0.1 of white."""
    x = np.linspace(0, 1, HW[1], dtype=np.float32)
    outside, rest = np.broadcast_to(x, HW), np.broadcast_to(1 - x, HW)
    below = (rest, lit(finished((200, 120, 90), finish, region)))
    above = (outside, lit(finished((60, 20, 40), "matte", region)))
    got, want = at_once([below, above]), one_after_another([below, above])
    off = np.abs(got - want)
    assert off.max() < 0.1 and np.quantile(off, 0.9) < 0.03 and np.median(off) < 0.01


@settings(max_examples=60, deadline=None)
@given(params(gloss=0.5), st.integers(0, 9))
def test_one_layer_is_painted_as_its_product_alone(p, seed):
    luma, chroma = any_codes(seed, (9, 6), Coding())
    surface, m = flat_surface((9, 6), 0.2), lit(p)
    maps, common = blended([(np.ones((2, 2), np.float32), m)])
    alone = paint_codes(luma, chroma, surface, m, Coding())
    layers = paint_codes(luma, chroma, replace(surface, layers=maps), common, Coding())
    assert np.abs(alone - layers).max() <= 1  # the square of a float32 root is not the number


@settings(max_examples=100, deadline=None)
@given(layered, lights())
def test_maps_and_material_are_finite_and_in_range(given_layers, light):
    layers = [(density, lit(p, light)) for density, p in given_layers]
    maps, m = blended(layers)
    assert maps.shape == (8, *HW) and maps.dtype == np.float32
    assert np.isfinite(maps).all() and np.isfinite(np.hstack(m.record())).all()
    assert maps.min() >= 0
    assert maps[3].max() <= 1 + 1e-6 and maps[7].max() <= len(layers)
    assert np.isfinite(at_once(layers)).all()
    for share in (m.opacity, m.texture, m.undertone, m.reflection, m.shimmer):
        assert 0 <= share <= 1 + 1e-9


@settings(max_examples=60, deadline=None)
@given(layered)
def test_layers_without_density_change_nothing(given_layers):
    layers = [(0 * density, lit(p)) for density, p in given_layers]
    maps, _ = blended(layers)
    assert not maps[3:].any()
    np.testing.assert_allclose(at_once(layers), np.broadcast_to(SKIN, (*HW, 3)), atol=1e-9)


@settings(max_examples=60, deadline=None)
@given(layered, st.tuples(densities, params()))
def test_a_layer_without_density_leaves_the_others_alone(given_layers, empty):
    layers = [(density, lit(p)) for density, p in given_layers]
    nothing = 0 * empty[0], lit(empty[1])
    for more in ([nothing, *layers], [*layers, nothing]):
        np.testing.assert_allclose(blended(more)[0][3], blended(layers)[0][3], rtol=1e-5)
        np.testing.assert_allclose(
            blended(more)[0][:3], blended(layers)[0][:3], rtol=1e-3, atol=1e-5
        )


@settings(max_examples=60, deadline=None)
@given(layered, st.integers(0, 3))
def test_a_denser_layer_covers_more(given_layers, number):
    layers = [(density, lit(p)) for density, p in given_layers]
    number %= len(layers)
    density, m = layers[number]
    denser = [*layers[:number], (np.minimum(density + 0.2, 1), m), *layers[number + 1 :]]
    assert (blended(denser)[0][3] >= blended(layers)[0][3] - 1e-6).all()


@pytest.mark.parametrize("faint", [1e-4, 3e-4])
def test_a_faint_layer_hardly_colours_the_border_beside_it(faint):
    """Densities that are looked up are off by so much, and colours are interpolated."""
    white, black = lit(product(red=255, green=255, blue=255)), lit(product(red=0, blue=0))
    colours = []
    for density in (0.0, faint):
        densities = np.array([[[0.0, density]], [[0.8, 0.0]]], np.float32)
        colours.append(blend(densities, [white, black])[0][:3, 0, 1])
    change = np.abs(colours[1] - colours[0]).max()
    assert 0 < change < 0.4 * np.abs(np.array(white.product) - black.product).max()


def test_an_opaque_matte_layer_hides_the_shine_below():
    shiny = lit(finished((200, 120, 90), "shimmer", "eyes"))
    matte = lit(product(opacity=1.0))
    maps, m = blended([(whole(), shiny), (whole(), matte)])
    assert maps[4:].max() < 1e-6 and m.reflection < 1e-6 and m.own_highlights < 1e-6
    np.testing.assert_allclose(maps[:3, 0, 0], matte.product, atol=1e-5)


def test_clear_gloss_lets_the_colour_below_shine():
    colour = lit(product())
    clear = lit(product(opacity=0.0, gloss=1.0, reflection=0.5))
    maps, m = blended([(whole(), colour), (whole(), clear)])
    np.testing.assert_allclose(maps[:3, 0, 0], colour.product, atol=1e-5)
    np.testing.assert_allclose(maps[4:7, 0, 0], clear.glint, rtol=1e-5)
    shine = maps[7, 0, 0]
    assert shine * m.own_highlights == pytest.approx(clear.own_highlights, rel=1e-4)
    assert shine * m.reflection == pytest.approx(clear.reflection, rel=1e-4)
    assert m.lobe == pytest.approx(clear.lobe)


def test_sparkles_are_those_of_the_layer_that_shimmers_most():
    dust = lit(product(shimmer=0.2, shimmer_size=0.0, blue=200))
    glitter = lit(product(shimmer=0.9, shimmer_size=1.0))
    _, m = blended([(whole(0.5), glitter), (whole(0.5), dust)])
    assert (m.cells, m.spot, m.shimmer) == (glitter.cells, glitter.spot, glitter.shimmer)
    np.testing.assert_allclose(
        np.array(m.sparkle) / max(m.sparkle), np.array(glitter.sparkle) / max(glitter.sparkle)
    )


def test_each_layer_must_have_its_density():
    for densities, materials in ((np.empty((0, *HW)), []), (whole()[None], [lit(product())] * 2)):
        with pytest.raises(ValueError, match="layers must be at least one, each with its density"):
            blend(densities, materials)
