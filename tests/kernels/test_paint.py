"""The painting kernel against its numpy twin, for any coding, depth, product, light and surface."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from makeup import (
    FLAT,
    any_codes,
    any_surface,
    canvas,
    codings,
    flat_surface,
    lights,
    paint_codes,
    paint_on,
    params,
    places,
    product,
    white_light,
)
from makeup_video.kernels.colour import HLG, PQ, SRGB, Coding, decode, matrices, to_xyz
from makeup_video.kernels.material_twin import made_up, skin_at
from makeup_video.kernels.paint import Canvas
from makeup_video.kernels.paint_twin import on_pixels, paint_twin, region_twin
from makeup_video.kernels.planes import Rect
from makeup_video.kernels.program import Device
from makeup_video.pipeline.render.product_twin import SkinAxes, material

SIZE = (37, 9)
PQ_BRIGHTEST = 10000 / 203 * 1.01  # of white, ITU-R BT.2408
FACING = SkinAxes(np.eye(2), 100.0)
cases = st.tuples(
    params(),
    st.floats(0, 1),
    lights(),
    places(),
    codings(),
    st.sampled_from((0.0, 0.12, 0.2)),
    st.integers(0, 99),
)


def unpack_case(case):
    """(luma, chroma, surface, material, coding) of a case."""
    given_params, amount, light, place, coding, spared, seed = case
    brightest = 1.0 if coding.transfer == SRGB else 8.0
    surface = any_surface(seed, SIZE, place, brightest)
    lit = material(given_params, amount, light, place, coding, spared)
    return *any_codes(seed, SIZE, coding), surface, lit, coding


def twin(luma, chroma, surface, lit, coding):
    """(3, h, w): rounded luma and unrounded chroma, clipped to the range of codes."""
    new, change = region_twin(luma, chroma, replace(surface, material=lit), coding)
    return np.stack([new, *np.clip(chroma + change, 0, coding.max_code)])


def on_border(surface, lit):
    """Pixels so close to the border of a sparkle's cell that float32 rounding picks the cell."""
    y, x = np.mgrid[: SIZE[1], : SIZE[0]]
    to_patch = np.reshape(surface.to_patch, (2, 3))
    cell = np.einsum("ij,jhw->ihw", to_patch, np.stack([x, y, np.ones_like(x)])) * lit.cells
    return (np.abs(cell - np.rint(cell)) < 2e-3).any(0)


def means_a_colour(luma, chroma, coding):
    """Whether codes mean a real colour. Most codes do not: a channel of their R'G'B' is negative,
    the luminance may vanish, or the light is far above PQ's 10,000 cd/m2."""
    light = decode(np.stack([luma, *chroma], axis=-1).astype(float), coding)
    top = PQ_BRIGHTEST if coding.transfer == PQ else np.inf
    inside = ((light >= 0) & (light <= top)).all(-1)
    return inside & (light @ to_xyz(coding.primaries)[1] > 0)


def difference(case):
    """The difference of kernel and twin, (3, h, w) codes; which codes mean a colour; and the
    twin's response to a thousandth of a code and a ten-thousandth of the surface's light."""
    luma, chroma, surface, lit, coding = unpack_case(case)
    got = paint_codes(luma, chroma, surface, lit, coding)
    want = twin(luma, chroma, surface, lit, coding)
    moved = np.zeros_like(want)
    for sign in (-1, 1):
        nudged = replace(surface, shading=surface.shading * np.float32(1 + sign * 1e-4))
        nudge = sign * 1e-3 * 2 ** (coding.bit_depth - 8)
        other = twin(luma + nudge, chroma + nudge, nudged, lit, coding)
        moved = np.maximum(moved, np.abs(other - want))
    off = np.abs(got - want)
    if lit.shimmer:
        off[:, on_border(surface, lit)] = 0
    return off, means_a_colour(luma, chroma, coding), moved


