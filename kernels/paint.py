"""Host side of paint.cl, and its numpy twin."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pyopencl as cl
from makeup_video.kernels.colour import Coding, coding_argument, decode, encode, rounded
from makeup_video.kernels.material import ENVIRONMENT_PX, Material, bilinear, made_up, skin_at
from makeup_video.kernels.planes import Rect, fold, spread
from makeup_video.kernels.program import RUN, Device

_STEP = 64  # rows and columns of a canvas, so that its pixels are whole pieces of _PIECE runs
_PIECE = 256  # runs: OpenBLAS adds up so few in one thread
_ONES = np.ones(RUN, np.float32)
# Of the struct paint_region, in numbers of four bytes: where floats begin, and all of it
_FLOATS, _RECORD = 6, 71
_ROOM = 3 * ENVIRONMENT_PX**2


@dataclass(frozen=True, slots=True, eq=False)
class PaintedRegion:
    """A region of a frame, and the product on it.

    window: its pixels.  weight: of the product, (h, w) float32, 0..1, one of those that `Canvas.place` gave.
    shading, normals: (H, W) and (2, H, W) float32 on a grid of 2 x 2 at least: luminance of the bare
    skin without its fine texture, linear; x and y of the unit normal (x right, y down, in the patch; z
    is towards the viewer).  to_grid: (2, 3) by rows, px of the window to px of the grid, whose border
    is repeated beyond it.  mean: luminance of the bare region.  to_patch: (2, 3) by rows, px of the
    window to coordinates that stick to the skin, of at least -4096 and less than 2^23 cells.
    environment: (3, 16, 16) float32, linear.
    """

    window: Rect
    weight: np.ndarray
    shading: np.ndarray
    normals: np.ndarray
    to_grid: Sequence[float]
    mean: float
    to_patch: Sequence[float]
    environment: np.ndarray
    material: Material


class Canvas:
    """Copies of the windows that are painted on one frame, and all that the kernels are told of them.

    It is kept from frame to frame and grows with what is painted: nothing is allocated for a frame, and the
    kernels keep their arguments.
    """

    def __init__(self, device: Device) -> None:
        self.device = device
        self._kind = (1, 1), np.dtype(np.uint8)  # block and sample
        self._size = 0, 0  # rows, stride
        self._first_rows: list[int] = []
        self._used_rows = 0
        self._told: Coding | None = None

    def place(
        self, windows: Sequence[Rect], block: tuple[int, int], sample: np.dtype
    ) -> list[np.ndarray]:
        """Makes room for the windows of a frame: the weight of each, (h, w) float32, 0, to be filled.

        block: luma pixels of a chroma sample, across and down.  sample: dtype of the planes.
        """
        self._first_rows, rows = [], 0
        for window in windows:
            self._first_rows.append(rows)
            rows += -(-window.height // block[1]) * block[1]
        self._used_rows = _whole(rows)
        size = self._used_rows, _whole(max(window.width for window in windows))
        if (block, sample) != self._kind or size[0] > self._size[0] or size[1] > self._size[1]:
            self._kind = block, sample
            self._grow(max(size[0], self._size[0]), max(size[1], self._size[1]))
        weights = self._weights.array
        weights[: self._used_rows] = 0
        return [
            weights[first : first + window.height, : window.width]
            for first, window in zip(self._first_rows, windows, strict=True)
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
        self._records = self.device.memory((1, _RECORD), np.float32)
        self._told = None

    def paint(
        self, planes: tuple[np.ndarray, ...], surfaces: Sequence[PaintedRegion], coding: Coding
    ) -> None:
        """Paint the surfaces on the planes: their windows are those that were placed, and do not overlap."""
        runs = self._find_runs(self._kind[0][1])
        if not runs:
            return
        self._describe(surfaces)
        self._copy(planes, surfaces, back=False)
        self._tell(coding)
        self._launch(runs)
        self._copy(planes, surfaces, back=True)

    def _find_runs(self, down: int) -> int:
        """Number of the runs that hold any weight; and which they are, for the kernels."""
        weights = self._weights.array[: self._used_rows]
        sums = weights.reshape(-1, _PIECE, RUN) @ _ONES
        found = np.flatnonzero(sums.reshape(-1, down, self._size[1] // RUN).sum(1))
        self._runs.array[: len(found)] = found
        return len(found)

    def _describe(self, surfaces: Sequence[PaintedRegion]) -> None:
        count = sum(3 * surface.shading.size + _ROOM for surface in surfaces)
        if count > self._maps.array.size or len(surfaces) > len(self._records.array):
            self._maps = self.device.memory((2 * count,), np.float32)
            self._records = self.device.memory((2 * len(surfaces), _RECORD), np.float32)
            self._told = None
        maps, rows, (_, down) = self._maps.array, self._rows.array, self._kind[0]
        at = 0
        for number, (surface, first_row) in enumerate(zip(surfaces, self._first_rows, strict=True)):
            layer = surface.shading.size
            maps[at : at + layer] = surface.shading.ravel()
            maps[at + layer : at + 3 * layer] = surface.normals.ravel()
            end = at + 3 * layer + _ROOM
            maps[at + 3 * layer : end] = surface.environment.ravel()
            self._record(number, surface, first_row, at)
            rows[first_row // down :] = number
            at = end

    def _record(self, number: int, surface: PaintedRegion, first_row: int, grid: int) -> None:
        """The struct `paint_region` of paint.cl."""
        record, window = self._records.array[number], surface.window
        high, wide = surface.shading.shape
        record[:_FLOATS].view(np.int32)[:] = (
            first_row, window.width, window.height, grid, wide, high,
        )  # fmt: skip
        record[_FLOATS:] = (
            surface.mean, *surface.to_patch, *surface.to_grid, *surface.material.numbers(),
        )  # fmt: skip

    def _copy(
        self, planes: tuple[np.ndarray, ...], surfaces: Sequence[PaintedRegion], back: bool
    ) -> None:
        """The windows from the planes, or back to them."""
        block = self._kind[0]
        for surface, first in zip(surfaces, self._first_rows, strict=True):
            window = surface.window
            theirs = [window.luma(planes), *window.chroma(planes, block)]
            ours = self._luma.array[first:], *self._chroma.array[:, first // block[1] :]
            for there, here in zip(theirs, ours, strict=True):
                high, wide = there.shape
                if back:
                    there[:] = here[:high, :wide]
                else:
                    here[:high, :wide] = there

    def _tell(self, coding: Coding) -> None:
        """Give the kernels their arguments, when they are others."""
        if self._told == coding:
            return
        block, sample = self._kind
        program = self.device.program("paint.cl", coding.transfer, sample, block)
        # of our own: they keep their arguments
        spread_, paint_, fold_ = self._kernels = [
            cl.Kernel(program, name) for name in ("paint_spread", "paint", "paint_fold")
        ]
        rows, stride = self._size
        size, chroma_size = np.int32(rows * stride), np.int32(self._chroma.array[0].size)
        wide, coded = np.int32(stride), coding_argument(coding)
        luma, chroma, codes, change, weights, maps, records, of_row, runs = (
            memory.buffer
            for memory in (self._luma, self._chroma, self._codes, self._change, self._weights,
                           self._maps, self._records, self._rows, self._runs)
        )  # fmt: skip
        spread_.set_args(chroma, codes, runs, wide, size, chroma_size)
        paint_.set_args(
            luma, codes, change, weights, maps, records, of_row, runs, wide, size, coded
        )
        fold_.set_args(chroma, change, records, of_row, runs, wide, size, chroma_size, coded)
        self._told = coding

    def _launch(self, runs: int) -> None:
        across, down = self._kind[0]
        for memory in (self._luma, self._chroma, self._weights, self._maps, self._records,
                       self._rows, self._runs):  # fmt: skip
            memory.send()
        spread_, paint_, fold_ = self._kernels
        pixels, samples = (RUN, down), (RUN // across, 1)
        for kernel, group in ((spread_, samples), (paint_, pixels), (fold_, samples)):
            self.device.launch(kernel, (runs * group[0], group[1]), (), group)
        self._luma.fetch()
        self._chroma.fetch()
        self.device.finish()


def paint_twin(
    planes: tuple[np.ndarray, ...],
    surfaces: Sequence[PaintedRegion],
    coding: Coding,
    block: tuple[int, int],
) -> tuple[np.ndarray, ...]:
    """What `Canvas.paint` does, in float64: the new planes."""
    new = tuple(plane.copy() for plane in planes)
    for surface in surfaces:
        luma, chroma = surface.window.luma(new), surface.window.chroma(new, block)
        codes = spread(chroma, block, luma.shape)
        luma[:], change = surface_twin(luma, codes, surface, coding)
        fold(chroma, change, block, coding.max_code)
    return new


def surface_twin(
    luma: np.ndarray, chroma: np.ndarray, surface: PaintedRegion, coding: Coding
) -> tuple[np.ndarray, np.ndarray]:
    """Codes (h, w), and of chroma (2, h, w), as each luma pixel sees it -> the new luma codes, and by how
    much chroma changes (2, h, w)."""
    codes = np.stack([luma, *chroma], axis=-1).astype(np.float64)
    coarse, nx, ny = on_window(surface)
    environment = surface.environment.astype(np.float64)
    skin = skin_at(coarse, surface.mean, nx, ny, environment, surface.material)
    weight = surface.weight.astype(np.float64)
    u, v = _mapped(surface.to_patch, luma.shape)
    light = made_up(decode(codes, coding), weight, u, v, skin, surface.material)
    new = np.where(weight[..., None] > 0, encode(light, coding), codes)
    changed = np.moveaxis((new - codes)[..., 1:], -1, 0)
    return rounded(new[..., 0], coding).astype(luma.dtype), changed


def _whole(length: int) -> int:
    return -(-length // _STEP) * _STEP


def on_window(surface: PaintedRegion) -> np.ndarray:
    """(3, h, w): shading and normals at each pixel of the window."""
    grid = np.concatenate([surface.shading[None], surface.normals]).astype(np.float64)
    x, y = _mapped(surface.to_grid, surface.weight.shape)
    high, wide = surface.shading.shape
    x, y = np.clip(x, 0, wide - 1.001), np.clip(y, 0, high - 1.001)
    return np.moveaxis(bilinear(grid, x, y), -1, 0)


def _mapped(to: Sequence[float], hw: tuple[int, ...]) -> tuple[np.ndarray, np.ndarray]:
    """(h, w) float32, x and y of each pixel after a map by rows."""
    y, x = np.mgrid[: hw[0], : hw[1]].astype(np.float32)
    a, b, c, d, e, f = np.array(to, np.float32)
    return a * x + b * y + c, d * x + e * y + f
