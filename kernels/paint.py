"""Host side of paint.cl. Its numpy twin is paint_twin.py."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pyopencl as cl
from makeup_video.kernels import colour, material
from makeup_video.kernels.colour import Coding, coding_argument
from makeup_video.kernels.definitions import Definitions
from makeup_video.kernels.material import ENVIRONMENT_PX, MATERIAL, Environment, Material
from makeup_video.kernels.planes import Rect
from makeup_video.kernels.program import Device, Memory

# Pixels of a row that a work-group paints. PoCL works on eight at once, and longer runs hold more
# pixels without makeup.
RUN = 8
_STEP = 64  # rows and columns of a canvas are multiples, so that its pixels are whole pieces
_PIECE = 256  # runs: OpenBLAS sums so few in one thread
_ONES = np.ones(RUN, np.float32)
_ROOM = ENVIRONMENT_PX**2  # words of an environment
LAYERS = 4  # the most on one region
_ROW = 8  # numbers of a layer
# Opacity below which the colour goes over into the mean of all layers: at a fifth of it, a rounding
# of shares would change the colour of a place, and of the steep border beside it.
FAINT = 5e-4
INSIDE = 1.001  # px before the end of a grid: the last place with a neighbour on each side

# The struct of paint.cl.
PAINT_REGION = np.dtype([
    ("first_row", np.int32),  # of the region's rectangle on the canvas
    ("wide", np.int32),  # of the rectangle
    ("high", np.int32),
    ("grid", np.int32),  # where the region's grid begins in maps
    ("grid_wide", np.int32),
    ("grid_high", np.int32),
    ("mean", np.float32),  # luminance of the bare region
    ("to_patch", np.float32, 6),  # px of the rectangle -> coordinates that stick to the skin
    ("to_grid", np.float32, 6),  # px of the rectangle -> px of the grid
    ("room_step", np.float32),  # of the words of the environment
    ("product", MATERIAL),
    ("layer_count", np.int32),
    ("layers", np.float32, (LAYERS, _ROW)),  # numbers of Layers; 0 beyond the last one
    ("mean_root", np.float32, 3),  # of Layers, times FAINT
])  # fmt: skip
DEFINITIONS = (
    colour.DEFINITIONS
    + material.DEFINITIONS
    + Definitions(
        {
            "RUN": RUN,
            "PAINT_INSIDE": INSIDE,
            "PAINT_LAYERS": LAYERS,
            "PAINT_ROW": _ROW,
            "PAINT_FAINT": FAINT,
        },
        {"paint_region": PAINT_REGION},
    )
)
# The variant of paint.cl for regions with layers.
_LAYERED = DEFINITIONS + Definitions({"PAINT_LAYERED": 1})
_OF_LAYERS = ["layer_count", "layers", "mean_root"]  # fields of PAINT_REGION
_PLAIN = [name for name in PAINT_REGION.names or () if name not in _OF_LAYERS]


@dataclass(frozen=True, slots=True, eq=False)
class Layers:
    """Products that lie over each other on a region, composed at each pixel.

    shares: (N, H, W) float32 on the region's grid, N at most LAYERS: how much of each shows, 0..1.
    numbers: of each its root of the product's light times its opacity, three channels; its opacity;
    its glint, three channels; its shine, a factor of the material's sparkle, own_highlights and
    reflection.
    mean_root: the first three, summed by share over the grid, for an opacity of 1.
    """

    shares: np.ndarray
    numbers: Sequence[Sequence[float]]
    mean_root: Sequence[float]


@dataclass(frozen=True, slots=True, eq=False)
class PaintedRegion:
    """A region of a frame, and the product on it.

    rect: the region's pixels.
    weight: of the product, (h, w) float32, 0..1, one of the arrays that `Canvas.place` returned.
    shading: (H, W) float32 on a grid of at least 2 x 2, the linear luminance of the bare skin
    without its fine texture.
    normals: (2, H, W) float32 on the same grid, x and y of the unit normal (x right, y down, in the
    patch; z is towards the viewer).
    to_grid: (2, 3) by rows, from px of the rectangle to px of the grid, whose border is repeated.
    mean: luminance of the bare region.
    to_patch: (2, 3) by rows, from px of the rectangle to coordinates that stick to the skin, which
    lie at -4096 cells or more and below 2^23.
    layers: in place of the material's product, opacity and glint; None for one product.
    """

    rect: Rect
    weight: np.ndarray
    shading: np.ndarray
    normals: np.ndarray
    to_grid: Sequence[float]
    mean: float
    to_patch: Sequence[float]
    environment: Environment
    material: Material
    layers: Layers | None = None


class Canvas:
    """Copies of the rectangles that are painted on one frame, and the arguments of the kernels.

    A canvas is kept from frame to frame and only grows, so that frames allocate nothing and the
    kernels keep their arguments.
    """

    def __init__(self, device: Device) -> None:
        self.device = device
        self._kind = (1, 1), np.dtype(np.uint8)  # block and sample
        self._size = 0, 0  # rows, stride
        self._first_rows: list[int] = []
        self._used_rows = 0
        self._coding: Coding | None = None  # of the arguments that the kernels have

    def place(
        self, rects: Sequence[Rect], block: tuple[int, int], sample: np.dtype
    ) -> list[np.ndarray]:
        """Make room for the rectangles of a frame.

        Returns a weight for each, to be filled: (h, w) float32, 0.

        block: luma pixels of a chroma sample, across and down.  sample: dtype of the planes.
        """
        self._first_rows, rows = [], 0
        for rect in rects:
            self._first_rows.append(rows)
            rows += -(-rect.height // block[1]) * block[1]
        self._used_rows = _whole(rows)
        size = self._used_rows, _whole(max(rect.width for rect in rects))
        if (block, sample) != self._kind or size[0] > self._size[0] or size[1] > self._size[1]:
            self._kind = block, sample
            self._grow(max(size[0], self._size[0]), max(size[1], self._size[1]))
        weights = self._weights.array
        weights[: self._used_rows] = 0
        return [
            weights[first : first + rect.height, : rect.width]
            for first, rect in zip(self._first_rows, rects, strict=True)
        ]

    def _grow(self, rows: int, stride: int) -> None:
        (across, down), sample = self._kind
        self._size = rows, stride
        self._luma = self.device.memory((rows, stride), sample)
        self._chroma = self.device.memory((2, rows // down, stride // across), sample)
        self._codes = self.device.memory((2, rows, stride), np.float32)
        self._change = self.device.memory((2, rows, stride), np.float32)
        self._weights = self.device.memory((rows, stride), np.float32)
        self._rows = self.device.memory((rows // down,), np.int32)
        self._runs = self.device.memory((rows // down * stride // RUN,), np.int32)
        self._maps = self.device.memory((1,), np.float32)
        self._make_records(1)
        self._layered_runs = self.device.memory((1,), np.int32)
        self._coding = None

    def paint(
        self, planes: tuple[np.ndarray, ...], regions: Sequence[PaintedRegion], coding: Coding
    ) -> None:
        """Paint regions on the planes. Their rectangles, as placed, must not overlap."""
        runs = self._find_runs(self._kind[0][1])
        if not len(runs):
            return
        self._describe(regions)
        layered = self._list_runs(runs, regions)
        self._copy(planes, regions, back=False)
        self._set_arguments(coding, layered)
        self._launch(len(runs), layered)
        self._copy(planes, regions, back=True)

    def _find_runs(self, down: int) -> np.ndarray:
        """The runs that hold any weight, (N,), in rising order."""
        weights = self._weights.array[: self._used_rows]
        rows = (weights.reshape(-1, _PIECE, RUN) @ _ONES).reshape(-1, down, self._size[1] // RUN)
        of_blocks = rows[:, 0]
        for row in range(1, down):
            of_blocks = of_blocks + rows[:, row]
        return (of_blocks > 0).ravel().nonzero()[0]

    def _list_runs(self, runs: np.ndarray, regions: Sequence[PaintedRegion]) -> int:
        """List all runs for the kernels, and once more those in regions with layers.

        Returns the number of the latter. They come last among all, too.
        """
        have_layers = [region.layers is not None for region in regions]
        if not any(have_layers):
            self._runs.array[: len(runs)] = runs
            return 0
        of_row = self._rows.array[runs // (self._size[1] // RUN)]
        has_layers = np.array(have_layers)[of_row]
        layered = runs[has_layers]
        self._runs.array[: len(runs)] = np.concatenate([runs[~has_layers], layered])
        if len(self._layered_runs.array) < len(layered):
            self._layered_runs = self.device.memory((len(self._runs.array),), np.int32)
            self._coding = None
        self._layered_runs.array[: len(layered)] = layered
        return len(layered)

    def _describe(self, regions: Sequence[PaintedRegion]) -> None:
        count = sum(_map_size(region) for region in regions)
        if count > self._maps.array.size or len(regions) > len(self._records.array):
            self._maps = self.device.memory((2 * count,), np.float32)
            self._make_records(2 * len(regions))
            self._coding = None
        maps, rows, (_, down) = self._maps.array, self._rows.array, self._kind[0]
        begin = 0
        for number, (region, first_row) in enumerate(zip(regions, self._first_rows, strict=True)):
            layer = region.shading.size
            maps[begin : begin + layer] = region.shading.ravel()
            maps[begin + layer : begin + 3 * layer] = region.normals.ravel()
            end = begin + 3 * layer + _ROOM
            maps[begin + 3 * layer : end] = region.environment.words.view(np.float32).ravel()
            self._plain_records[number] = _record(region, first_row, begin)
            if region.layers is not None:
                shares = region.layers.shares
                maps[end : end + shares.size] = shares.ravel()
                self._layer_records[number] = _layer_record(region.layers)
            rows[first_row // down :] = number
            begin += _map_size(region)

    def _make_records(self, count: int) -> None:
        self._records = self.device.memory((count,), PAINT_REGION)
        self._plain_records = self._records.array[_PLAIN]
        self._layer_records = self._records.array[_OF_LAYERS]

    def _copy(
        self, planes: tuple[np.ndarray, ...], regions: Sequence[PaintedRegion], back: bool
    ) -> None:
        """Copy the rectangles from the planes to the canvas, or back."""
        block = self._kind[0]
        for region, first in zip(regions, self._first_rows, strict=True):
            on_planes = [region.rect.luma(planes), *region.rect.chroma(planes, block)]
            on_canvas = self._luma.array[first:], *self._chroma.array[:, first // block[1] :]
            for plane, canvas in zip(on_planes, on_canvas, strict=True):
                high, wide = plane.shape
                if back:
                    plane[:] = canvas[:high, :wide]
                else:
                    canvas[:high, :wide] = plane

    def _set_arguments(self, coding: Coding, layered: int) -> None:
        """Give the kernels their arguments, where these have changed."""
        if self._coding != coding:
            size, chroma_size = np.int32(self._luma.array.size), self._chroma.array[0].size
            wide, coded = np.int32(self._size[1]), coding_argument(coding)
            chroma, codes, change, records, of_row, runs = (
                memory.buffer
                for memory in (self._chroma, self._codes, self._change, self._records, self._rows,
                               self._runs)
            )  # fmt: skip
            sizes = wide, size, np.int32(chroma_size)
            # kernels of this canvas alone, since they keep their arguments
            self._spread = self._kernel("paint_spread", coding)
            self._spread.set_args(chroma, codes, runs, *sizes)
            self._paint = self._paint_kernel(coding, DEFINITIONS, self._runs)
            self._fold = self._kernel("paint_fold", coding)
            self._fold.set_args(chroma, change, records, of_row, runs, *sizes, coded)
            self._coding, self._paint_layered = coding, None
        if layered and self._paint_layered is None:
            self._paint_layered = self._paint_kernel(coding, _LAYERED, self._layered_runs)

    def _kernel(self, name: str, coding: Coding, definitions: Definitions = DEFINITIONS) -> Any:
        block, sample = self._kind
        program = self.device.program("paint.cl", coding.transfer, sample, block, definitions)
        return cl.Kernel(program, name)

    def _paint_kernel(self, coding: Coding, definitions: Definitions, runs: Memory) -> Any:
        kernel = self._kernel("paint", coding, definitions)
        buffers = (
            memory.buffer
            for memory in (self._luma, self._codes, self._change, self._weights, self._maps,
                           self._records, self._rows, runs)
        )  # fmt: skip
        wide, size = np.int32(self._size[1]), np.int32(self._luma.array.size)
        kernel.set_args(*buffers, wide, size, coding_argument(coding))
        return kernel

    def _launch(self, runs: int, layered: int) -> None:
        across, down = self._kind[0]
        for memory in (self._luma, self._chroma, self._weights, self._maps, self._records,
                       self._rows, self._runs):  # fmt: skip
            memory.send()
        if layered:
            self._layered_runs.send()
        pixels, samples = (RUN, down), (RUN // across, 1)
        for kernel, group, count in (
            (self._spread, samples, runs),
            (self._paint, pixels, runs - layered),
            (self._paint_layered, pixels, layered),
            (self._fold, samples, runs),
        ):
            if count:
                self.device.launch(kernel, (count * group[0], group[1]), (), group)
        self._luma.fetch()
        self._chroma.fetch()
        self.device.finish()


def _record(
    region: PaintedRegion, first_row: int, grid: int
) -> tuple[int | float | Sequence[Any], ...]:
    """Return the fields of a PAINT_REGION but those of its layers.

    first_row: on the canvas.  grid: its index in maps.
    """
    high, wide = region.shading.shape
    return (
        first_row, region.rect.width, region.rect.height, grid, wide, high, region.mean,
        region.to_patch, region.to_grid, region.environment.step, region.material.record(),
    )  # fmt: skip


def _layer_record(layers: Layers) -> tuple[Any, ...]:
    """Return the fields of a PAINT_REGION that describe its layers."""
    numbers = np.zeros((LAYERS, _ROW), np.float32)
    numbers[: len(layers.numbers)] = layers.numbers
    return len(layers.numbers), numbers, [FAINT * part for part in layers.mean_root]


def _whole(length: int) -> int:
    """Round up to whole steps of a canvas."""
    return -(-length // _STEP) * _STEP


def _map_size(region: PaintedRegion) -> int:
    """How many floats of maps a region takes."""
    grids = 3 if region.layers is None else 3 + len(region.layers.shares)
    return grids * region.shading.size + _ROOM
