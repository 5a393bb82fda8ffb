"""The effect of a material on light: colour, texture, highlights, reflection, sparkles."""

from dataclasses import fields, replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from makeup import lights, params, places, product, white_light
from makeup_video.kernels.colour import Coding
from makeup_video.kernels.material import ENVIRONMENT_PX, MATERIAL
from makeup_video.kernels.material_twin import (
    Material,
    Skin,
    added,
    bilinear,
    made_up,
    skin_at,
    sparkles,
)
from makeup_video.pipeline.render.product_twin import SkinAxes, material

FACING = SkinAxes(np.eye(2), 700.0)  # a large face, whose cells are as small as cells can be
DARK_ROOM = np.zeros((3, 16, 16))


def of(light=None, spared=0.0, **given_params) -> Material:
    return material(product(**given_params), 1.0, light or white_light(), FACING, Coding(), spared)


def even(shape=(1, 1), coarse=0.2, mean=0.2, nx=0.0, ny=0.0, room=DARK_ROOM, m=None) -> Skin:
    full = np.full(shape, 1.0)
    return skin_at(coarse * full, mean, nx * full, ny * full, room, m or of())


def paint(bare, m, skin=None, weight=1.0, u=0.5, v=0.5):
    """The light of one pixel."""
    ones = np.ones((1, 1))
    return made_up(np.full((1, 1, 3), bare), weight * ones, u * ones, v * ones, skin or even(), m)[
        0, 0
    ]


def test_the_struct_holds_the_fields_of_a_material_by_name():
    m = of()
    record = np.array([m.record()], MATERIAL)[0]
    assert MATERIAL.names == tuple(spec.name for spec in fields(Material))
    for name in MATERIAL.names:
        np.testing.assert_allclose(record[name], getattr(m, name), rtol=1e-6)


def test_on_even_skin_an_opaque_product_shows_its_own_colour():
    m = of(red=10, green=60, blue=200)
    for luminance in (0.02, 0.2, 0.7):
        skin = even(coarse=luminance, mean=luminance)
        np.testing.assert_allclose(paint(luminance, m, skin), m.product, atol=1e-6)


def test_broad_shade_of_the_skin_stays_on_the_product():
    m = of()
    whole, half = (paint(light, m, even(coarse=light, mean=0.2)) for light in (0.2, 0.1))
    np.testing.assert_allclose(half, 0.5 * whole, rtol=0.02)  # `dark` makes the difference


@pytest.mark.parametrize("keep", [0.0, 0.5, 1.0])
def test_texture_keep_sets_how_much_texture_stays(keep):
    m = of(texture_keep=keep, green=90)
    dim, plain = paint(0.16, m), paint(0.2, m)
    np.testing.assert_allclose(dim / plain, 1 - keep * 0.2, atol=0.01)


def test_undertone_keeps_the_skins_hue_at_the_products_light():
    skin = np.array([0.4, 0.2, 0.1])
    m = of(undertone=1.0, red=120, green=120, blue=120)
    light = float(skin @ m.luminance)
    got = paint(skin, m, even(coarse=light, mean=light))
    np.testing.assert_allclose(got / got.sum(), skin / skin.sum(), atol=1e-6)
    assert got @ m.luminance == pytest.approx(np.dot(m.product, m.luminance), rel=0.03)


def test_added_light_never_falls_and_stays_below_the_ceiling():
    base = np.linspace(-0.3, 1, 50)[:, None]
    more = np.concatenate([[0], np.geomspace(1e-6, 1e6, 50)])[None]
    both = added(base, more, 1.0)
    assert both.max() <= 1 + 1e-4  # LEAST_ROOM
    assert (np.diff(both, axis=1) >= 0).all() and (np.diff(both, axis=0) > -1e-9).all()
    np.testing.assert_array_equal(both[:, 0], base[:, 0])


def test_gloss_peaks_half_way_between_light_and_viewer():
    m = of(gloss=1.0, gloss_detail=0.0)
    x, y = np.meshgrid(np.linspace(-0.9, 0.9, 41), np.linspace(-0.9, 0.9, 41))
    lobe = skin_at(0.2 + 0 * x, 0.2, x, y, DARK_ROOM, m).lobe
    row, column = np.unravel_index(lobe.argmax(), lobe.shape)
    assert (x[row, column], y[row, column]) == pytest.approx(m.half_way[:2], abs=0.05)
    assert lobe.max() == pytest.approx(1, abs=0.05) and lobe.min() < 0.1


