"""Luminance on grids, and the broad light on surfaces, in numpy: what twins of kernels share."""

from collections.abc import Sequence

import cv2
import numpy as np
from makeup_video.kernels.colour import HLG, HLG_GAMMA, Coding, to_xyz
from makeup_video.kernels.light import LightPlanes, light_table, to_steps
from makeup_video.kernels.surface import FAINT, GridPlace
from makeup_video.pipeline.frames.affine import compose
from makeup_video.pipeline.frames.frame import Frame
from makeup_video.pipeline.frames.sampling import warp
from makeup_video.pipeline.render.grid import Grid
from makeup_video.pipeline.render.light_planes import light_planes


def luminances(frame: Frame, coding: Coding, grids: list[Grid]) -> list[np.ndarray]:
    """Linear luminance on each grid, (H, W) float32; beyond the frame its border is repeated.

    The grids must lie close together and have about the same step, since all are read from one part
    of the frame. kernels/surface.cl does the same, but reads chroma in blocks of 2x2 px of a grid.
    """
    numbers = [tuple(grid.to_px.ravel().tolist()) for grid in grids]
    places = [GridPlace(to_px, to_px) for to_px in numbers]
    corners = [corner for grid in grids for corner in grid.corners_px()]
    light = light_planes(frame, coding, places, corners, around=0)
    return [
        linear_luminance(codes_on(light, grid), coding).reshape(grid.size_wh[::-1])
        for grid in grids
    ]


def codes_on(light: LightPlanes, grid: Grid) -> np.ndarray:
    """The codes at the places of a grid, bilinear: (3, N) float32, or (1, N) for a grey frame."""
    rows = []
    for plane, (across, x, down, y) in zip(
        light.planes, (light.to_luma, light.to_chroma, light.to_chroma), strict=True
    ):
        to_plane = compose(np.array([[across, 0, x], [0, down, y]]), grid.to_px)
        rows.append(warp(plane.astype(np.float32), to_plane, grid.size_wh).reshape(-1))
    return np.stack(rows if light.has_colour else rows[:1])


def linear_luminance(codes: np.ndarray, coding: Coding) -> np.ndarray:
    """(3, N) codes, or (1, N) of a grey frame -> luminance, (N,) float32.

    The error is at most 0.3 % of a step of 8 bits.
    """
    return luminance_of(linear_rgb(codes, coding), coding)


def linear_rgb(codes: np.ndarray, coding: Coding) -> np.ndarray:
    """(3, N) codes, or (1, N) of a grey frame -> linear light, (3, N) float32, frame's primaries.

    For HLG this is the light of the scene, without the gain of a display.
    """
    to = to_steps(coding, len(codes) > 1).astype(np.float32)
    steps = to[:, : len(codes)] @ codes.astype(np.float32) + to[:, 3:]
    rgb: np.ndarray = light_table(coding.transfer).take(steps.astype(np.intp), mode="clip")
    return rgb


def luminance_of(rgb: np.ndarray, coding: Coding) -> np.ndarray:
    """The result of `linear_rgb` -> luminance, (N,) float32; for HLG the luminance of a display."""
    light: np.ndarray = to_xyz(coding.primaries)[1].astype(np.float32) @ rgb
    return light ** np.float32(HLG_GAMMA) if coding.transfer == HLG else light


def broad(
    light: np.ndarray,
    areas: Sequence[np.ndarray],
    sigma_px: float,
    read: slice = slice(None),
) -> tuple[list[np.ndarray], float]:
    """Light blurred within each of one or two areas, and the mean light over all of them.

    light: (H, W) float32. areas: (H, W) bool or shares 0..1, together 1 at most. read: the columns
    whose mean is returned when the areas are empty.
    """
    weights = [area.astype(np.float32, copy=False) for area in areas]
    inside = sum(weights[1:], weights[0])
    total = float(inside.sum())
    mean = float((light * inside).sum() / total) if total >= 1 else float(light[:, read].mean())
    layers = [layer for weight in weights for layer in (light * weight, weight)]
    blurred = cv2.GaussianBlur(cv2.merge(layers), (0, 0), sigma_px)
    faint = np.float32(FAINT)
    return [
        (blurred[..., at] + faint * np.float32(mean)) / (blurred[..., at + 1] + faint)
        for at in range(0, len(layers), 2)
    ], mean
