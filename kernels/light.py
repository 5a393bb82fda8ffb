"""Host side of reading light: the planes that kernels read from, and the table of linear light."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np
import pyopencl as cl
from makeup_video.kernels.colour import HLG, HLG_GAMMA, Coding, matrices, to_linear, to_xyz
from makeup_video.kernels.definitions import Definitions
from makeup_video.kernels.program import Device

_STEPS = 1023  # of R'G'B' from 0 to 1, in the table of linear light

# What kernels must know of a plane that they read, all float32.
PLANE = np.dtype([
    ("row_step", np.float32),  # samples from row to row
    ("last_x", np.float32),  # a little less than the last column, so that the next one exists
    ("last_y", np.float32),
])  # fmt: skip
# What a kernel must know to read light; `light_numbers` has the values.
LIGHT_FIELDS: tuple[tuple[Any, ...], ...] = (
    ("luma", PLANE),
    ("chroma", PLANE),
    ("to_steps", np.float32, (3, 4)),  # codes -> R'G'B' in steps of the table, plus a half
    ("weights", np.float32, 3),  # of luminance
    ("last_step", np.float32),  # of the table
    ("chroma_begins", np.float32, 2),  # samples from Y' to Cb, and from Cb to Cr
)
# px of a frame -> of a plane: scale and offset of x, of y
Stretch = tuple[float, float, float, float]
Affine = tuple[float, float, float, float, float, float]  # (2, 3) by rows: (x, y, 1) -> (x, y)


@dataclass(frozen=True, slots=True, eq=False)
class LightPlanes:
    """The planes that light is read from.

    planes: Y', Cb and Cr, (H, W) uint8 or uint16 codes, at least 2x2; three times Y' for a grey
    frame.
    to_luma, to_chroma: px of the frame -> px of these planes.
    has_colour: False for a grey frame.
    """

    planes: tuple[np.ndarray, np.ndarray, np.ndarray]
    to_luma: Stretch
    to_chroma: Stretch
    coding: Coding
    has_colour: bool = True


class LightReader:
    """What kernels that read light share: copies of the planes, and the table of light.

    So little of a frame is read that a copy costs less than buffers over the frame's own planes,
    and the kernels keep their arguments.
    """

    def __init__(self, device: Device) -> None:
        self._device = device
        self._tables: dict[int, cl.Buffer] = {}
        self._planes = device.memory((1,), np.uint8)
        self._kernel: Any = None
        # transfer function and planes of the kernel's arguments
        self._has_arguments_for: tuple[int, cl.Buffer] | None = None

    def kernel(
        self,
        name: str,
        definitions: Definitions,
        light: LightPlanes,
        before: Sequence[cl.Buffer],
        after: Sequence[cl.Buffer],
    ) -> Any:
        """The one kernel that this reader serves, ready to read this light.

        Its arguments are `before`, the planes, which are copied, the table of light, and `after`.
        """
        self._copy(light)
        transfer, sample = light.coding.transfer, light.planes[0].dtype
        needed = transfer, self._planes.buffer
        if needed != self._has_arguments_for:
            self._has_arguments_for = None  # should building the kernel fail, or be interrupted
            self._kernel = self._device.kernel(name, transfer, sample, definitions)
            self._kernel.set_args(*before, self._planes.buffer, self._table(transfer), *after)
            self._has_arguments_for = needed
        return self._kernel

    def _copy(self, light: LightPlanes) -> None:
        """Copy Y', Cb and Cr, one after another."""
        count, sample = sum(plane.size for plane in light.planes), light.planes[0].dtype
        if self._planes.array.size < count or self._planes.array.dtype != sample:
            self._planes = self._device.memory((2 * count,), sample)
        end = 0
        for plane in light.planes:
            begin, end = end, end + plane.size
            self._planes.array[begin:end].reshape(plane.shape)[:] = plane
        self._planes.send()

    def _table(self, transfer: int) -> cl.Buffer:
        """`light_table` on the device."""
        if transfer not in self._tables:
            self._tables[transfer] = self.kept(light_table(transfer))
        return self._tables[transfer]

    def kept(self, numbers: np.ndarray) -> cl.Buffer:
        """Copy an array to the device, for reading."""
        flags = cl.mem_flags.READ_ONLY | cl.mem_flags.COPY_HOST_PTR
        return cl.Buffer(self._device.context, flags, hostbuf=numbers)


def on_planes(to_px: Affine, light: LightPlanes) -> list[float]:
    """Return to_luma and to_chroma of a grid, by rows: px of the grid -> px of each plane.

    to_px: px of the grid -> px of the frame.
    """
    a, b, left, c, d, top = to_px
    numbers: list[float] = []
    for across, x, along, y in (light.to_luma, light.to_chroma):
        numbers += [a * across, b * across, left * across + x]
        numbers += [c * along, d * along, top * along + y]
    return numbers


@lru_cache
def light_table(transfer: int) -> np.ndarray:
    """Tabulate the linear light of R'G'B' from 0 to 1: (1024,) float32."""
    steps = np.arange(_STEPS + 1) / _STEPS
    table = to_linear(np.repeat(steps[:, None], 3, axis=1), transfer)[:, 0]
    if transfer == HLG:  # the display's gain comes after the sum (BT.2100: OOTF)
        table = table ** (1 / HLG_GAMMA)
    return table.astype(np.float32)


@lru_cache
def to_steps(coding: Coding, has_colour: bool) -> np.ndarray:
    """Return the (3, 4) matrix from codes to R'G'B' in steps of the table, plus a half.

    A grey frame's chroma counts as neutral.
    """
    steps = matrices(coding)[0] * _STEPS
    steps[:, 3] += 0.5
    if not has_colour:
        steps[:, 3] += steps[:, 1:3].sum(1) * 2.0 ** (coding.bit_depth - 1)
        steps[:, 1:3] = 0
    return steps


def light_numbers(light: LightPlanes) -> list[float]:
    """Return the numbers of LIGHT_FIELDS."""
    luma, chroma, _ = light.planes
    return [
        *_plane_numbers(luma.shape), *_plane_numbers(chroma.shape),
        *_coding_numbers(light.coding, light.has_colour), luma.size, chroma.size,
    ]  # fmt: skip


def _plane_numbers(hw: tuple[int, ...]) -> Sequence[float]:
    """Return the numbers of a PLANE."""
    high, wide = hw
    less = 1 - 1e-6  # more than the rounding of float32
    return wide, (wide - 1) * less, (high - 1) * less


@lru_cache
def _coding_numbers(coding: Coding, has_colour: bool) -> tuple[float, ...]:
    """Return `to_steps`, the weights of luminance, and the last step of the table."""
    weights = to_xyz(coding.primaries)[1]
    return (*to_steps(coding, has_colour).ravel().tolist(), *weights.tolist(), float(_STEPS))