def test_a_rough_product_has_broader_highlights():
    away = {"nx": 0.4, "ny": 0.3}
    sharp, broad = (of(gloss=1.0, gloss_roughness=r) for r in (0.0, 1.0))
    assert even(m=sharp, **away).lobe < even(m=broad, **away).lobe
    assert even(m=sharp, **away).lobe < 0.2


def test_gloss_brightens_the_skins_own_highlights():
    bare = 0.2 * 2  # twice as bright as the skin around
    shown = [paint(bare, of(gloss=g, gloss_detail=1.0)).sum() for g in (0, 0.5, 1, 4)]
    assert (np.diff(shown) > 0).all()
    matte = [paint(0.2, of(gloss=g, gloss_detail=1.0)).sum() for g in (0, 4)]
    assert matte[0] == pytest.approx(matte[1])  # no highlight to brighten


def test_reflections_come_from_where_the_mirrored_ray_points():
    room = np.zeros((3, 16, 16))
    room[:, :, 12:] = 1  # a window at the right
    m = of(reflection=1.0, environment_blur=0.0, fresnel=0.0)
    right, left = (even(nx=x, room=room, m=m).room.sum() for x in (0.4, -0.4))
    assert right > 2.9 and left < 0.1


def test_a_surface_that_turns_away_reflects_more():
    m = of(reflection=1.0, fresnel=1.0)
    assert even(nx=0.8, m=m).mirror > 2 * even(nx=0.1, m=m).mirror
    assert even(nx=0.8, m=of(fresnel=1.0)).mirror == 0


@given(st.floats(0.002, 0.05), st.floats(0.002, 0.05), st.floats(0.0, 1.0))
def test_highlights_have_much_of_the_hue_of_their_pixel(green, blue, gloss):
    """Black shows nothing else. Brown skin at the lips' border so gets no white outline."""
    bare, ones = np.array([[[0.1, green, blue]]]), np.ones((1, 1))
    coarse = float(bare[0, 0].mean()) / 4
    m = replace(of(red=0, green=0, blue=0, gloss=gloss), glint=(0, 0, 0), reflection=0.0)
    shown = made_up(bare, ones, ones, ones, even(coarse=coarse, mean=coarse, m=m), m)[0, 0]
    assert shown[0] > 0.01
    assert (shown[1:] < shown[0] * (0.4 + 0.6 * bare[0, 0, 1:] / 0.1)).all()


@given(st.floats(0, 1), st.floats(-0.7, 0.7), st.floats(-0.7, 0.7))
def test_a_furrow_dims_highlights_and_reflections_alone(exposed, nx, ny):
    room, m = np.full((3, 16, 16), 0.4), of(gloss=1.5, reflection=0.5)
    given_normals = np.full((1, 1), 0.2), 0.2, np.full((1, 1), nx), np.full((1, 1), ny), room, m
    whole, dimmed = skin_at(*given_normals), skin_at(*given_normals, exposed)
    np.testing.assert_allclose(dimmed.lobe, exposed * whole.lobe)
    np.testing.assert_allclose(dimmed.mirror, exposed * whole.mirror)
    assert (dimmed.shade, dimmed.coarse) == (whole.shade, whole.coarse)


def test_normals_facing_away_are_clamped_towards_the_viewer():
    for slope in (0.99, 1.2, 30.0):
        skin = even(nx=slope, ny=slope)
        assert skin.nx[0, 0] ** 2 + skin.ny[0, 0] ** 2 == pytest.approx(0.96)
        assert np.isfinite(skin.lobe).all() and np.isfinite(skin.mirror).all()


def test_values_between_texels_are_interpolated():
    image = np.arange(3 * ENVIRONMENT_PX**2, dtype=float).reshape(3, ENVIRONMENT_PX, -1)
    np.testing.assert_allclose(bilinear(image, np.array(2.5), np.array(3.25))[0], 3.25 * 16 + 2.5)


def sparkling(density, grid_uv=None, **given_params):
    u, v = (
        np.meshgrid(np.linspace(0, 1, 300), np.linspace(0, 1, 300)) if grid_uv is None else grid_uv
    )
    m = of(shimmer=density, **given_params)
    flat = skin_at(np.full(u.shape, 0.2), 0.2, 0 * u, 0 * u, DARK_ROOM, m)
    return sparkles(u, v, flat, m)


