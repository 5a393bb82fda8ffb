"""Host side of paint.cl. Its numpy twin is paint_twin.py."""

from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np
from makeup_video.kernels import colour, material
from makeup_video.kernels.colour import Coding, coding_argument
from makeup_video.kernels.definitions import Definitions, offsets
from makeup_video.kernels.material import ENVIRONMENT_PX, MATERIAL
from makeup_video.kernels.planes import Rect
from makeup_video.kernels.program import Device, make_kernel
from makeup_video.kernels.runs import RUN, WeightRuns
from makeup_video.kernels.strokes import Line, PlacedLine, StrokeKernel

# Rows and columns of a canvas are multiples of these, so that its pixels are whole _PIECEs of
# runs.py.
_ROWS, _COLUMNS = 64, 32
_ROOM = ENVIRONMENT_PX**2  # words of an environment
LAYERS = 4  # the most on one region
_ROW = 8  # numbers of a layer
# Opacity below which the colour gradually becomes the mean colour of all layers. With a fifth of
# FAINT, the rounding of shares would change the colour of a place, and of the steep border beside
# it.
FAINT = 5e-4
INSIDE = 1.001  # px before the end of a grid: the last place with a neighbour on each side

# The structs of paint.cl. What a product is on a region, and how the region lies:
PRODUCT = np.dtype([
    # (2, 3) by rows, px of the rectangle -> coordinates that stick to the skin; in cells, these are
    # at least -4096 and below 2^23
    ("to_patch", np.float32, 6),
    ("to_grid", np.float32, 6),  # the same to px of the grid, whose border is repeated
    ("room_step", np.float32),  # of the words of the environment
    ("material", MATERIAL),
    ("layer_count", np.int32),
    # For each layer: the root of the product's light times the opacity, three channels; the
    # opacity; the glint, three channels; the shine, a factor of the material's sparkle,
    # own_highlights and reflection. 0 beyond the last layer. Layers replace the material's product,
    # opacity and glint.
    ("layers", np.float32, (LAYERS, _ROW)),
    ("mean_root", np.float32, 3),  # mean by share over the grid, for an opacity of 1, times FAINT
])  # fmt: skip
PAINT_REGION = np.dtype([
    ("first_row", np.int32),  # of the region's rectangle on the canvas
    ("wide", np.int32),  # of the rectangle
    ("high", np.int32),
    ("grid", np.int32),  # where the region's grid begins in maps
    ("grid_wide", np.int32),
    ("grid_high", np.int32),
    ("mean", np.float32),  # luminance of the bare region
    ("product", PRODUCT),
])  # fmt: skip
_MEAN_AT = offsets(PAINT_REGION)["MEAN_AT"]  # behind the places, before the product
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
        {"paint_product": PRODUCT, "paint_region": PAINT_REGION},
    )
)
# The variant of paint.cl for regions with layers.
_LAYERED = DEFINITIONS + Definitions({"PAINT_LAYERED": 1})


class MadeRegion(NamedTuple):
    """A region of a frame, and the product on it.

    rect: the region's pixels.
    weight: of the product, (h, w) float32, 0..1, one of the arrays that `Canvas.place` returned.
    shading: (H, W) float32 on a grid of at least 2 x 2, the linear luminance of the bare skin
    without its fine texture.
    normals: (2 or 3, H, W) float32 on the same grid, x and y of the unit normal (x right, y down,
    in the patch; z is towards the viewer), and how exposed it is: the share of the synthetic
    highlight and the reflection that is seen. With only two, all of both is seen.
    mean: luminance of the bare region.
    product: a record of PRODUCT.  words: (16, 16) uint32 or int32, of the environment.
    shares: (N, H, W) float32 on the grid, N at most LAYERS: how much of each layer shows, 0..1;
    None for one product.
    """

    rect: Rect
    weight: np.ndarray
    shading: np.ndarray
    normals: np.ndarray
    mean: float
    product: np.void
    words: np.ndarray
    shares: np.ndarray | None = None


