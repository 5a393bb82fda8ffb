"""The broad light and dark of a small part of a frame, read straight from its planes."""

import math
from collections.abc import Sequence

import cv2
import numpy as np
from makeup_video.kernels.colour import HLG, HLG_GAMMA, Coding, to_xyz
from makeup_video.kernels.light import LightPlanes, Stretch, light_table, to_steps
from makeup_video.kernels.surface import FAINT, GridPlace
from makeup_video.pipeline.frames.frame import Frame
from makeup_video.pipeline.frames.sampling import halved, samples_at
from makeup_video.pipeline.render.grid import Grid

_AROUND = 0.08  # of what the points cover: farther away light counts for nothing


def light_planes(
    frame: Frame,
    coding: Coding,
    places: Sequence[GridPlace],
    points_px: list[list[float]],
    around: float = _AROUND,
) -> LightPlanes:
    """The part of a frame's planes around some points (x, y, z), to read light from on grids.

    Planes more than twice as fine as the grids are averaged, 2x2, 4x4, ...
    around: how far around the points, as a share of what they cover.
    """
    x, y, _ = zip(*points_px, strict=True)
    x0, y0, x1, y1 = min(x), min(y), max(x), max(y)
    more = around * max(x1 - x0, y1 - y0)
    lows, highs = (x0 - more, y0 - more), (x1 + more, y1 + more)
    step = max(abs(a * e - b * d) ** 0.5 for a, b, _, d, e, _ in (p.to_px for p in places))
    planes, chroma = frame.planes, frame.chroma
    (luma,), to_luma = _near(planes[:1], lows, highs, (1, 1), step)
    if len(planes) < 2:
        return LightPlanes((luma, luma, luma), to_luma, to_luma, coding, has_colour=False)
    both, to_chroma = _near(planes[1:3], lows, highs, chroma, step)
    cb, cr = both if len(both) == 2 else cv2.split(both[0])  # NV12 keeps both in one plane
    return LightPlanes((luma, cb, cr), to_luma, to_chroma, coding)


def _near(
    planes: Sequence[np.ndarray],
    low_xy: tuple[float, float],
    high_xy: tuple[float, float],
    chroma: tuple[int, int],
    step: float,
) -> tuple[list[np.ndarray], Stretch]:
    """The part of planes of one size around px of the frame, averaged where `step` is large, and
    the map from px of the frame to px of that part.

    chroma: px of the frame for one of the planes.
    """
    high, wide = planes[0].shape[:2]
    step /= math.sqrt(chroma[0] * chroma[1])
    size = 1
    while step > 2 * size and 4 * size <= min(wide, high):
        size *= 2
    left, right, to_x = _span(low_xy[0], high_xy[0], chroma[0], size, wide)
    top, bottom, to_y = _span(low_xy[1], high_xy[1], chroma[1], size, high)
    parts = [halved(plane[top:bottom, left:right], size) for plane in planes]
    if min(wide, high) < 2:
        parts = [cv2.copyMakeBorder(part, 0, 1, 0, 1, cv2.BORDER_REPLICATE) for part in parts]
    return parts, (*to_x, *to_y)


def _span(
    low: float, high: float, share: int, size: int, length: int
) -> tuple[int, int, tuple[float, float]]:
    """First and last px of a plane around low..high px of a frame, and the map from the frame to
    boxes.

    The span is made of whole boxes of `size` px, so that averages do not shift with the face.
    share: px of the frame for one of the plane.
    """
    scale, last = 1 / (share * size), length // size - 1
    first = min(max(int(low * scale) - 2, 0), max(last - 1, 0))
    end = min(max(int(high * scale) + 3, first + 2), last + 1)
    return first * size, end * size, (scale, 0.5 * scale - 0.5 - first)


def luminances(frame: Frame, coding: Coding, grids: list[Grid]) -> list[np.ndarray]:
    """Linear luminance on each grid, (H, W) float32; beyond the frame its border is repeated.

    The grids lie close together and have about the same step: they are read at once. Nearly the
    twin of kernels/surface.cl, which does not round on the way and reads less of the chroma.
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
    return luminance_of(linear_rgb(codes, coding), coding)


def linear_rgb(codes: np.ndarray, coding: Coding) -> np.ndarray:
    """(3, N) codes, or (1, N) of a grey frame -> (3, N) float32 linear light in the frame's own
    primaries; of HLG the scene's light, without the gain of a display."""
    to = to_steps(coding, len(codes) > 1).astype(np.float32)
    steps = to[:, : len(codes)] @ codes.astype(np.float32) + to[:, 3:]
    rgb: np.ndarray = light_table(coding.transfer).take(steps.astype(np.intp), mode="clip")
    return rgb


def luminance_of(rgb: np.ndarray, coding: Coding) -> np.ndarray:
    """What `linear_rgb` gives -> luminance, (N,) float32; of HLG that of a display."""
    light: np.ndarray = to_xyz(coding.primaries)[1].astype(np.float32) @ rgb
    return light ** np.float32(HLG_GAMMA) if coding.transfer == HLG else light


def broad(
    light: np.ndarray,
    areas: Sequence[np.ndarray],
    sigma_px: float,
    read: slice = slice(None),
) -> tuple[list[np.ndarray], float]:
    """Light blurred within each of one or two areas, and its mean over them, or over the columns
    `read` if they are empty.

    light: (H, W) float32. areas: (H, W) bool or shares 0..1, together 1 at most.
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
