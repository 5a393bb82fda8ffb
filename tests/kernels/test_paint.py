"""The kernel that paints against its twin, over codings, depths, products, lights and surfaces."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from makeup import (
    FLAT,
    any_codes,
    any_surface,
    codings,
    device,
    flat_surface,
    lights,
    params,
    places,
    product,
)
from makeup_video.kernels.colour import HLG, PQ, SRGB, Coding, decode, matrices, to_xyz
from makeup_video.kernels.material import made_up, skin_at
from makeup_video.kernels.paint import paint, paint_twin
from makeup_video.pipeline.lit_product import Place, material
from makeup_video.pipeline.scene import white_light

SIZE = (37, 9)
PQ_BRIGHTEST = 10000 / 203 * 1.01  # of white, ITU-R BT.2408
FACING = Place(np.eye(2), 100.0)
cases = st.tuples(
    params(),
    st.floats(0, 1),
    lights(),
    places(),
    codings(),
    st.sampled_from((0.0, 0.12, 0.2)),
    st.integers(0, 99),
)


def made(case, **changes):
    """Codes, surface, material and coding of a case."""
    given_params, amount, light, place, coding, spared, seed = case
    brightest = 1.0 if coding.transfer == SRGB else 8.0
    surface = any_surface(seed, SIZE, place, brightest)
    lit = material(given_params, amount, light, place, coding, spared)
    return *any_codes(seed, SIZE, coding), surface, lit, coding


def painted(luma, chroma, surface, lit, coding):
    new, change = luma.copy(), chroma.copy()
    paint(device(), new, change, surface, lit, coding)
    return new, change


def on_border(surface, lit):
    """Pixels so near to the border of a sparkle's cell that float32 decides which cell it is."""
    y, x = np.mgrid[: SIZE[1], : SIZE[0]]
    at = np.einsum("ij,jhw->ihw", surface.to_patch, np.stack([x, y, np.ones_like(x)])) * lit.cells
    return (np.abs(at - np.rint(at)) < 2e-3).any(0)


def means_a_colour(luma, chroma, coding):
    """Not so of most codes: their R'G'B' is negative somewhere, and may have no luminance at all,
    or is above PQ's 10,000 cd/m2 by any factor."""
    light = decode(np.stack([luma, *chroma], axis=-1).astype(float), coding)
    top = PQ_BRIGHTEST if coding.transfer == PQ else np.inf
    inside = ((light >= 0) & (light <= top)).all(-1)
    return inside & (light @ to_xyz(coding.primaries)[1] > 0)


def stored(chroma, luma, change, coding):
    """(3, h, w): luma, and chroma as far as a code can say it."""
    return np.stack([luma, *np.clip(chroma + change, 0, coding.max_code)])


def difference(case):
    """Of kernel and twin, (3, h, w) codes; which codes mean a colour; and what a thousandth of a
    code, and a ten-thousandth of the surface's light, makes of the twin."""
    luma, chroma, surface, lit, coding = made(case)
    got = stored(chroma, *painted(luma, chroma, surface, lit, coding), coding)
    want = stored(chroma, *paint_twin(luma, chroma, surface, lit, coding), coding)
    moved = np.zeros_like(want)
    for sign in (-1, 1):
        nudged = replace(surface, maps=surface.maps.copy())
        nudged.maps[1] *= 1 + sign * 1e-4
        nudge = sign * 1e-3 * 2 ** (coding.bit_depth - 8)
        codes = luma + nudge, chroma + nudge
        other = stored(codes[1], *paint_twin(*codes, nudged, lit, coding), coding)
        moved = np.maximum(moved, np.abs(other - want))
    off = np.abs(got - want)
    if lit.shimmer:
        off[:, on_border(surface, lit)] = 0
    return off, means_a_colour(luma, chroma, coding), moved


@settings(max_examples=300, deadline=None)
@given(cases.filter(lambda case: case[0].gloss <= 4))
def test_matches_numpy_within_one_code_value(case):
    off, is_colour, _ = difference(case)
    # both round once, from different float widths
    assert off[:, is_colour].max(initial=0) <= 1 + last_bits(case[4])


def last_bits(coding):
    """PQ tells a ten-millionth of white apart beside white, which float32 loses between primaries."""
    wide = coding.transfer == PQ and coding.primaries != 1
    return 2 ** (coding.bit_depth - 5) if wide else 0  # of the darkest, beside bright ones


@settings(max_examples=200, deadline=None)
@given(cases)
def test_boundless_gloss_matches_but_for_the_last_bits(case):
    """It is a gain of thousands, for differences of light that float32 just holds."""
    off, is_colour, moved = difference(case)
    assert (off <= 1 + last_bits(case[4]) + 2 * moved)[:, is_colour].all()


@settings(max_examples=300, deadline=None)
@given(cases)
def test_everything_is_finite_for_every_parameter_and_code(case):
    luma, chroma, surface, lit, coding = made(case)
    for numbers in (painted(luma, chroma, surface, lit, coding)[1], paint_twin(*made(case))[1]):
        assert np.isfinite(numbers).all()
    assert np.isfinite(lit.argument()).all()