@settings(max_examples=300, deadline=None)
@given(cases.filter(lambda case: case[0].gloss <= 4))
def test_matches_numpy_within_one_code_value(case):
    off, is_colour, _ = difference(case)
    # both round once, but from floats of different widths
    assert off[:, is_colour].max(initial=0) <= 1 + last_bits(case[4])


def last_bits(coding):
    """Tolerance in codes. PQ resolves a ten-millionth of white beside white; float32 loses so
    little light in the conversion of primaries."""
    wide = coding.transfer == PQ and coding.primaries != 1
    return 2 ** (coding.bit_depth - 5) if wide else 0  # for the darkest channel beside bright ones


@settings(max_examples=200, deadline=None)
@given(cases)
def test_boundless_gloss_matches_but_for_the_last_bits(case):
    """Such gloss is a gain of thousands on differences of light that float32 barely resolves."""
    off, is_colour, moved = difference(case)
    assert (off <= 1 + last_bits(case[4]) + 4 * moved)[:, is_colour].all()


@settings(max_examples=300, deadline=None)
@given(cases)
def test_everything_is_finite_for_every_parameter_and_code(case):
    luma, chroma, surface, lit, coding = unpack_case(case)
    paint_codes(luma, chroma, surface, lit, coding)
    for codes in canvas()._codes.array:  # before rounding
        assert np.isfinite(codes[: SIZE[1], : SIZE[0]][surface.weight > 0]).all()
    assert np.isfinite(twin(luma, chroma, surface, lit, coding)).all()
    assert np.isfinite(np.hstack(lit.record())).all()


@settings(max_examples=60, deadline=None)
@given(cases)
def test_where_there_is_no_weight_nothing_changes(case):
    luma, chroma, surface, lit, coding = unpack_case(case)
    bare = surface.weight == 0
    new = paint_codes(luma, chroma, surface, lit, coding)
    np.testing.assert_array_equal(new[0, bare], luma[bare])
    np.testing.assert_array_equal(new[1:, bare], chroma[:, bare])


@settings(max_examples=60, deadline=None)
@given(params(opacity=0.0, gloss=0.0, reflection=0.0), codings(), st.integers(0, 99))
def test_a_product_without_effect_gives_the_codes_back(bare, coding, seed):
    luma, chroma = any_codes(seed, SIZE, coding)
    if coding.transfer == PQ:  # rows without encoded values above 1.25, which are clipped
        luma, chroma = luma[1:6], chroma[:, 1:6]
    luma, chroma = luma.copy(), chroma.copy()
    surface = any_surface(seed, luma.shape[::-1], FACING, 1.0)
    lit = material(bare, 1.0, white_light(), FACING, coding)
    new = paint_codes(luma, chroma, surface, lit, coding)
    np.testing.assert_array_equal(new, [luma, *chroma])


