"""The broad light and dark of a small part of a frame, read straight from its planes."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np
from makeup_video.kernels.colour import HLG, Coding, matrices, to_linear, to_xyz
from makeup_video.pipeline.crop import Affine, pixel_places, samples_at, step_px
from makeup_video.pipeline.frame import Frame

_STEPS = 1023  # of R'G'B' from 0 to 1, in the table of its light


@dataclass(frozen=True, slots=True, eq=False)
class Grid:
    """Places on a frame, a small picture of rows and columns.

    to_px: (2, 3) float64, from the grid's pixels (x, y, 1) to the frame's. size_wh: its size.
    """

    to_px: Affine
    size_wh: tuple[int, int]

    def places(self) -> np.ndarray:
        """(2, N) float32, x and y in the frame, row by row."""
        at: np.ndarray = self.to_px.astype(np.float32) @ pixel_places(self.size_wh)
        return at

    def box_px(self, seen: np.ndarray, more: int) -> tuple[np.ndarray, np.ndarray]:
        """Lowest and highest px (x, y) of the frame around what is True on the grid.

        more: pixels of the grid on each side. Where nothing is True the highest lie below 0.
        """
        across, down = np.flatnonzero(seen.any(0)), np.flatnonzero(seen.any(1))
        if not len(across):
            return np.zeros(2), np.full(2, -1.0)
        left, right = across[0] - more, across[-1] + more
        top, bottom = down[0] - more, down[-1] + more
        ends = np.array([[left, right, left, right], [top, top, bottom, bottom], [1, 1, 1, 1]])
        corners = self.to_px @ ends
        return corners.min(1), corners.max(1)

    def step_px(self) -> float:
        return step_px(self.to_px)


def luminances(frame: Frame, coding: Coding, grids: list[Grid]) -> list[np.ndarray]:
    """Linear luminance on each grid, (H, W) float32; beyond the frame its border is repeated.

    The grids lie close together and have about the same step: they are read at once.
    """
    places = np.concatenate([grid.places() for grid in grids], axis=1)
    step = max(grid.step_px() for grid in grids)
    light = linear_luminance(np.concatenate(samples_at(frame, places, step)), coding)
    ends = np.cumsum([w * h for w, h in (grid.size_wh for grid in grids)])[:-1]
    return [
        part.reshape(grid.size_wh[::-1])
        for part, grid in zip(np.split(light, ends), grids, strict=True)
    ]


def linear_luminance(codes: np.ndarray, coding: Coding) -> np.ndarray:
    """(3, N) codes, or (1, N) of a grey frame -> (N,) float32, within 0.3 % of a step of 8 bits."""
    to_steps, table, weights = _tables(coding)
    steps = to_steps[:, : len(codes)] @ codes.astype(np.float32)
    offset = to_steps[:, 3:]
    if len(codes) == 1:
        offset = offset + to_steps[:, 1:3].sum(1, keepdims=True) * 2.0 ** (coding.bit_depth - 1)
    steps += offset
    light: np.ndarray = weights @ table.take(steps.astype(np.intp), mode="clip")
    return light ** np.float32(1.2) if coding.transfer == HLG else light


@lru_cache
def _tables(coding: Coding) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Codes to R'G'B' in 1/1023, and a half (3, 4); its light; weights of luminance (3,)."""
    steps = np.arange(_STEPS + 1) / _STEPS
    table = to_linear(np.repeat(steps[:, None], 3, axis=1), coding.transfer)[:, 0]
    if coding.transfer == HLG:  # the display's gain comes after the sum (BT.2100: OOTF)
        table = table ** (1 / 1.2)
    weights = to_xyz(coding.primaries)[1]
    to_steps = matrices(coding)[0] * _STEPS
    to_steps[:, 3] += 0.5
    return (
        to_steps.astype(np.float32),
        table.astype(np.float32),
        weights.astype(np.float32),
    )


def broad(
    light: np.ndarray, areas: Sequence[np.ndarray], sigma_px: float
) -> tuple[list[np.ndarray], float]:
    """Light blurred within each of one or two areas, and its mean over all; of everything without any.

    light: (H, W) float32. areas: (H, W) bool or shares 0..1, together 1 at most.
    """
    weights = [area.astype(np.float32, copy=False) for area in areas]
    inside = sum(weights[1:], weights[0])
    total = float(inside.sum())
    mean = float((light * inside).sum() / total) if total >= 1 else float(light.mean())
    layers = [layer for weight in weights for layer in (light * weight, weight)]
    blurred = cv2.GaussianBlur(cv2.merge(layers), (0, 0), sigma_px)
    faint = np.float32(0.02)  # far from the area the mean counts
    return [
        (blurred[..., at] + faint * np.float32(mean)) / (blurred[..., at + 1] + faint)
        for at in range(0, len(layers), 2)
    ], mean


def slopes_along(heights: np.ndarray, step: float) -> np.ndarray:
    """(..., N) -> (..., N): their slope, as np.gradient has it, for points `step` apart."""
    slopes = np.empty_like(heights)
    slopes[..., 1:-1] = (heights[..., 2:] - heights[..., :-2]) * (0.5 / step)
    slopes[..., 0] = (heights[..., 1] - heights[..., 0]) * (1 / step)
    slopes[..., -1] = (heights[..., -1] - heights[..., -2]) * (1 / step)
    return slopes
