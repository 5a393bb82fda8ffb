"""A surface of a face, ready to be painted: the lips, one side of an eye, the whole face."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Any, NamedTuple, Protocol, Self

import numpy as np
from makeup_video.kernels.program import Device
from makeup_video.pipeline.frames.affine import AffineArray
from makeup_video.pipeline.render.grid import Grid, PointXY


@dataclass(frozen=True, slots=True, eq=False, weakref_slot=True)
class Charts:
    """The densities of coats, drawn once for a look.

    on_sides: a chart (h, w, coats) float32, 0..1, for each side; None where no coat lies, but not
    for all sides.
    unfolded: charts made of the first side's for lids that unfold, by step, see unfolded.py.
    """

    on_sides: tuple[np.ndarray | None, ...]
    unfolded: dict[int, np.ndarray] = field(default_factory=dict)


class Laid(NamedTuple):
    """Coats on all N surfaces of a region.

    shares: (coats, N, H, W) float32, how much of each shows; None for a single coat.
    seen: by surface and coat, the sums of the shares.
    density: (N, H, W) float32, or N arrays: the density of a single coat; of several coats 1 where
    any of them lies.
    """

    shares: np.ndarray | None
    seen: Sequence[Sequence[float]]
    density: np.ndarray | Sequence[np.ndarray]


class Edge(NamedTuple):
    """How a product ends at the border of a surface.

    softness: 0..1, `edge_softness` of the product.
    wider: 0..1, how far the product goes beyond the border; 1 is as far as the palest may.
    sigma_px: the blur of the picture that is painted, in its px, see softness.py.
    """

    softness: float
    wider: float = 0.0
    sigma_px: float = 0.0


class Surface(Protocol):
    """One surface of one face. A region of a face may have several of the same sort: two eyes.

    grid: where the surface lies on the frame.
    normals: (2 or 3, H, W) float32 on the grid, x and y, and how exposed they are, see MadeRegion.
    number: which of its region's surfaces it is.
    is_broad: True where makeup is a soft veil, with no border that must be sharp.
    """

    @property
    def grid(self) -> Grid: ...
    @property
    def normals(self) -> np.ndarray: ...
    @property
    def number(self) -> int: ...
    @property
    def is_broad(self) -> bool: ...

    def sides(self) -> "Sequence[Surface]":
        """The parts of the surface that are painted one by one: skin above an eye, and below it."""
        ...

    def side_of(self, charts: Charts) -> "Surface":
        """The side where coats lie; all sides as one surface where they lie on several."""
        ...

    def lay(self, charts: Charts, opacities: Sequence[float], device: Device) -> Laid:
        """Lay coats on all surfaces of the region.  opacities: of the coats, 0..1."""
        ...

    def join(self, on_sides: Sequence[np.ndarray]) -> np.ndarray:
        """Join densities on the sides, in their order, to those on the joined surface.

        on_sides: (coats, N, H, W) each, at the places of all surfaces of the region.
        """
        ...

    def fields(self) -> Any:
        """Where the grid's places lie on the face, for kinds of makeup: an object of
        look/kinds/fields.py. Its arrays hold all N surfaces of the region, so that densities
        (N, H, W) are made at once."""
        ...

    @property
    def chart(self) -> Any:
        """The fields of the places on this side's chart, (1, h, w), where densities are drawn once
        for a look. It is the same object for all faces."""
        ...

    def charts_of(self, charts: Charts) -> Sequence[np.ndarray]:
        """The chart of this side for each surface of the region, or one for all of them."""
        ...

    def on_chart(self) -> tuple[np.ndarray, np.ndarray]:
        """Where the places of all surfaces of the region lie on the chart: x and y, (N * H, W)
        float32, in px of the chart."""
        ...

    def reach(self, edge: Edge, density: np.ndarray | None) -> tuple[PointXY, PointXY]:
        """Lowest and highest px of the frame with weight, with a margin."""
        ...

    def weigh(
        self,
        out: np.ndarray,
        origin_xy: tuple[int, int],
        edge: Edge,
        density: np.ndarray | None,
    ) -> None:
        """Fill (h, w) float32 with the weight of makeup, 0..1, on the frame's pixels from
        origin_xy on: what the surface itself allows, times the density (H, W) on the grid."""
        ...

    def scaled(self, to_new: AffineArray) -> Self:
        """The surface on a picture of another size.  to_new: px of the frame -> px of it."""
        ...
