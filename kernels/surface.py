"""Host side of surface.cl. Its numpy twins are in pipeline/render/regions/lips.py, eyes.py and shading.py."""

import math
import struct
import threading
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import pyopencl as cl
from makeup_video.kernels.colour import HLG, HLG_GAMMA, Coding, matrices, to_linear, to_xyz
from makeup_video.kernels.program import LOCAL_SIZE, Device
from numpy.lib.stride_tricks import as_strided

# As in surface.cl: the patch of the lips, its grid, that of a lid.
PATCH_HW, LIPS_HW, LID_HW = (80, 112), (40, 56), (28, 40)
_PATCH, _LIPS, _LID = (math.prod(hw) for hw in (PATCH_HW, LIPS_HW, LID_HW))
_POINTS, _REGIONS = 478, 3
_SCRATCH = 60 * 112 + 16 + 7 * _LIPS + 6 * 40 * 88  # floats, of a region
_STEPS = 1023  # of R'G'B' from 0 to 1, in the table of its light

_NOWHERE = (0.0,) * 22  # a place without a region
_HEAD = struct.Struct("88f")  # of `given`: three places, two planes, the coding
_POINTS_AT = _HEAD.size // 4
_LOGITS_AT = _POINTS_AT + 3 * _POINTS
# Of `out`.
_LIPS_AT = 2 * _PATCH
_LIDS_AT = _LIPS_AT + 4 * _LIPS
_MEANS_AT = _LIDS_AT + 2 * 5 * _LID

Affine = tuple[float, float, float, float, float, float]  # (2, 3) by rows: (x, y, 1) -> (x, y)
Stretch = tuple[float, float, float, float]  # px of a frame -> of a plane: of x times, plus; of y


@dataclass(frozen=True, slots=True)
class GridPlace:
    """A grid on the frame, and the space that its region is measured in.

    to_px: px of the grid -> px of the frame.  own_to_px: the region's own px -> px of the frame.
    """

    to_px: Affine
    own_to_px: Affine


@dataclass(frozen=True, slots=True, eq=False)
class LightPlanes:
    """What light is read from.

    planes: Y', Cb and Cr, (H, W) uint8 or uint16 codes, 2x2 at least, their rows whole; of grey
    three times Y'.  to_luma, to_chroma: px of the frame -> px of these planes.  has_colour: False for
    grey.
    """

    planes: tuple[np.ndarray, np.ndarray, np.ndarray]
    to_luma: Stretch
    to_chroma: Stretch
    coding: Coding
    has_colour: bool = True


@dataclass(frozen=True, slots=True, eq=False)
class FaceSurfaces:
    """Of one face; float32. What had no place holds nothing of use.

    odds, rim: (80, 112), see LipsSurface.  lips: (4, 40, 56), shading, x and y of the normals, upper.
    lids: (2, 5, 28, 40), of each up and lash_px (see LidSurface), shading, x and y of the normals.
    means: of the light on the lips and on both lids.
    """

    odds: np.ndarray
    rim: np.ndarray
    lips: np.ndarray
    lids: np.ndarray
    means: list[float]


