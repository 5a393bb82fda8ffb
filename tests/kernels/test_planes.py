"""Rectangles of planes, chroma upsampled to pixels, and its change averaged back."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from makeup_video.kernels.planes import Rect, fold, spread

SUBSAMPLINGS = [(1, 1), (2, 1), (2, 2), (4, 1), (1, 2)]
WINDOW_SIZES = st.tuples(st.integers(1, 13), st.integers(1, 11))


def planes_of(size_wh, chroma, interleaved=False):
    (width, height), (across, down) = size_wh, chroma
    rng = np.random.default_rng(1)
    small = -(-height // down), -(-width // across)
    luma = rng.integers(0, 256, (height, width)).astype(np.uint8)
    both = rng.integers(0, 256, (*small, 2)).astype(np.uint8)
    if interleaved:
        return luma, both
    return luma, both[..., 0].copy(), both[..., 1].copy()


@given(
    st.sampled_from(SUBSAMPLINGS),
    WINDOW_SIZES,
    st.tuples(*[st.floats(-20, 30)] * 4),
)
def test_a_rect_holds_its_pixels_and_ends_on_whole_blocks(chroma, size, ends):
    low, high = zip(*map(sorted, zip(ends[:2], ends[2:], strict=True)), strict=True)
    rect = Rect.around(low, high, size, chroma)
    is_inside = [
        (x, y) for y in range(size[1]) for x in range(size[0])
        if low[0] <= x <= high[0] and low[1] <= y <= high[1]
    ]  # fmt: skip
    if rect is None:
        assert not is_inside
        return
    assert rect.x % chroma[0] == 0 and rect.y % chroma[1] == 0
    for start, extent, size_px, block in (
        (rect.x, rect.width, size[0], chroma[0]),
        (rect.y, rect.height, size[1], chroma[1]),
    ):
        assert start >= 0 and extent > 0 and start + extent <= size_px
        assert (start + extent) % block == 0 or start + extent == size_px
    for x, y in is_inside:
        assert 0 <= x - rect.x < rect.width and 0 <= y - rect.y < rect.height


@given(
    st.lists(st.tuples(*[st.integers(0, 9)] * 2, *[st.integers(1, 6)] * 2), min_size=2, max_size=2)
)
def test_rects_that_share_a_pixel_overlap(boxes):
    first, second = (Rect(*box) for box in boxes)
    masks = np.zeros((2, 16, 16), bool)
    for layer, rect in zip(masks, (first, second), strict=True):
        layer[rect.y : rect.y + rect.height, rect.x : rect.x + rect.width] = True
    assert first.overlaps(second) == second.overlaps(first) == (masks[0] & masks[1]).any()


@pytest.mark.parametrize("ends", [((-9, -9), (-3, 5)), ((20, 2), (30, 5)), ((2, 40), (5, 50))])
def test_there_is_no_rect_where_all_is_outside(ends):
    assert Rect.around(*ends, (16, 9), (2, 2)) is None


@pytest.mark.parametrize("chroma", SUBSAMPLINGS)
@pytest.mark.parametrize("interleaved", [False, True])
def test_views_share_the_memory_of_the_planes(chroma, interleaved):
    planes = planes_of((15, 9), chroma, interleaved)
    rect = Rect.around((5, 3), (30, 30), (15, 9), chroma)
    rect.luma(planes)[:] = 7
    for number, part in enumerate(rect.chroma(planes, chroma)):
        part[:] = 8 + number
    across, down = chroma
    y, x = rect.y, rect.x
    assert (planes[0][y:, x:] == 7).all()
    cb, cr = (planes[1][..., 0], planes[1][..., 1]) if interleaved else planes[1:]
    assert (cb[y // down :, x // across :] == 8).all()
    assert (cr[y // down :, x // across :] == 9).all()


@given(st.sampled_from(SUBSAMPLINGS), WINDOW_SIZES)
def test_every_pixel_sees_the_chroma_of_its_block(chroma, size):
    planes = planes_of(size, chroma)
    spread_chroma = spread(list(planes[1:]), chroma, size[::-1])
    assert spread_chroma.shape == (2, size[1], size[0])
    y, x = np.mgrid[: size[1], : size[0]]
    for plane, got in zip(planes[1:], spread_chroma, strict=True):
        np.testing.assert_array_equal(got, plane[y // chroma[1], x // chroma[0]])


@given(st.sampled_from(SUBSAMPLINGS), WINDOW_SIZES, st.integers(-300, 300), st.integers(0, 1))
def test_the_same_change_everywhere_is_added_and_clipped(chroma, size, change, half):
    planes = planes_of(size, chroma)
    parts = [plane.copy() for plane in planes[1:]]
    fold(parts, np.full((2, *size[::-1]), change + half / 2, np.float32), chroma, 255)
    for old, new in zip(planes[1:], parts, strict=True):
        np.testing.assert_array_equal(new, np.clip(old.astype(int) + change + half, 0, 255))


@pytest.mark.parametrize("chroma", SUBSAMPLINGS)
def test_a_block_takes_the_mean_change_of_its_own_pixels_only(chroma):
    across, down = chroma
    part = np.full((3, 4), 100, np.uint16)
    change = np.zeros((2, 3 * down, 4 * across), np.float32)
    change[:, down, 2 * across] = 8 * across * down  # one pixel of the block in row 1, column 2
    fold([part, part.copy()], change, chroma, 1023)
    want = np.full((3, 4), 100)
    want[1, 2] = 108
    np.testing.assert_array_equal(part, want)


@given(st.sampled_from(SUBSAMPLINGS), WINDOW_SIZES)
def test_no_change_changes_no_code(chroma, size):
    planes = planes_of(size, chroma)
    parts = [plane.copy() for plane in planes[1:]]
    fold(parts, np.zeros((2, *size[::-1]), np.float32), chroma, 255)
    for old, new in zip(planes[1:], parts, strict=True):
        np.testing.assert_array_equal(new, old)