def planes_around(rects, block, depth, interleaved, seed):
    """Planes of random codes that contain the rects."""
    width, height = (max(ends) + 3 for ends in zip(*((w.x + w.width, w.y + w.height) for w in rects), strict=True))  # fmt: skip
    rng = np.random.default_rng(seed)
    dtype, top = (np.uint8, 256) if depth == 8 else (np.uint16, 1024)
    small = -(-height // block[1]), -(-width // block[0])
    # rows with gaps
    luma = rng.integers(0, top, (height, width + 5)).astype(dtype)[:, :width]
    if interleaved:
        return luma, rng.integers(0, top, (*small, 2)).astype(dtype)
    return luma, *rng.integers(0, top, (2, small[0], small[1] + 3)).astype(dtype)[..., : small[1]]


@settings(max_examples=60, deadline=None)
@given(
    cases.filter(lambda case: case[0].gloss <= 4),
    st.sampled_from([((1, 1), False), ((2, 1), False), ((2, 2), False), ((2, 2), True),
                     ((4, 1), False), ((1, 2), False), ((4, 4), False)]),
    st.lists(st.tuples(st.integers(1, 90), st.integers(1, 40)), min_size=1, max_size=4),
)  # fmt: skip
def test_rects_of_any_layout_are_painted_together_as_the_twin(case, layout, sizes):
    *_, lit, coding = unpack_case(case)
    block, interleaved = layout
    surfaces, y = [], 0
    for number, (width, height) in enumerate(sizes):
        surface = any_surface(number, (width, height), FACING, 0.5)
        rect = Rect(4 * number, y, width, height)
        surfaces.append(replace(surface, rect=rect, material=replace(lit, shimmer=0)))
        y += -(-height // 4) * 4
    planes = planes_around(
        [surface.rect for surface in surfaces], block, coding.bit_depth, interleaved, 1
    )
    for plane in planes:  # ordinary colours only: other tests cover the rest
        plane[:] = (plane // 8 + 110 / 256 * 2**coding.bit_depth).astype(plane.dtype)
    want = paint_twin(planes, surfaces, coding, block)
    bare = [plane.copy() for plane in planes]
    paint_on(planes, surfaces, coding, block)
    for got, twin_s, before in zip(planes, want, bare, strict=True):
        assert np.abs(got.astype(int) - twin_s).max() <= 1 + last_bits(coding)
        across, down = block if got is not planes[0] else (1, 1)
        beside = np.ones(got.shape[:2], bool)
        for surface in surfaces:
            x, y, rect = surface.rect.x, surface.rect.y, surface.rect
            rows = slice(y // down, -(-(y + rect.height) // down))
            beside[rows, x // across : -(-(x + rect.width) // across)] = False
        assert (got[beside] == before[beside]).all()


def test_rows_of_a_plane_may_have_gaps_which_are_left_alone():
    whole = [np.full((14, 50), 7, np.uint8) for _ in range(3)]
    planes = tuple(plane[1:-1, 2:-3] for plane in whole)
    surface = replace(flat_surface((20, 6), 0.2), rect=Rect(10, 4, 20, 6))
    lit = material(product(), 1, white_light(), FACING, Coding())
    paint_on(planes, [replace(surface, material=lit)], Coding(), (1, 1))
    for plane in whole:
        assert (plane[5:11, 12:32] != 7).all()
        plane[5:11, 12:32] = 7
        assert (plane == 7).all()


def test_a_block_across_the_edge_takes_the_mean_of_its_inside():
    coding, block = Coding(), (2, 2)
    planes = (np.full((5, 7), 120, np.uint8), *np.full((2, 3, 4), 128, np.uint8))
    lit = material(product(red=20, green=40, blue=200), 1, white_light(), FACING, coding)
    paint_on(planes, [replace(flat_surface((7, 5), 0.2), material=lit)], coding, block)
    for plane in planes:
        assert len(np.unique(plane)) == 1 and plane[0, 0] not in (120, 128)


@pytest.mark.parametrize("size", [(1, 1), (7, 5), (64, 2), (65, 3), (300, 130)])
def test_any_size_is_painted_to_its_last_pixel(size):
    coding = Coding()
    luma = np.full(size[::-1], 120, np.uint8)
    chroma = np.full((2, *luma.shape), 128, np.float32)
    lit = material(product(red=20, green=40, blue=200), 1, white_light(), FACING, coding)
    new = paint_codes(luma, chroma, flat_surface(size, 0.2), lit, coding)
    assert (new[0] != 120).all() and (new[1:] != 128).all()
    assert len(np.unique(new[0])) == 1


def test_a_region_without_weight_paints_nothing():
    planes = tuple(np.full((8, 8), 9, np.uint8) for _ in range(3))
    lit = material(product(), 1, white_light(), FACING, Coding())
    paint_on(planes, [replace(flat_surface((8, 8), 0.2, 0.0), material=lit)], Coding(), (1, 1))
    assert all((plane == 9).all() for plane in planes)


def test_buffers_grow_when_more_regions_are_painted():
    """First few, then many regions on one canvas, each with its own product."""
    coding, size = Coding(), (9, 4)
    surfaces = []
    for number in range(40):
        lit = material(product(red=6 * number), 1, white_light(), FACING, coding)
        rect = Rect(0, 4 * number, *size)
        surfaces.append(replace(flat_surface(size, 0.2), rect=rect, material=lit))
    planes = tuple(np.full((160, 9), 120, np.uint8) for _ in range(3))
    want = paint_twin(planes, surfaces, coding, (1, 1))
    paint_on(planes, surfaces, coding, (1, 1))
    for got, expected in zip(planes, want, strict=True):
        assert np.abs(got.astype(int) - expected).max() <= 1
    assert len(np.unique(planes[2][::4, 0])) > 10


def test_a_device_with_memory_of_its_own_paints_the_same(monkeypatch):
    coding, surface = Coding(), any_surface(3, (50, 20), FACING, 0.5)
    lit = material(product(gloss=1), 1, white_light(), FACING, coding)
    surfaces = [replace(surface, material=lit)]
    painted = []
    for shares in (True, False):
        own = Canvas(Device())
        own.device.shares_memory = shares
        monkeypatch.setattr("makeup.canvas", lambda own=own: own)
        planes = planes_around([surface.rect], (2, 2), 8, False, 4)
        paint_on(planes, surfaces, coding, (2, 2))
        painted.append(planes)
    for left, right in zip(*painted, strict=True):
        np.testing.assert_array_equal(left, right)


@settings(max_examples=60, deadline=None)
@given(params(**FLAT), lights(), codings(), st.integers(0, 99))
def test_more_opacity_moves_every_channel_to_the_laid_colour(p, light, coding, seed):
    luma, chroma = any_codes(seed, SIZE, coding)
    surface = any_surface(seed, SIZE, FACING, 1.0 if coding.transfer == SRGB else 8.0)
    surface.weight[:] = 1
    products = [
        material(replace(p, opacity=opacity), 1.0, light, FACING, coding)
        for opacity in (0.0, 0.2, 0.5, 0.8, 1.0)
    ]
    to_film = np.array(products[0].to_film).reshape(3, 3).T  # in sRGB's primaries
    off = np.stack([laid_light(luma, chroma, surface, lit, coding) @ to_film for lit in products])
    off = np.abs(off - off[-1])
    assert (np.diff(off, axis=0) <= 1e-9 + 1e-6 * off[:-1]).all()
    # The same holds for codes only if a channel's code depends on that channel's light alone. In
    # HLG and in other primaries, more of one channel lowers the others.
    if coding.transfer == HLG or coding.primaries != 1:
        return
    skin = slice(2, 6)  # rows whose codes always mean colours
    shown, clipped = [], np.zeros((len(off[0][skin]), SIZE[0]), bool)
    for lit in products:
        new = paint_codes(luma, chroma, surface, lit, coding)[0]
        unrounded = canvas()._codes.array[:, : SIZE[1], : SIZE[0]]
        unrounded = np.where(surface.weight > 0, unrounded, chroma)
        codes = np.stack([new, *unrounded], axis=-1)[skin].astype(float)
        clipped |= (codes[..., 0] == coding.max_code) | (codes[..., 0] == 0)
        shown.append(codes @ matrices(coding)[0][:, :3].T)
    # one code of luma, in R'G'B'; rounding puts each luma off by half of that
    luma_code = matrices(coding)[0][0, 0]
    off = np.abs(np.stack(shown) - shown[-1]) / luma_code
    assert np.minimum(np.diff(off, axis=0), off[1:])[:, ~clipped].max(initial=0) <= 1.01


def laid_light(luma, chroma, surface, lit, coding):
    """The linear light that the twin paints, before encoding."""
    codes = np.stack([luma, *chroma], axis=-1).astype(float)
    coarse, nx, ny, *exposed = on_pixels(surface)
    skin = skin_at(coarse, surface.mean, nx, ny, surface.environment.linear(), lit, *exposed)
    y, x = np.mgrid[: luma.shape[0], : luma.shape[1]]
    weight = surface.weight.astype(float)
    return made_up(decode(codes, coding), weight, x * 0.01, y * 0.01, skin, lit)
