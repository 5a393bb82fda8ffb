"""Light read from planes, and blurred within a region."""

import numpy as np
import pytest
from hypothesis import given, settings
from makeup import LAYOUTS, codings, tagged
from makeup_video.kernels.colour import Coding, decode, to_xyz
from makeup_video.pipeline.frames.colour_tags import ColourTags
from makeup_video.pipeline.frames.frame import coding_of
from makeup_video.pipeline.render.grid import Grid
from makeup_video.pipeline.render.luminance_twin import broad, linear_luminance, luminances
from people import frame_of

RAMP = np.repeat(np.linspace(30, 220, 64).astype(np.uint8)[None, :, None], 48, 0).repeat(3, 2)


def square(x, y, step=1.0, size_wh=(8, 6)):
    return Grid(np.array([[step, 0, x], [0, step, y]]), size_wh)


@settings(max_examples=60, deadline=None)
@given(codings())
def test_luminance_is_that_of_the_decoded_light(coding):
    rng = np.random.default_rng(3)
    unit = 2 ** (coding.bit_depth - 8)
    codes = np.array([140, 118, 146])[:, None] * unit + rng.normal(0, 12 * unit, (3, 200))
    light = decode(codes.T, coding)
    in_range = (light > 0).all(1) & (light.max(1) < 0.9)  # the table ends at R'G'B' of 0 and of 1
    got, want = linear_luminance(codes, coding), light @ to_xyz(coding.primaries)[1]
    if coding.transfer == 18:
        return  # HLG's display gain uses BT.2020's luminance: see the next test
    np.testing.assert_allclose(got[in_range], want[in_range], rtol=0.03, atol=2e-3)


def test_the_light_of_hlg_is_that_of_its_display():
    coding = Coding(9, False, 18, 9, 10)
    codes = np.array([[200, 400, 600, 721], [512] * 4, [512] * 4], float)
    want = decode(codes.T, coding) @ to_xyz(9)[1]
    np.testing.assert_allclose(linear_luminance(codes, coding), want, rtol=0.01)


@pytest.mark.parametrize("pix_fmt", LAYOUTS)
def test_every_layout_gives_the_same_light(pix_fmt):
    frame = frame_of(RAMP, pix_fmt=pix_fmt)
    (got,) = luminances(frame, coding_of(frame), [square(20, 10, 2)])
    reference = frame_of(RAMP, pix_fmt="yuv444p")
    (want,) = luminances(reference, coding_of(reference), [square(20, 10, 2)])
    assert got.shape == (6, 8) and got.dtype == np.float32
    np.testing.assert_allclose(got, want, rtol=0.05, atol=0.003)
    assert (np.diff(got, axis=1) > 0).all()


def test_a_grey_frame_has_light_too():
    frame = frame_of(RAMP, pix_fmt="gray")
    frame = tagged(frame, ColourTags(1, 2, 1, 1))
    (got,) = luminances(frame, coding_of(frame), [square(20, 10)])
    want = decode(np.array([frame.planes[0][10, 20], 128, 128.0]), coding_of(frame))
    assert got[0, 0] == pytest.approx(want[1], rel=0.02)


def test_grids_are_read_apart_and_outside_repeats_the_border():
    frame = frame_of(RAMP)
    grids = [square(4, 4), square(-300, 10, size_wh=(5, 3)), square(500, 10, size_wh=(2, 9))]
    parts = luminances(frame, coding_of(frame), grids)
    assert [part.shape for part in parts] == [(6, 8), (3, 5), (9, 2)]
    assert parts[1].max() < parts[0].min() + 1e-3 and parts[2].min() > parts[0].max()
    for part, grid in zip(parts, grids, strict=True):
        (single,) = luminances(frame, coding_of(frame), [grid])
        np.testing.assert_array_equal(part, single)


def test_the_step_of_a_grid_is_that_of_its_pixels():
    assert square(0, 0, 2.5).step_px() == pytest.approx(2.5)
    assert square(3, 7, 2).places()[:, 9].tolist() == [5, 9]


def test_broad_light_drops_texture_and_stops_at_the_border():
    light = np.full((40, 60), 0.2, np.float32)
    light[::2, ::2] = 0.3
    light[:, 30:] = 0.9  # beside the region
    area = np.zeros(light.shape, bool)
    area[5:35, 5:30] = True
    (shading,), mean = broad(light, [area], 2.5)
    assert mean == pytest.approx(0.225, abs=0.003)
    np.testing.assert_allclose(shading[8:32, 8:28], 0.225, atol=0.01)


def test_two_areas_are_blurred_apart_and_have_one_mean():
    light = np.full((40, 60), 0.1, np.float32)
    light[:, 30:] = 0.5
    areas = [np.zeros(light.shape, bool) for _ in range(2)]
    areas[0][:, 10:30], areas[1][:, 30:50] = True, True
    (first, second), mean = broad(light, areas, 2.5)
    assert mean == pytest.approx(0.3)
    assert first[20, 29] == pytest.approx(0.1, abs=0.01)
    assert second[20, 30] == pytest.approx(0.5, abs=0.02)


def test_without_any_region_everything_counts():
    light = np.linspace(0, 1, 200, dtype=np.float32).reshape(10, 20)
    (shading,), mean = broad(light, [np.zeros(light.shape, bool)], 2.5)
    assert mean == pytest.approx(0.5)
    assert np.isfinite(shading).all() and shading == pytest.approx(0.5, abs=1e-4)


def test_without_any_region_only_what_was_read_counts():
    light = np.tile(np.arange(20, dtype=np.float32), (10, 1))
    _, mean = broad(light, [np.zeros(light.shape, bool)], 2.5, slice(8, 16))
    assert mean == pytest.approx(11.5)
