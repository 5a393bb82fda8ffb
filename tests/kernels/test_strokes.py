"""The kernel that draws lines against its numpy twin."""

import numpy as np
from hypothesis import example, given, settings
from hypothesis import strategies as st
from makeup import canvas
from makeup_video.kernels.planes import Rect
from makeup_video.pipeline.look.kinds.kind import Stroke
from makeup_video.pipeline.render.grid import Grid
from makeup_video.pipeline.render.strokes import line_of
from makeup_video.pipeline.render.strokes_twin import draw_strokes

WHOLE = Rect(40, 60, 90, 50)
parts = st.builds(
    lambda x, y, wide, high: Rect(WHOLE.x + x, WHOLE.y + y, wide, high),
    st.integers(0, 40), st.integers(0, 20), st.integers(1, 50), st.integers(1, 30),
)  # fmt: skip
lines = st.tuples(
    st.integers(0, 9999),
    st.integers(1, 3),  # strokes
    st.floats(1, 6),  # blur of the upper border
    st.floats(0, 1),  # share of that blur at the lower border
    st.sampled_from((1.0, 0.5, 0.25)),
    st.floats(0.6, 5),  # px between places of the grid
    st.floats(-3.2, 3.2),
    parts,
)


def grid_over(step, angle, hw=(24, 40)):
    """A grid about the rectangle's middle, and smaller than the rectangle for a small step."""
    turn = step * np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    middle = np.array([[WHOLE.x + WHOLE.width / 2], [WHOLE.y + WHOLE.height / 2]])
    to_px = np.hstack([turn, middle - turn @ [[hw[1] / 2], [hw[0] / 2]]])
    return Grid(to_px, (hw[1], hw[0]))


def strokes_on(grid, seed, count):
    """Strokes whose borders are as smooth as distances."""
    rng, (wide, high) = np.random.default_rng(seed), grid.size_wh
    y, x = np.mgrid[:high, :wide]
    borders = []
    for _ in range(count):
        a, b = rng.uniform(-1, 1, 2)
        above = a * (x - wide / 2) + b * (y - high / 2) + rng.uniform(-4, 4)
        borders.append(Stroke(*(one.astype(np.float32) for one in (above, 3 - above))))
    return tuple(borders)


# In float32 this blur equals that of the lower border. Beyond it, only the upper one is smudged.
HARDLY_BLURRED = (4, 3, 1.0000000000000002, 0.0, 1.0, 3.0, 0.0, Rect(WHOLE.x, WHOLE.y, 2, 1))


@settings(max_examples=150, deadline=None)
@given(st.lists(lines, min_size=1, max_size=3))
@example([HARDLY_BLURRED])
def test_lines_match_their_twin(given_lines):
    """The lines lie over each other on one rectangle, each in a part of the rectangle."""
    weights = canvas().place([WHOLE], (2, 2), np.dtype(np.uint8), [len(given_lines)])
    drawn, wanted = [], []
    for number, (seed, count, blur_px, lower, share, step, angle, part) in enumerate(given_lines):
        soft_px = 1 + lower * (blur_px - 1)
        grid = grid_over(step, angle)
        strokes = strokes_on(grid, seed, count)
        drawn.append((number, part, line_of(grid, strokes, blur_px, soft_px, share)))
        whole = np.zeros((WHOLE.height, WHOLE.width), np.float32)
        out = np.empty((part.height, part.width), np.float32)
        draw_strokes(out, (part.x, part.y), grid, strokes, blur_px, soft_px, share)
        WHOLE.part(whole, part)[:] = out
        wanted.append((whole, beyond(grid)))
    canvas().draw(drawn)
    for weight, (want, near_border) in zip(weights, wanted, strict=True):
        # at the border, the twin fades out over the last hundredth of a place of the grid
        assert np.abs(weight - want)[~near_border].max(initial=0) < 2e-3


def beyond(grid):
    """(h, w) bool of the whole rectangle: pixels on the border of a grid."""
    y, x = np.mgrid[: WHOLE.height, : WHOLE.width]
    px = np.stack([x + WHOLE.x, y + WHOLE.y]) - grid.to_px[:, 2][:, None, None]
    at = np.einsum("ij,jhw->ihw", np.linalg.inv(grid.to_px[:, :2]), px)
    last = np.array(grid.size_wh)[:, None, None] - 1
    return (np.abs(np.minimum(at, last - at)) < 0.02).any(0)


def test_pixels_beyond_the_grid_have_no_weight():
    grid = grid_over(0.6, 0.3)
    everywhere = Stroke(*np.full((2, 24, 40), 9, np.float32))
    (weight,) = canvas().place([WHOLE], (2, 2), np.dtype(np.uint8))
    canvas().draw([(0, WHOLE, line_of(grid, (everywhere,), 1.0, 1.0, 1.0))])
    assert 0.9 * 23 * 39 * 0.36 < weight.sum() < 1.1 * 23 * 39 * 0.36
    assert weight.max() == 1
