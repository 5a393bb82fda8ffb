"""Products that vary over a region: the kernel's variant against its numpy twin."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from makeup import (
    any_codes,
    any_surface,
    codings,
    lights,
    paint_codes,
    paint_on,
    params,
    places,
    product,
    white_light,
)
from makeup_video.kernels.colour import PQ, SRGB, Coding
from makeup_video.kernels.paint import LAYERS
from makeup_video.kernels.paint_twin import Layers, paint_twin, region_twin
from makeup_video.kernels.planes import Rect
from makeup_video.kernels.program import Device
from makeup_video.pipeline.render.product_twin import SkinAxes, material

SIZE = (37, 9)
FACING = SkinAxes(np.eye(2), 700.0)
SIDE = Rect(0, 0, 40, 12)


def any_layers(seed, hw, m):
    """Layers whose shares vary wildly from one px of the grid to the next, with glints of up to
    twice the material's."""
    rng = np.random.default_rng(seed)
    count = rng.integers(1, LAYERS + 1)
    numbers = rng.uniform(0, 1, (count, 8))
    numbers[:, :3] *= numbers[:, 3:4]
    numbers[:, 4:7] *= 2 * np.array(m.glint)
    shares = rng.uniform(0, 1, (count, *hw))
    shares /= np.maximum(shares.sum(0), 1)
    return Layers(shares.astype(np.float32), numbers.tolist(), rng.uniform(0, 1, 3).tolist())


def even_layers(hw, m):
    root = np.sqrt(np.maximum(m.product, 0))
    numbers = [*(m.opacity * root), m.opacity, *m.glint, 1.0]
    return Layers(np.ones((1, *hw), np.float32), [numbers], root.tolist())


@settings(max_examples=200, deadline=None)
@given(
    params(gloss=1.0, shimmer=0.0), lights(), places(),
    codings(transfers=(SRGB,)), st.sampled_from((0.0, 0.2)), st.integers(0, 99),
)  # fmt: skip
def test_matches_numpy_within_one_code_value(p, light, place, coding, spared, seed):
    luma, chroma = any_codes(seed, SIZE, coding)
    luma, chroma = luma[1:6].copy(), chroma[:, 1:6].copy()  # rows whose codes mean colours
    surface = any_surface(seed, luma.shape[::-1], place, 1.0)
    lit = material(p, 1.0, light, place, coding, spared)
    varied = replace(surface, material=lit, layers=any_layers(seed, surface.shading.shape, lit))
    got = paint_codes(luma, chroma, varied, lit, coding)
    new, change = region_twin(luma, chroma, varied, coding)
    want = np.stack([new, *np.clip(chroma + change, 0, coding.max_code)])
    assert np.abs(got - want).max() <= 1  # both round once, but from floats of different widths


@settings(max_examples=100, deadline=None)
@given(params(), lights(), codings(transfers=(SRGB, PQ)), st.integers(0, 99))
def test_even_layers_paint_the_bytes_of_no_layers(p, light, coding, seed):
    luma, chroma = any_codes(seed, SIZE, coding)
    surface = any_surface(seed, SIZE, FACING, 1.0)
    lit = material(p, 1.0, light, FACING, coding)
    alone = paint_codes(luma, chroma, surface, lit, coding)
    varied = replace(surface, layers=even_layers(surface.shading.shape, lit))
    layers = paint_codes(luma, chroma, varied, lit, coding)
    # interpolating four equal numbers may lose the last bit, which boundless gloss enlarges
    assert (np.abs(alone - layers) <= (1 if p.gloss <= 4 else coding.max_code))[:, 2:6].all()


def test_shine_dims_everything_that_shines():
    luma, chroma = any_codes(1, SIZE, Coding())
    luma, chroma = luma[2:6].copy(), chroma[:, 2:6].copy()
    surface = any_surface(1, luma.shape[::-1], FACING, 0.5)
    shiny = material(
        product(gloss=1.0, gloss_detail=1.0, reflection=1.0, shimmer=1.0), 1, white_light(),
        FACING, Coding(),
    )  # fmt: skip
    dull = replace(shiny, own_highlights=0.0, reflection=0.0, shimmer=0.0)
    none = even_layers(surface.shading.shape, shiny)
    none.numbers[0][7] = 0
    got = paint_codes(luma, chroma, replace(surface, layers=none), shiny, Coding())
    want = paint_codes(luma, chroma, surface, dull, Coding())
    assert np.abs(got - want).max() <= 1
    assert np.abs(got - paint_codes(luma, chroma, surface, shiny, Coding())).max() > 10