class Canvas:
    """Copies of the rectangles that are painted on one frame, and the arguments of the kernels.

    A canvas is kept from frame to frame and only grows. So frames allocate nothing, and the kernels
    keep their arguments.
    """

    def __init__(self, device: Device) -> None:
        self.device = device
        self._kind = (1, 1), np.dtype(np.uint8)  # block and sample
        self._size = 0, 0, 0  # coats, rows, stride
        # of each region of this frame: the number of its coat, its first row, its rectangle
        self._places: list[tuple[int, int, Rect]] = []
        self._coats: list[WeightRuns] = []
        self._placed: list[WeightRuns] = []  # the coats of this frame
        self._coding: Coding | None = None  # of the arguments that the kernels have
        self._paints: dict[tuple[int, int], Any] = {}  # kernels by coat, and 1 with layers

    def place(
        self,
        rects: Sequence[Rect],
        block: tuple[int, int],
        sample: np.dtype,
        counts: Sequence[int] = (),
    ) -> list[np.ndarray]:
        """Make room for the rectangles of a frame, which do not overlap.

        counts: how many coats each rectangle has, painted over each other; one by default.
        Returns the weights of each coat, all 0, to be filled: (h, w) float32, rectangle by
        rectangle.

        block: luma pixels of a chroma sample, across and down.  sample: dtype of the planes.
        """
        counts = counts or (1,) * len(rects)
        depths = range(max(counts))
        places: list[tuple[int, int, Rect]] = []
        numbers: list[list[int]] = [[] for _ in depths]  # of the regions in each coat
        ends, rows, wide = [0 for _ in depths], 0, 0
        for rect, count in zip(rects, counts, strict=True):
            first, rows = rows, rows + -(-rect.height // block[1]) * block[1]
            wide = max(wide, rect.width)
            for depth in depths[:count]:
                numbers[depth].append(len(places))
                places.append((depth, first, rect))
                ends[depth] = rows
        rows, wide = _whole(rows, _ROWS), _whole(wide, _COLUMNS)
        most, most_rows, most_wide = self._size
        if (
            len(depths) > most
            or rows > most_rows
            or wide > most_wide
            or (block, sample) != self._kind
        ):
            self._kind = block, sample
            self._grow(max(len(depths), most), max(rows, most_rows), max(wide, most_wide))
        self._places, self._placed = places, self._coats[: len(depths)]
        for coat, coat_numbers, end in zip(self._placed, numbers, ends, strict=True):
            coat.numbers, coat.used_rows = coat_numbers, _whole(end, _ROWS)
            coat.weights[: coat.used_rows] = 0
        return [
            self._coats[depth].weights[first : first + rect.height, : rect.width]
            for depth, first, rect in places
        ]

    def draw(self, lines: Iterable[tuple[int, Rect, Line]]) -> None:
        """Fill weights with lines; to be called before other weights are filled.

        lines: for each line the number of a placed coat, the part of its rectangle, and the line.
        """
        _, rows, stride = self._size
        placed = []
        for number, part, line in lines:
            depth, first, rect = self._places[number]
            row = depth * rows + first + part.y - rect.y
            placed.append(PlacedLine(line, part, row * stride, part.x - rect.x))
        self.device.once(StrokeKernel)(self._weights, placed)

    def _grow(self, coats: int, rows: int, stride: int) -> None:
        (across, down), sample = self._kind
        self._size = 0, 0, 0  # should there be too little memory
        self._luma = self.device.memory((rows, stride), sample)
        self._chroma = self.device.memory((2, rows // down, stride // across), sample)
        self._codes = self.device.memory((2, rows, stride), np.float32)
        self._runs = self.device.memory((rows // down * stride // RUN,), np.int32)
        self._maps = self.device.memory((1,), np.float32)
        self._make_records(1)
        self._weights = self.device.memory((coats, rows, stride), np.float32)
        self._coats = [WeightRuns(self.device, weights, down) for weights in self._weights.array]
        self._coding = None
        self._size = coats, rows, stride

    def paint(
        self, planes: tuple[np.ndarray, ...], regions: Sequence[MadeRegion], coding: Coding
    ) -> None:
        """Paint regions on the planes, in the order in which their rectangles were placed."""
        coats = self._placed
        have_weight = [coat.has_weight() for coat in coats]
        painted = have_weight[0]
        if len(coats) > 1:
            painted = painted.copy()
            for more in have_weight[1:]:
                painted[: len(more)] |= more
        runs = painted.nonzero()[0]
        if not len(runs):
            return
        self._describe(regions)
        self._runs.array[: len(runs)] = runs
        have_layers = [region.shares is not None for region in regions]
        first_rows = [first for _, first, _ in self._places]
        for coat, has_weight in zip(coats, have_weight, strict=True):
            own = runs if len(coats) == 1 else has_weight.nonzero()[0]
            coat.list_runs(own, first_rows, have_layers)
        parts = self._parts(planes)
        for plane, canvas in parts:
            canvas[:] = plane
        self._launch(len(runs), coding)
        for plane, canvas in parts:
            plane[:] = canvas

    def _describe(self, regions: Sequence[MadeRegion]) -> None:
        count = sum(_map_size(region) for region in regions)
        if count > self._maps.array.size or len(regions) > len(self._records.array):
            self._maps = self.device.memory((2 * count,), np.float32)
            self._make_records(2 * len(regions))
        maps, begin = self._maps.array, 0
        for number, (region, place) in enumerate(zip(regions, self._places, strict=True)):
            (high, wide), layer = region.shading.shape, region.shading.size
            _, first_row, rect = place
            self._places_given[number] = first_row, rect.width, rect.height, begin, wide, high
            self._means[number] = region.mean
            self._products[number] = np.frombuffer(region.product, np.float32)
            maps[begin : begin + layer] = region.shading.ravel()
            known = (1 + len(region.normals)) * layer
            maps[begin + layer : begin + known] = region.normals.ravel()
            maps[begin + known : begin + 4 * layer] = 1  # exposed everywhere
            end = begin + 4 * layer + _ROOM
            maps[begin + 4 * layer : end] = region.words.ravel().view(np.float32)
            begin = end
            if region.shares is not None:
                end += region.shares.size
                maps[begin:end].reshape(region.shares.shape)[:] = region.shares
                begin = end
        for coat in self._placed:
            for number in coat.numbers:
                coat.rows.array[self._places[number][1] // self._kind[0][1] :] = number

    def _make_records(self, count: int) -> None:
        self._records = self.device.memory((count,), PAINT_REGION)
        # views of its fields: writing whole records takes numpy several times as long
        numbers = self._records.array.view(np.float32).reshape(count, -1)
        self._means, self._products = numbers[:, _MEAN_AT], numbers[:, _MEAN_AT + 1 :]
        self._places_given = numbers[:, :_MEAN_AT].view(np.int32)
        self._coding = None

    def _parts(self, planes: tuple[np.ndarray, ...]) -> list[tuple[np.ndarray, np.ndarray]]:
        """Views of the rectangles, on the planes and on the canvas."""
        block, parts = self._kind[0], []
        for number in self._placed[0].numbers:  # the other coats lie on the same rectangles
            _, first, rect = self._places[number]
            on_planes = [rect.luma(planes), *rect.chroma(planes, block)]
            on_canvas = self._luma.array[first:], *self._chroma.array[:, first // block[1] :]
            for plane, canvas in zip(on_planes, on_canvas, strict=True):
                high, wide = plane.shape
                parts.append((plane, canvas[:high, :wide]))
        return parts

    def _set_arguments(self, coding: Coding) -> None:
        """Give the kernels their arguments, if these have changed."""
        if self._coding is coding or self._coding == coding:
            return
        size, chroma_size = np.int32(self._luma.array.size), self._chroma.array[0].size
        chroma, codes, records, of_row, runs = (
            memory.buffer
            for memory in (self._chroma, self._codes, self._records, self._coats[0].rows,
                           self._runs)
        )  # fmt: skip
        sizes = np.int32(self._size[2]), size, np.int32(chroma_size)
        # kernels of this canvas alone, since they keep their arguments
        self._spread = self._kernel("paint_spread", coding)
        self._spread.set_args(chroma, codes, runs, *sizes)
        self._fold = self._kernel("paint_fold", coding)
        self._fold.set_args(chroma, codes, records, of_row, runs, *sizes, coding_argument(coding))
        self._coding, self._paints = coding, {}

    def _kernel(self, name: str, coding: Coding, definitions: Definitions = DEFINITIONS) -> Any:
        block, sample = self._kind
        program = self.device.program("paint.cl", coding.transfer, sample, definitions, block)
        return make_kernel(program, name)

    def _paint_kernel(self, depth: int, has_layers: int, coding: Coding) -> Any:
        """The kernel that paints a coat on regions without layers, or on those with layers."""
        if (depth, has_layers) not in self._paints:
            kernel = self._kernel("paint", coding, _LAYERED if has_layers else DEFINITIONS)
            coat = self._coats[depth]
            buffers = (
                memory.buffer
                for memory in (self._luma, self._codes, self._weights, self._maps, self._records,
                               coat.rows, coat.runs[has_layers])
            )  # fmt: skip
            wide, size = np.int32(self._size[2]), self._luma.array.size
            first = np.int32(depth * size)
            kernel.set_args(*buffers, first, wide, np.int32(size), coding_argument(coding))
            self._paints[depth, has_layers] = kernel
        return self._paints[depth, has_layers]

    def _launch(self, runs: int, coding: Coding) -> None:
        (across, down), launch = self._kind[0], self.device.launch
        if not self.device.shares_memory:
            for memory in (self._luma, self._chroma, self._weights, self._maps, self._records,
                           self._runs):  # fmt: skip
                memory.send()
            for coat in self._placed:
                coat.send()
        self._set_arguments(coding)
        samples = RUN // across, 1
        launch(self._spread, (runs * samples[0], 1), (), samples)
        for depth, coat in enumerate(self._placed):
            for has_layers, count in enumerate(coat.counts):
                if count:
                    kernel = self._paint_kernel(depth, has_layers, coding)
                    launch(kernel, (count * RUN, down), (), (RUN, down))
        launch(self._fold, (runs * samples[0], 1), (), samples)
        self._luma.fetch()
        self._chroma.fetch()
        self.device.finish()


def _whole(length: int, step: int) -> int:
    """Round up to whole steps."""
    return -(-length // step) * step


def _map_size(region: MadeRegion) -> int:
    """How many floats of maps a region takes."""
    grids = 4 if region.shares is None else 4 + len(region.shares)
    return grids * region.shading.size + _ROOM
