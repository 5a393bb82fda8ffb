"""A small grid laid over a part of a frame: its places, step and box."""

from dataclasses import dataclass

import cv2
import numpy as np
from makeup_video.pipeline.frames.affine import AffineArray
from makeup_video.pipeline.frames.sampling import pixel_places, step_px

Box = tuple[int, int, int, int]  # x, y, width, height; empty: 0, 0, 0, 0
PointXY = tuple[float, float]


def box_of(seen: np.ndarray) -> Box:
    """The bounding box of the True pixels of (H, W) bool."""
    x, y, wide, high = cv2.boundingRect(seen.view(np.uint8))
    return x, y, wide, high


@dataclass(frozen=True, slots=True, eq=False)
class Grid:
    """Rows and columns of places on a frame, like the pixels of a small picture.

    to_px: (2, 3) float64, from the grid's pixels (x, y, 1) to the frame's.
    size_wh: how many columns and rows the grid has.
    """

    to_px: AffineArray
    size_wh: tuple[int, int]

    @classmethod
    def at(cls, to_px: tuple[float, ...], hw: tuple[int, ...]) -> "Grid":
        """A grid of rows and columns hw.  to_px: the six numbers of the map, row by row."""
        return cls(np.array((to_px[:3], to_px[3:])), (hw[1], hw[0]))

    def places(self) -> np.ndarray:
        """(2, N) float32: x and y in the frame of all places, row by row."""
        at: np.ndarray = self.to_px.astype(np.float32) @ pixel_places(self.size_wh)
        return at

    def corners_px(self) -> list[list[float]]:
        """The four corners in the frame, (x, y, 0) each."""
        wide, high = self.size_wh
        (a, b, left), (c, d, top) = self.to_px.tolist()
        ends = [(x, y) for x in (0, wide - 1) for y in (0, high - 1)]
        return [[a * x + b * y + left, c * x + d * y + top, 0.0] for x, y in ends]

    def box_px(self, box: Box, more: int) -> tuple[PointXY, PointXY]:
        """Lowest and highest px of the frame around a box of the grid.

        more: the margin on each side, pixels of the grid. For an empty box the highest px are -1.
        """
        x, y, wide, high = box
        if not wide:
            return (0.0, 0.0), (-1.0, -1.0)
        right, down = (wide - 1) / 2 + more, (high - 1) / 2 + more  # from the middle
        middle_x, middle_y = x + (wide - 1) / 2, y + (high - 1) / 2
        (a, b, left), (c, d, top) = self.to_px.tolist()
        at_x, at_y = a * middle_x + b * middle_y + left, c * middle_x + d * middle_y + top
        beside_x, beside_y = abs(a) * right + abs(b) * down, abs(c) * right + abs(d) * down
        return (at_x - beside_x, at_y - beside_y), (at_x + beside_x, at_y + beside_y)

    def warped(
        self,
        values: np.ndarray,
        origin_xy: tuple[int, int],
        hw: tuple[int, ...],
        beyond: float | tuple[float, ...],
    ) -> np.ndarray:
        """Values (H, W) or (H, W, 4) float32 on the frame's pixels from origin_xy on, bilinear.

        beyond: the values outside the grid.
        """
        if isinstance(beyond, float):
            beyond = (beyond,) * 4
        to_px = self.to_px.copy()
        to_px[0, 2] -= origin_xy[0]
        to_px[1, 2] -= origin_xy[1]
        there: np.ndarray = cv2.warpAffine(
            values, to_px, (hw[1], hw[0]), borderMode=cv2.BORDER_CONSTANT, borderValue=beyond
        )
        return there

    def step_px(self) -> float:
        return step_px(self.to_px)


def slopes_along(heights: np.ndarray, step: float) -> np.ndarray:
    """Heights (..., N) at points `step` apart -> their slopes (..., N), as of np.gradient."""
    slopes = np.empty_like(heights)
    slopes[..., 1:-1] = (heights[..., 2:] - heights[..., :-2]) * (0.5 / step)
    slopes[..., 0] = (heights[..., 1] - heights[..., 0]) * (1 / step)
    slopes[..., -1] = (heights[..., -1] - heights[..., -2]) * (1 / step)
    return slopes