def mixed_regions(coding, kinds):
    """Regions, one below the other; kinds: for each region, whether it has layers."""
    regions = []
    for number, has_layers in enumerate(kinds):
        lit = material(product(red=60 * number, gloss=0.5), 1, white_light(), FACING, coding)
        surface = any_surface(2 * number, (SIDE.width, SIDE.height), FACING, 0.6)
        layers = any_layers(number, surface.shading.shape, lit) if has_layers else None
        rect = Rect(0, SIDE.height * number, SIDE.width, SIDE.height)
        regions.append(replace(surface, rect=rect, material=lit, layers=layers))
    return regions


def skin_planes(count):
    rng = np.random.default_rng(5)
    high, wide = SIDE.height * count, SIDE.width
    return tuple(
        rng.normal(mean, 6, (high // down, wide // down)).astype(np.uint8)
        for mean, down in ((150, 1), (112, 2), (150, 2))
    )


@pytest.mark.parametrize("kinds", [(0, 1, 0, 1), (1, 0), (1, 1, 1), (0, 0, 1)], ids=str)
def test_regions_with_and_without_layers_share_a_canvas(kinds):
    coding, block = Coding(), (2, 2)
    regions, planes = mixed_regions(coding, kinds), skin_planes(len(kinds))
    want = paint_twin(planes, regions, coding, block)
    alone = tuple(plane.copy() for plane in planes)
    paint_on(planes, regions, coding, block)
    for got, expected in zip(planes, want, strict=True):
        assert np.abs(got.astype(int) - expected).max() <= 1
    for region in regions:
        paint_on(alone, [region], coding, block)
    for got, expected in zip(planes, alone, strict=True):
        np.testing.assert_array_equal(got, expected)


@pytest.mark.parametrize("kinds", [(0, 0), (1, 0), (0, 1, 0), (1, 1)], ids=str)
@pytest.mark.parametrize("block", [(2, 2), (1, 1)], ids=str)
def test_coats_on_the_same_rectangle_lie_over_each_other(kinds, block):
    """Like coats painted one after another, but each pixel keeps its own chroma in between."""
    coding, beside = Coding(), mixed_regions(Coding(), (0, 1, 0))
    rect = beside[1].rect
    over = [replace(one, rect=rect) for one in mixed_regions(coding, kinds)]
    regions = [beside[0], *over, beside[2]]
    planes = skin_planes(3)
    planes = planes[0], *(plane.repeat(2 // block[1], 0).repeat(2 // block[0], 1)
                          for plane in planes[1:])  # fmt: skip
    want, alone = (tuple(plane.copy() for plane in planes) for _ in range(2))
    want = paint_twin(want, regions, coding, block)
    paint_on(planes, regions, coding, block)
    for region in regions:
        paint_on(alone, [region], coding, block)
    for got, expected, one_by_one in zip(planes, want, alone, strict=True):
        off = np.abs(got.astype(int) - expected)
        # where a coat below is rounded differently, the coat above may enlarge the difference
        assert off.max() <= 3 and (off > 1).sum() <= 3
        if block == (1, 1):
            assert np.abs(got.astype(int) - one_by_one).max() <= len(kinds)


def test_only_the_runs_of_a_coat_are_painted_by_it():
    """A coat over a part of a rectangle leaves the bytes of the coat below as they were."""
    coding = Coding()
    below, above = (replace(one, rect=SIDE) for one in mixed_regions(coding, (0, 0)))
    weight = above.weight.copy()
    weight[:, SIDE.width // 2 :] = 0
    once, twice = skin_planes(1), skin_planes(1)
    paint_on(once, [below], coding, (2, 2))
    paint_on(twice, [below, replace(above, weight=weight)], coding, (2, 2))
    for one, two, across in zip(once, twice, (1, 2, 2), strict=True):
        kept = np.s_[:, SIDE.width // 2 // across :]
        np.testing.assert_array_equal(one[kept], two[kept])
        assert (one != two).any()


def test_a_canvas_forgets_layers_of_the_frame_before():
    coding = Coding()
    painted = []
    for before in ((), (1, 1, 1)):
        if before:
            paint_on(skin_planes(3), mixed_regions(coding, before), coding, (2, 2))
        planes = skin_planes(2)
        paint_on(planes, mixed_regions(coding, (0, 0)), coding, (2, 2))
        painted.append(planes)
    for left, right in zip(*painted, strict=True):
        np.testing.assert_array_equal(left, right)


@pytest.mark.parametrize(("kinds", "launches"), [((0, 0), 3), ((1, 1), 3), ((0, 1), 4)], ids=str)
def test_only_frames_with_both_kinds_start_a_kernel_more(kinds, launches, monkeypatch):
    started = []
    launch = Device.launch

    def counted(self, *arguments):
        started.append(1)
        return launch(self, *arguments)

    monkeypatch.setattr(Device, "launch", counted)
    paint_on(skin_planes(2), mixed_regions(Coding(), kinds), Coding(), (2, 2))
    assert len(started) == launches
