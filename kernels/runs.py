"""Which pixels of a canvas are painted: runs of a row, or of a few, that hold any weight."""

from collections.abc import Sequence

import numpy as np
from makeup_video.kernels.program import Device

# Pixels of a row that a work-group paints. PoCL works on eight at once, and longer runs hold more
# pixels without makeup.
RUN = 8
_PIECE = 256  # runs: OpenBLAS sums so few in one thread
_ONES = np.ones(RUN, np.float32)


class Coat:
    """What is painted on the rectangles of a canvas in one go: weights, and the runs that hold any.

    numbers: of its regions.  used_rows: of the canvas.
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

    def list_runs(self, runs: np.ndarray, have_layers: Sequence[bool]) -> None:
        """List runs for the kernels: of regions without layers, and with them.

        have_layers: of all regions.
        """
        plain, layered = self.runs
        if True in [have_layers[number] for number in self.numbers]:
            of_row = self.rows.array[runs // (self._stride // RUN)]
            has_layers = np.array(have_layers)[of_row]
            composed = runs[has_layers]
            layered.array[: len(composed)] = composed
            runs = runs[~has_layers]
            self.counts = [len(runs), len(composed)]
        else:
            self.counts = [len(runs), 0]
        plain.array[: len(runs)] = runs

    def send(self) -> None:
        for memory in (*self.runs, self.rows):
            memory.send()
