"""Host side of shares.cl: coats on the skin around both eyes, and how much of each is seen.

Its numpy twin is pipeline/render/lay_coats.py.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any
from weakref import WeakKeyDictionary

import numpy as np
import pyopencl as cl
from makeup_video.kernels import colour
from makeup_video.kernels.colour import SRGB
from makeup_video.kernels.definitions import Definitions
from makeup_video.kernels.paint import LAYERS
from makeup_video.kernels.program import Device
from makeup_video.kernels.surface import LID_HW

# Rows of a chart: how many for a height of 1, and the height up to which it reaches.
CHART_ROWS, CHART_HEIGHT = 64, 3
_ROWS = CHART_ROWS * CHART_HEIGHT + 1
FAINTEST = 1 / 512  # a fainter density changes no code
_EYES = 2
KEPT = 16  # most charts of unfolding lids kept for a look: a video may be painted in forty looks
_LOWER = -1  # the key of the chart below an eye; other keys say how far a lid is unfolded
_ONE = 2**16 - 1  # a density of 1 on the device's charts: with 16 bits, they stay in a near cache

# The structs of shares.cl.
GIVEN = np.dtype([
    ("count", np.int32),  # of coats
    ("is_upper", np.int32),  # 1 where a coat lies above the eye
    ("is_lower", np.int32),  # 1 where a coat lies below it
    ("rows_down", np.float32),  # rows of the chart below the eye, for one px of the frame
    ("fade", np.float32),  # per px of the frame: how quickly each side ends beyond the other
    ("opacities", np.float32, LAYERS),
])  # fmt: skip
MADE = np.dtype([
    ("shares", np.float32, (LAYERS, _EYES, *LID_HW)),
    ("density", np.float32, (_EYES, *LID_HW)),
    ("seen", np.float32, (_EYES, LAYERS)),
])  # fmt: skip
DEFINITIONS = colour.DEFINITIONS + Definitions(
    {
        "LID_HIGH": LID_HW[0],
        "LID_WIDE": LID_HW[1],
        "SHARES_COATS": LAYERS,
        "SHARES_ROWS_UP": float(CHART_ROWS),
        "SHARES_LAST_ROW": (_ROWS - 1) * (1 - 1e-6),  # so that the next one exists
        "SHARES_FAINTEST": FAINTEST,
        "SHARES_ONE": float(_ONE),
    },
    {"shares_given": GIVEN, "shares_made": MADE},
)


@dataclass(frozen=True, slots=True, eq=False)
class EyesToLay:
    """The eyes of a face, one or two, (eyes, 32, 48) float32 each.

    up: heights above the upper lash line.  lash_px, below_px: px of the frame above the upper and
    below the lower lash line.
    rows_down, fades: of each eye: see GIVEN.  steps: how far each lid is unfolded.
    """

    up: np.ndarray
    lash_px: np.ndarray
    below_px: np.ndarray
    rows_down: Sequence[float]
    fades: Sequence[float]
    steps: Sequence[int]


class ShareKernel:
    """Runs the kernel for the eyes of one face at a time, on a device that no other thread uses.

    Its memory is kept, so that the kernel keeps its arguments.
    """

    def __init__(self, device: Device) -> None:
        self._device = device
        self._given, self._made = device.memory((_EYES,), GIVEN), device.memory((1,), MADE)
        # views of its fields: writing whole records takes numpy several times as long
        numbers = self._given.array.view(np.float32).reshape(_EYES, -1)
        self._flags, self._steps = numbers[:, :3].view(np.int32), numbers[:, 3:5]
        self._opacities = numbers[:, 5:]
        self._lids = device.memory((3, _EYES, *LID_HW), np.float32)
        self._lids.array.fill(0)
        made = self._made.array[0]
        self._shares, self._density, self._seen = made["shares"], made["density"], made["seen"]
        self._charts: WeakKeyDictionary[Any, dict[int, cl.Buffer]] = WeakKeyDictionary()
        self._kernel = device.kernel("shares", SRGB, np.dtype(np.uint8), DEFINITIONS)
        self._kernel.set_arg(0, self._given.buffer)
        self._kernel.set_arg(4, self._lids.buffer)
        self._kernel.set_arg(5, self._made.buffer)

    def __call__(
        self, look: object, charts: tuple[Callable[[int], np.ndarray] | None, np.ndarray | None],
        opacities: Sequence[float], eyes: EyesToLay,
    ) -> tuple[np.ndarray, list[list[float]], np.ndarray]:  # fmt: skip
        """Lay coats around both eyes.

        look: the object that the charts belong to. They are copied to the device, and the last of
        them are kept as long as this object lives.
        charts: for the skin above an eye, a function of how far the lid is unfolded; for the skin
        below it, an array; each chart is (193, 48, N) float32, 0..1. None where no coat lies, but
        not both.  opacities: of the N coats, 1 to LAYERS, in the order of painting.
        Returns how much of each coat shows, (N, eyes, 32, 48); the sums of that, by eye and coat;
        and (eyes, 32, 48), 1 where there is any coat. For a single coat the first is empty, (0,
        eyes, 32, 48), and the last is its density.
        """
        count, (upper, lower) = len(opacities), charts
        number, lids = len(eyes.up), self._lids.array
        self._flags[:number] = count, upper is not None, lower is not None
        self._steps[:number, 0], self._steps[:number, 1] = eyes.rows_down, eyes.fades
        self._opacities[:number, :count] = opacities
        lids[0, :number] = eyes.up
        if lower is not None:
            lids[1, :number], lids[2, :number] = eyes.lash_px, eyes.below_px
        packed = self._charts.get(look)
        if packed is None:
            packed = self._charts[look] = {}
        if lower is not None and _LOWER not in packed:
            packed[_LOWER] = self._packed(lower)
        if upper is not None:
            for step in eyes.steps:
                if step not in packed:
                    if len(packed) > KEPT:
                        used = _LOWER, *eyes.steps
                        del packed[next(key for key in packed if key not in used)]
                    packed[step] = self._packed(upper(step))
        # any chart will do for a side without coats: the kernel does not read it
        above = [packed[_LOWER if upper is None else step] for step in eyes.steps]
        below = above[0] if lower is None else packed[_LOWER]
        for at, buffer in enumerate((above[0], above[-1], below), 1):
            self._kernel.set_arg(at, buffer)
        for memory in (self._given, self._lids):
            memory.send()
        self._device.launch(self._kernel, (number, 1), (), (1, 1))
        self._made.fetch()
        self._device.finish()
        shares = self._shares[: count if count > 1 else 0, :number].copy()
        return shares, self._seen[:number, :count].tolist(), self._density[:number].copy()

    def _packed(self, chart: np.ndarray) -> cl.Buffer:
        """All coats of a place together, as the kernel reads them."""
        packed = np.zeros((_ROWS, LID_HW[1], LAYERS), np.uint16)
        packed[..., : chart.shape[2]] = np.rint(chart * np.float32(_ONE))
        flags = cl.mem_flags.READ_ONLY | cl.mem_flags.COPY_HOST_PTR
        return cl.Buffer(self._device.context, flags, hostbuf=packed)
