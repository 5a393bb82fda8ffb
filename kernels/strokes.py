"""Host side of strokes.cl: lines that are drawn on the pixels of a canvas.

Its numpy twin is pipeline/render/strokes_twin.py.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from makeup_video.kernels import colour
from makeup_video.kernels.colour import SRGB
from makeup_video.kernels.definitions import Definitions
from makeup_video.kernels.planes import Rect
from makeup_video.kernels.program import Device, Memory

MAPS = 4  # both borders of two strokes, which are interpolated at once
_ROWS = 8  # of pixels for a work-item

# The struct of strokes.cl.
JOB = np.dtype([
    ("to_grid", np.float32, 6),  # px of the rectangle -> px of the grid
    ("first", np.int32),  # where the rectangle's first row begins on the canvas
    ("left", np.int32),  # its first column there
    ("wide", np.int32),
    ("high", np.int32),
    ("maps", np.int32),  # index of this job's first place
    ("count", np.int32),  # of its pairs of strokes
    ("grid_wide", np.int32),
    ("grid_high", np.int32),
    ("blur_px", np.float32),
    ("soft_px", np.float32),
])  # fmt: skip
DEFINITIONS = colour.DEFINITIONS + Definitions(
    {
        "STROKES_INSIDE": 1e-4,  # so that the next place exists
    },
    {"strokes_job": JOB},
)


class Line(NamedTuple):
    """A line on a grid.

    to_px: (2, 3) by rows, px of the grid -> px of the picture.
    maps: (P, H, W, 4) float32, for each pair of strokes how far a place lies above the lower border
    and below the upper one, px of the picture; a stroke without a partner stands twice. Where
    several strokes meet, the densest counts.
    blur_px, soft_px: over how many px of the picture the upper border fades, and over how many the
    lower one does; soft_px is at least 1 and at most blur_px.
    """

    to_px: Sequence[float]
    maps: np.ndarray
    blur_px: float
    soft_px: float


class PlacedLine(NamedTuple):
    """A line, and the rectangle of the picture that it fills.

    first: where the rectangle's first row begins on the canvas.  left: its first column there.
    """

    line: Line
    rect: Rect
    first: int
    left: int


class StrokeKernel:
    """Runs the kernel for a canvas at a time, on a device that no other thread uses."""

    def __init__(self, device: Device) -> None:
        self._device = device
        self._kernel = device.kernel("strokes", SRGB, np.dtype(np.uint8), DEFINITIONS)
        self._jobs, self._maps = device.memory((1,), JOB), device.memory((1, MAPS), np.float32)
        self._out: Memory | None = None  # of the arguments that the kernel has

    def __call__(self, out: Memory, placed: Sequence[PlacedLine]) -> None:
        """Fill rectangles of a canvas, (..., stride) float32, with the coverage of lines, 0..1.

        Up to seven pixels beside a rectangle become 0.
        """
        places = sum(one.line.maps.size // MAPS for one in placed)
        if places > len(self._maps.array) or len(placed) > len(self._jobs.array):
            self._jobs = self._device.memory((2 * len(placed),), JOB)
            self._maps = self._device.memory((2 * places, MAPS), np.float32)
            self._out = None
        begin = 0
        for number, one in enumerate(placed):
            count, high, wide, _ = one.line.maps.shape
            end = begin + count * high * wide
            self._maps.array[begin:end] = one.line.maps.reshape(-1, MAPS)
            self._jobs.array[number] = (
                _inverse(one), one.first, one.left, one.rect.width, one.rect.height, begin, count,
                wide, high, one.line.blur_px, one.line.soft_px,
            )  # fmt: skip
            begin = end
        for memory in (self._jobs, self._maps, out):
            memory.send()
        if self._out is not out:
            stride = np.int32(out.array.shape[-1])
            self._kernel.set_args(self._jobs.buffer, self._maps.buffer, out.buffer, stride)
            self._out = out
        eights = -(-max(one.rect.height for one in placed) // _ROWS)
        self._device.launch(self._kernel, (eights, len(placed)), (), (1, 1))
        out.fetch()
        self._device.finish()


def _inverse(one: PlacedLine) -> tuple[float, ...]:
    """(2, 3) by rows: px of the rectangle -> px of the grid."""
    a, b, x, c, d, y = one.line.to_px
    x, y = x - one.rect.x, y - one.rect.y
    share = 1 / (a * d - b * c)
    return (
        d * share, -b * share, (b * y - d * x) * share,
        -c * share, a * share, (c * x - a * y) * share,
    )  # fmt: skip