@settings(max_examples=60, deadline=None)
@given(cases)
def test_where_there_is_no_weight_nothing_changes(case):
    luma, chroma, surface, lit, coding = made(case)
    bare = surface.maps[0] == 0
    new, change = painted(luma, chroma, surface, lit, coding)
    np.testing.assert_array_equal(new[bare], luma[bare])
    assert not change[:, bare].any()


@settings(max_examples=60, deadline=None)
@given(params(opacity=0.0, gloss=0.0, reflection=0.0), codings(), st.integers(0, 99))
def test_a_product_that_is_not_worn_gives_the_codes_back(bare, coding, seed):
    luma, chroma = any_codes(seed, SIZE, coding)
    if coding.transfer == PQ:  # beyond 1.25 it is cut
        luma, chroma = luma[1:6], chroma[:, 1:6]
    luma, chroma = luma.copy(), chroma.copy()
    surface = any_surface(seed, luma.shape[::-1], FACING, 1.0)
    lit = material(bare, 1.0, white_light(), FACING, coding)
    new, change = painted(luma, chroma, surface, lit, coding)
    np.testing.assert_array_equal(new, luma)
    assert np.abs(change).max() < 0.5  # rounds to nothing


@settings(max_examples=60, deadline=None)
@given(cases, st.integers(0, 999))
def test_rows_of_a_plane_may_have_gaps_which_are_left_alone(case, filler):
    luma, chroma, surface, lit, coding = made(case)
    whole = np.full((SIZE[1] + 2, SIZE[0] + 5), filler % 200, luma.dtype)
    window = whole[1:-1, 2:-3]
    window[:] = luma
    want, change = painted(luma, chroma, surface, lit, coding)
    paint(device(), window, chroma, surface, lit, coding)
    np.testing.assert_array_equal(window, want)
    np.testing.assert_array_equal(chroma, change)
    window[:] = filler % 200
    assert (whole == filler % 200).all()


@pytest.mark.parametrize("size", [(1, 1), (7, 5), (64, 2), (65, 3)])
def test_any_size_is_painted_to_its_last_pixel(size):
    coding = Coding()
    luma = np.full(size[::-1], 120, np.uint8)
    chroma = np.full((2, *luma.shape), 128, np.float32)
    lit = material(product(red=20, green=40, blue=200), 1, white_light(), FACING, coding)
    new, change = painted(luma, chroma, flat_surface(size, 0.2), lit, coding)
    assert (new != 120).all() and (change != 0).all()
    assert len(np.unique(new)) == 1


@settings(max_examples=60, deadline=None)
@given(params(**FLAT), lights(), codings(), st.integers(0, 99))
def test_more_opacity_moves_every_channel_monotonically_to_the_laid_colour(p, light, coding, seed):
    luma, chroma = any_codes(seed, SIZE, coding)
    surface = any_surface(seed, SIZE, FACING, 1.0 if coding.transfer == SRGB else 8.0)
    surface.maps[0] = 1
    products = [
        material(replace(p, opacity=opacity), 1.0, light, FACING, coding)
        for opacity in (0.0, 0.2, 0.5, 0.8, 1.0)
    ]
    to_film = np.array(products[0].to_film).reshape(3, 3).T  # in sRGB's primaries
    off = np.stack([laid_light(luma, chroma, surface, lit, coding) @ to_film for lit in products])
    off = np.abs(off - off[-1])
    assert (np.diff(off, axis=0) <= 1e-9 + 1e-6 * off[:-1]).all()
    # Of codes this holds where they say the same light: not so in HLG, where more of one channel
    # makes others fall, and in other primaries.
    if coding.transfer == HLG or coding.primaries != 1:
        return
    skin = slice(2, 6)  # rows whose codes are certain to mean colours
    shown, clipped = [], np.zeros((len(off[0][skin]), SIZE[0]), bool)
    for lit in products:
        new, change = painted(luma, chroma, surface, lit, coding)
        codes = np.stack([new, *(chroma + change)], axis=-1)[skin].astype(float)
        clipped |= (codes[..., 0] == coding.max_code) | (codes[..., 0] == 0)
        shown.append(codes @ matrices(coding)[0][:, :3].T)
    luma_code = matrices(coding)[0][0, 0]  # as R'G'B'; each luma is off by half of it
    off = np.abs(np.stack(shown) - shown[-1]) / luma_code
    assert np.minimum(np.diff(off, axis=0), off[1:])[:, ~clipped].max(initial=0) <= 1.01


def laid_light(luma, chroma, surface, lit, coding):
    """Linear light that the twin paints, before it is encoded."""
    codes = np.stack([luma, *chroma], axis=-1).astype(float)
    weight, coarse, nx, ny = surface.maps.astype(np.float64)
    skin = skin_at(coarse, surface.mean, nx, ny, surface.environment.astype(float), lit)
    y, x = np.mgrid[: luma.shape[0], : luma.shape[1]]
    return made_up(decode(codes, coding), weight, x * 0.01, y * 0.01, skin, lit)
