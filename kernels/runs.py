"""Which pixels of a canvas are painted: runs, one or a few rows high, that hold any weight."""

from collections.abc import Sequence

import numpy as np
from makeup_video.kernels.program import Device

# Pixels of a row that a work-group paints. PoCL works on eight at once, and longer runs hold more
# pixels without makeup.
RUN = 8
_PIECE = 256  # runs: few enough for OpenBLAS to sum them in one thread
_ONES = np.ones(RUN, np.float32)


class WeightRuns:
    """One coat on the rectangles of a canvas: its weights, and the runs that hold any weight.

    numbers: of the coat's regions.  used_rows: rows of the canvas that the coat uses.
    """

    def __init__(self, device: Device, weights: np.ndarray, down: int) -> None:
        """weights: (rows, stride) float32 of the canvas.  down: rows of luma in a block."""
        rows, self._stride = weights.shape
        self.weights, self._down = weights, down
        self.rows = device.memory((rows // down,), np.int32)
        count = rows // down * self._stride // RUN
        # of regions without layers, and with them
        self.runs = device.memory((count,), np.int32), device.memory((count,), np.int32)
        self.counts = [0, 0]
        self.numbers: list[int] = []
        self.used_rows = 0

    def has_weight(self) -> np.ndarray:
        """(N,) bool: the runs up to the last row used, True for those that hold any weight."""
        weights = self.weights[: self.used_rows]
        in_row = self._stride // RUN
        rows = (weights.reshape(-1, _PIECE, RUN) @ _ONES).reshape(-1, self._down, in_row)
        of_blocks = rows[:, 0]
        for row in range(1, self._down):
            of_blocks = of_blocks + rows[:, row]
        has_weight: np.ndarray = (of_blocks > 0).ravel()
        return has_weight

    def list_runs(
        self, runs: np.ndarray, first_rows: Sequence[int], have_layers: Sequence[bool]
    ) -> None:
        """List runs for the kernels: of regions without layers, and with them.

        runs: (N,), ascending.  first_rows, have_layers: of all regions; those of this coat follow
        each other down the canvas.
        """
        in_row = self._stride // RUN
        firsts = [first_rows[number] // self._down * in_row for number in self.numbers]
        ends = [*runs.searchsorted(firsts[1:]).tolist(), len(runs)]
        counts, begin = [0, 0], 0
        for number, end in zip(self.numbers, ends, strict=True):
            kind = int(have_layers[number])
            count = counts[kind] + end - begin
            self.runs[kind].array[counts[kind] : count] = runs[begin:end]
            counts[kind], begin = count, end
        self.counts = counts

    def send(self) -> None:
        for memory in (*self.runs, self.rows):
            memory.send()
