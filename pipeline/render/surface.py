"""A surface of a face, ready to be painted: the lips, one lid."""

from collections.abc import Mapping
from typing import Any, Protocol, Self

import numpy as np
from makeup_video.pipeline.frames.affine import AffineArray
from makeup_video.pipeline.render.grid import Grid


class Surface(Protocol):
    """One piece of a region on one face.

    grid: where it lies on the frame.  normals: (2, H, W) float32 on the grid, x and y.
    spared: what is so dark that no product lies on it, see `material`.
    keep_highlights: how much of the skin's own highlights stays on the product, 0..1.
    shape: the values of the region's dials by name, as `Layer` has them.
    """

    @property
    def grid(self) -> Grid: ...
    @property
    def normals(self) -> np.ndarray: ...
    @property
    def spared(self) -> float: ...
    @property
    def keep_highlights(self) -> float: ...

    def reach(self, softness: float, shape: Mapping[str, Any]) -> tuple[np.ndarray, np.ndarray]:
        """Lowest and highest px (x, y) of the frame with weight, and some more."""
        ...

    def weigh(
        self,
        out: np.ndarray,
        origin_xy: tuple[int, int],
        softness: float,
        shape: Mapping[str, Any],
    ) -> None:
        """Fill (h, w) float32 with the product's weight, 0..1, on the frame's pixels from
        origin_xy on."""
        ...

    def shaded(self, luminance: np.ndarray) -> tuple[np.ndarray, float]:
        """Luminance on the grid -> the broad light on the grid, and its mean over the surface."""
        ...

    def scaled(self, to_new: AffineArray) -> Self:
        """The same on a picture of another size; to_new: px of the frame -> px of that picture."""
        ...