def test_more_shimmer_adds_sparkles_and_keeps_the_old_ones():
    few, many = sparkling(0.2), sparkling(0.8)
    assert not sparkling(0.0).any()
    assert 0 < (few > 0).sum() < (many > 0).sum()
    np.testing.assert_array_equal(few[few > 0], many[few > 0])


def test_larger_sparkles_are_fewer():
    def count(size):
        image = (sparkling(1.0, shimmer_size=size) > 0.1).astype(np.int8)
        return np.abs(np.diff(image, axis=1)).sum()

    assert count(0.0) > 2 * count(1.0)


def test_sparkles_stick_to_the_coordinates_of_the_skin():
    u, v = np.meshgrid(np.arange(200) / 128, np.arange(200) / 128)
    whole, part = sparkling(1.0, (u, v)), sparkling(1.0, (u[20:, 30:], v[20:, 30:]))
    np.testing.assert_array_equal(whole[20:, 30:], part)


def test_sparkles_come_and_go_with_the_tilt_of_the_surface():
    u, v = np.meshgrid(np.linspace(0, 1, 200), np.linspace(0, 1, 200))
    m = of(shimmer=1.0)
    first, second = [
        sparkles(u, v, skin_at(0.2 + 0 * u, 0.2, x + 0 * u, 0 * u, DARK_ROOM, m), m) > 0.1
        for x in (0.0, 0.5)
    ]
    assert first.any() and second.any() and (first & ~second).any()


def test_lashes_are_spared_where_the_material_says_so():
    lash = 0.2 * 0.15
    eyes, lips = of(spared=0.2, red=250), of(red=250)
    np.testing.assert_allclose(paint(lash, eyes), lash, atol=1e-9)
    assert paint(lash, lips)[0] > 0.1
    np.testing.assert_allclose(paint(0.2, eyes), paint(0.2, lips))


def test_a_product_darker_than_lashes_covers_them():
    lash, black = 0.2 * 0.15, {"red": 4, "green": 0, "blue": 0}
    np.testing.assert_allclose(paint(lash, of(spared=0.2, **black)), paint(lash, of(**black)))
    assert paint(lash, of(spared=0.2, **black)).max() < 0.1 * lash


def test_sparing_begins_without_a_step():
    """In small steps, from a product that darkens a lash to one twice as bright as the lash."""
    lash = 0.2 * 0.15
    greys = np.linspace(0, 90, 400)
    shown = [
        paint(lash, of(spared=0.2, texture_keep=0.0, red=grey, green=grey, blue=grey))[0]
        for grey in greys
    ]
    assert np.abs(np.diff(shown)).max() < 1e-3
    assert shown[0] < 0.1 * lash and shown[-1] == pytest.approx(lash)


def test_a_bright_crease_leaves_no_streak_where_none_is_kept():
    black = {"red": 4, "green": 0, "blue": 0}
    full, some, none = (
        paint(0.6, replace(of(**black), keep_highlights=keep)).max() for keep in (1.0, 0.5, 0.0)
    )
    assert none < 0.002 < some < full and full > 0.1


@settings(max_examples=100, deadline=None)
@given(params(gloss=0.0), lights(), places(), st.floats(0, 1), st.floats(0, 0.3))
def test_without_weight_light_stays_as_it_is(p, light, place, bare, spared):
    m = material(p, 1.0, light, place, Coding(), spared)
    np.testing.assert_allclose(paint(bare, m, weight=0.0), bare, rtol=1e-12)


@settings(max_examples=100, deadline=None)
@given(params(), lights(), places(), st.floats(-0.5, 4), st.floats(0, 4), st.floats(0, 4))
def test_light_is_finite_whatever_the_product_light_and_skin(p, light, place, bare, coarse, mean):
    m = material(p, 1.0, light, place, Coding())
    skin = even(coarse=coarse, mean=mean, nx=0.9, ny=-0.9, room=np.ones((3, 16, 16)), m=m)
    assert np.isfinite(paint(bare, m, skin)).all()
    assert np.isfinite(paint(bare, replace(m, ceiling=4.0), skin)).all()