class SurfaceKernel:
    """The kernel, for one face after the other; threads wait for each other."""

    def __init__(self, device: Device, rings: np.ndarray) -> None:
        """rings: (14, 11), the points of each curve, see surface.cl."""
        self._device = device
        self._lock = threading.Lock()
        self._tables: dict[int, cl.Buffer] = {}
        self._rings = self._kept(rings.astype(np.int32))
        self._given = np.zeros(_LOGITS_AT + _PATCH, np.float32)
        self._head = self._given.data
        scratch = 4 * _REGIONS * _SCRATCH
        self._scratch = cl.Buffer(device.context, cl.mem_flags.READ_WRITE, scratch)

    def __call__(
        self,
        places: Sequence[GridPlace | None],
        points_px: np.ndarray,
        logits: np.ndarray,
        light: LightPlanes,
    ) -> FaceSurfaces:
        """places: of the lips and of both eyes. points_px: (478, 3). logits: (80, 112) of lipstick."""
        out = np.empty(_MEANS_AT + 3, np.float32)
        with self._lock:
            self._fill(places, points_px, logits, light)
            self._run(light, out)
        return FaceSurfaces(
            out[:_PATCH].reshape(PATCH_HW),
            out[_PATCH:_LIPS_AT].reshape(PATCH_HW),
            out[_LIPS_AT:_LIDS_AT].reshape(4, *LIPS_HW),
            out[_LIDS_AT:_MEANS_AT].reshape(2, 5, *LID_HW),
            out[_MEANS_AT:].tolist(),
        )

    def _fill(
        self,
        places: Sequence[GridPlace | None],
        points_px: np.ndarray,
        logits: np.ndarray,
        light: LightPlanes,
    ) -> None:
        numbers: list[float] = []
        for place in places:
            numbers += _place(place, light) if place else _NOWHERE
        luma, chroma, _ = light.planes
        numbers += _plane(luma)
        numbers += _plane(chroma)
        numbers += _coding(light.coding, light.has_colour)
        _HEAD.pack_into(self._head, 0, *numbers)
        self._given[_POINTS_AT:_LOGITS_AT] = points_px.ravel()
        if places[0]:
            self._given[_LOGITS_AT:] = logits.ravel()

    def _run(self, light: LightPlanes, out: np.ndarray) -> None:
        transfer = light.coding.transfer
        kernel = self._device.kernel("surface", transfer, light.planes[0].dtype)
        planes = [self._lent(plane) for plane in light.planes]
        with self._device.lend(self._given, out) as (given, filled):
            self._device.launch(
                kernel,
                (_REGIONS * LOCAL_SIZE[0], 1),
                (given, self._rings, *planes, self._table(transfer), self._scratch, filled),
            )

    def _table(self, transfer: int) -> cl.Buffer:
        if transfer not in self._tables:
            self._tables[transfer] = self._kept(light_table(transfer))
        return self._tables[transfer]

    def _kept(self, numbers: np.ndarray) -> cl.Buffer:
        flags = cl.mem_flags.READ_ONLY | cl.mem_flags.COPY_HOST_PTR
        return cl.Buffer(self._device.context, flags, hostbuf=numbers)

    def _lent(self, plane: np.ndarray) -> cl.Buffer:
        """Over a plane's own memory, from its first sample to its last, to be read only."""
        (high, wide), size = plane.shape, plane.itemsize
        length = (high - 1) * (plane.strides[0] // size) + wide
        span = as_strided(plane, (length,), (size,), writeable=False)
        flags = cl.mem_flags.READ_ONLY | cl.mem_flags.USE_HOST_PTR
        return cl.Buffer(self._device.context, flags, hostbuf=span)


@lru_cache
def light_table(transfer: int) -> np.ndarray:
    """Linear light (1024,) float32 of R'G'B' from 0 to 1."""
    steps = np.arange(_STEPS + 1) / _STEPS
    table = to_linear(np.repeat(steps[:, None], 3, axis=1), transfer)[:, 0]
    if transfer == HLG:  # the display's gain comes after the sum (BT.2100: OOTF)
        table = table ** (1 / HLG_GAMMA)
    return table.astype(np.float32)


@lru_cache
def to_steps(coding: Coding, has_colour: bool) -> np.ndarray:
    """(3, 4) from codes to R'G'B' in steps of the table, and a half; a grey frame's chroma is the middle."""
    steps = matrices(coding)[0] * _STEPS
    steps[:, 3] += 0.5
    if not has_colour:
        steps[:, 3] += steps[:, 1:3].sum(1) * 2.0 ** (coding.bit_depth - 1)
        steps[:, 1:3] = 0
    return steps


def _place(place: GridPlace, light: LightPlanes) -> Sequence[float]:
    """A place as surface.cl takes it."""
    a, b, left, c, d, top = place.own_to_px
    size = a * d - b * c
    if not 0 < abs(size) < math.inf:
        return _NOWHERE
    step = math.sqrt(abs(size))
    # a whole px of the frame nearby: what a point is away from it is exact in float32
    x, y = float(round(left)), float(round(top))
    right, down = x - left, y - top
    numbers = [d / size, -b / size, -c / size, a / size, x, y]
    numbers += [(d * right - b * down) / size, (a * down - c * right) / size, 1 / step, step]
    a, b, left, c, d, top = place.to_px
    for across, x, along, y in (light.to_luma, light.to_chroma):
        numbers += [a * across, b * across, left * across + x]
        numbers += [c * along, d * along, top * along + y]
    return numbers


def _plane(plane: np.ndarray) -> Sequence[float]:
    """A plane as surface.cl takes it."""
    high, wide = plane.shape
    less = 1 - 1e-6  # more than float32 rounds away
    return plane.strides[0] // plane.itemsize, (wide - 1) * less, (high - 1) * less


@lru_cache
def _coding(coding: Coding, has_colour: bool) -> tuple[float, ...]:
    """How codes mean light, as surface.cl takes it."""
    weights = to_xyz(coding.primaries)[1]
    return (*to_steps(coding, has_colour).ravel().tolist(), *weights.tolist(), float(_STEPS))
