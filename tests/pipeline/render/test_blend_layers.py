"""Layers that are composed beforehand look as if they were painted one after another."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from makeup import FLAT, any_codes, flat_surface, lights, paint_codes, params, product, white_light
from makeup_video.kernels.colour import Coding
from makeup_video.kernels.material_twin import made_up, skin_at
from makeup_video.kernels.paint_twin import composed
from makeup_video.pipeline.look.finishes import product as finished
from makeup_video.pipeline.render.blend_layers import shares_of
from makeup_video.pipeline.render.product_twin import SkinAxes, blend, material

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


def on(light, weight, m, varying=None, shade=1.0):
    """Put a product on light (H, W, 3) that has no texture of its own."""
    coarse = light @ np.array(m.luminance)
    skin = skin_at(coarse, 0.2, 0 * coarse, 0 * coarse, DARK_ROOM, m)
    skin.shade = np.full(HW, shade)
    return made_up(light, weight, U, V, skin, m, varying)


def one_after_another(layers, shade=1.0):
    light = np.broadcast_to(SKIN, (*HW, 3))
    for density, m in layers:
        light = on(light, density, m, shade=shade)
    return light


def films(layers):
    materials = [m for _, m in layers]
    densities = np.stack([density for density, _ in layers])
    return blend(shares_of(densities, [m.opacity for m in materials]), materials)


def blended(layers):
    """What varies, at every place, and the material."""
    made, m = films(layers)
    return composed(made, made.shares), m


def at_once(layers, shade=1.0):
    varying, m = blended(layers)
    return on(np.broadcast_to(SKIN, (*HW, 3)), whole(), m, varying, shade)


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
    """A deep matte colour outside, a finish on the rest, half overlapping. Two things differ: the
    undertone, and light added under half a film, by a third of what the finish adds."""
    x = np.linspace(0, 1, HW[1], dtype=np.float32)
    outside, rest = np.broadcast_to(x, HW), np.broadcast_to(1 - x, HW)
    shining = finished((200, 120, 90), finish, region)
    dull = replace(shining, gloss=0.0, shimmer=0.0, reflection=0.0)
    whole_film = np.ones(HW, np.float32)
    added = at_once([(whole_film, lit(shining))]) - at_once([(whole_film, lit(dull))])
    below = (rest, lit(shining))
    above = (outside, lit(finished((60, 20, 40), "matte", region)))
    got, want = at_once([below, above]), one_after_another([below, above])
    off = np.abs(got - want)
    for number, share in ((np.max, 0.35), (np.median, 0.15)):
        assert number(off) < share * number(np.abs(added)) + 0.008


@settings(max_examples=60, deadline=None)
@given(params(gloss=0.5), st.integers(0, 9))
def test_one_layer_is_painted_as_its_product_alone(p, seed):
    luma, chroma = any_codes(seed, (9, 6), Coding())
    surface, m = flat_surface((9, 6), 0.2), lit(p)
    maps, common = films([(np.ones((2, 2), np.float32), m)])
    alone = paint_codes(luma, chroma, surface, m, Coding())
    layers = paint_codes(luma, chroma, replace(surface, layers=maps), common, Coding())
    assert np.abs(alone - layers).max() <= 1  # squaring a float32 root is not exact


@settings(max_examples=100, deadline=None)
@given(layered, lights())
def test_maps_and_material_are_finite_and_in_range(given_layers, light):
    layers = [(density, lit(p, light)) for density, p in given_layers]
    varying, m = blended(layers)
    assert np.isfinite(np.hstack(m.record())).all()
    for numbers in (varying.product, varying.opacity, varying.glint, varying.shine):
        assert np.isfinite(numbers).all() and numbers.min() >= 0
    assert varying.opacity.max() <= 1 + 1e-6 and varying.shine.max() <= len(layers)
    assert np.isfinite(at_once(layers)).all()
    for share in (m.opacity, m.texture, m.undertone, m.reflection, m.shimmer):
        assert 0 <= share <= 1 + 1e-9


@settings(max_examples=60, deadline=None)
@given(layered)
def test_layers_without_density_change_nothing(given_layers):
    layers = [(0 * density, lit(p)) for density, p in given_layers]
    varying, _ = blended(layers)
    assert not (varying.opacity.any() or varying.glint.any() or varying.shine.any())
    np.testing.assert_allclose(at_once(layers), np.broadcast_to(SKIN, (*HW, 3)), atol=1e-9)


@settings(max_examples=60, deadline=None)
@given(layered, st.tuples(densities, params()))
def test_a_layer_without_density_leaves_the_others_alone(given_layers, empty):
    layers = [(density, lit(p)) for density, p in given_layers]
    nothing = 0 * empty[0], lit(empty[1])
    for more in ([nothing, *layers], [*layers, nothing]):
        got, want = blended(more)[0], blended(layers)[0]
        np.testing.assert_allclose(got.opacity, want.opacity, rtol=1e-5)
        np.testing.assert_allclose(got.product, want.product, rtol=1e-3, atol=1e-5)


@settings(max_examples=60, deadline=None)
@given(layered, st.integers(0, 3))
def test_a_denser_layer_covers_more(given_layers, number):
    layers = [(density, lit(p)) for density, p in given_layers]
    number %= len(layers)
    density, m = layers[number]
    denser = [*layers[:number], (np.minimum(density + 0.2, 1), m), *layers[number + 1 :]]
    assert (blended(denser)[0].opacity >= blended(layers)[0].opacity - 1e-6).all()


@pytest.mark.parametrize("faint", [1e-4, 3e-4])
def test_a_faint_layer_hardly_colours_the_border_beside_it(faint):
    """Looked-up densities have errors of this size, and colours are interpolated."""
    white, black = lit(product(red=255, green=255, blue=255)), lit(product(red=0, blue=0))
    colours = []
    for density in (0.0, faint):
        layers = [(np.float32([[0.0, density]]), white), (np.float32([[0.8, 0.0]]), black)]
        colours.append(blended(layers)[0].product[0, 1])
    change = np.abs(colours[1] - colours[0]).max()
    assert 0 < change < 0.4 * np.abs(np.array(white.product) - black.product).max()


def test_an_opaque_matte_layer_hides_the_shine_below():
    shiny = lit(finished((200, 120, 90), "shimmer", "eyes"))
    matte = lit(product(opacity=1.0))
    varying, m = blended([(whole(), shiny), (whole(), matte)])
    assert max(varying.glint.max(), varying.shine.max(), m.reflection, m.own_highlights) < 1e-6
    np.testing.assert_allclose(varying.product[0, 0], matte.product, atol=1e-5)


def test_clear_gloss_lets_the_colour_below_shine():
    colour = lit(product())
    clear = lit(product(opacity=0.0, gloss=1.0, reflection=0.5))
    varying, m = blended([(whole(), colour), (whole(), clear)])
    np.testing.assert_allclose(varying.product[0, 0], colour.product, atol=1e-5)
    np.testing.assert_allclose(varying.glint[0, 0], clear.glint, rtol=1e-5)
    shine = varying.shine[0, 0]
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


def test_each_layer_must_have_its_shares():
    for shares, materials in ((np.empty((0, *HW)), []), (whole()[None], [lit(product())] * 2)):
        with pytest.raises(ValueError, match="layers must be at least one, each with its shares"):
            blend(shares, materials)
