"""The lids' surface in numpy: the reference that kernels/surface.cl is tested against."""

import numpy as np
from makeup_video.kernels.surface import LASH_POINTS, LID_HW, LID_ROUNDNESS, LID_STEEPEST
from makeup_video.pipeline.faces.face import Face
from makeup_video.pipeline.faces.topology import EYE, RIGHT_EYE
from makeup_video.pipeline.render.grid import Grid, slopes_along
from makeup_video.pipeline.render.surfaces.eyes import (
    COLUMNS,
    CURVES,
    OUTWARDS,
    SIZE_WH,
    LidSurface,
    ZoneWeights,
    eye_places,
)

_ROWS = np.arange(SIZE_WH[1], dtype=np.float32)[:, None]


def lid_surfaces(face: Face) -> list[LidSurface]:
    """The lids of both eyes that are seen, in numpy: the twin of kernels/surface.cl."""
    seen = [eye for eye in _eyes(face) if eye is not None]
    if not seen:
        return []
    # both eyes in one go: (E, ...)
    y, depth = _curves(np.stack([points for _, points in seen]))
    lash, crease, brow = (height[:, None] for height in _apart(y))
    over = (lash - _ROWS) / (lash - crease)
    height = np.where(over < 1, over, 1 + (crease - _ROWS) / (crease - brow))
    slope = slopes_along(lash, 1)
    steps_px = np.array([grid.step_px() for grid, _ in seen], np.float32)[:, None, None]
    lash_px = (lash - _ROWS) * (steps_px / np.sqrt(1 + slope * slope))
    normals = _normals(y, depth, height)
    zones = ZoneWeights(height)
    return [
        LidSurface(grid, height[number], lash_px[number], OUTWARDS, normals[number], zones, number)
        for number, (grid, _) in enumerate(seen)
    ]


def lid_curves(face: Face) -> list[tuple[Grid, np.ndarray] | None]:
    """For both eyes, each with its grid: lash line, crease and brow, (3, 40) rows of the grid by
    column.

    None for an eye that is too narrow to be seen.
    """
    curves: list[tuple[Grid, np.ndarray] | None] = []
    for eye in _eyes(face):
        if eye is None:
            curves.append(None)
        else:
            grid, points = eye
            curves.append((grid, np.concatenate(_apart(_curves(points[None])[0]))))
    return curves


def _eyes(face: Face) -> list[tuple[Grid, np.ndarray] | None]:
    """The grids of both eyes, and their points (48, 3) there; None for one that is too narrow."""
    eyes: list[tuple[Grid, np.ndarray] | None] = []
    for place, points in zip(eye_places(face), (EYE, RIGHT_EYE), strict=True):
        if place is None:
            eyes.append(None)
            continue
        grid, points_px = Grid.at(place.to_px, LID_HW), face.points_px[points]
        there = np.empty(points_px.shape)
        step = grid.step_px()
        there[:, :2] = (points_px[:, :2] - grid.to_px[:, 2]) @ (grid.to_px[:, :2] / step**2)
        there[:, 2] = points_px[:, 2] / step
        eyes.append((grid, there))
    return eyes


def _apart(y: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """(E, 3, columns) -> rows of lash line, crease and brow, (E, columns), a row apart at least."""
    lash = y[:, 0]
    crease = np.minimum(y[:, 1], lash - 1)
    return lash, crease, np.minimum(y[:, 2], crease - 1)


def _curves(points: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """(E, 48, 3) on the grid -> heights and depths (E, 3, columns) of lash line,
    crease and brow."""
    smooth = (_SMOOTH @ points[:, CURVES])[:, :, ::-1]
    x = np.maximum.accumulate(smooth[..., 0], axis=2).reshape(-1, len(_SMOOTH))
    yz = (smooth[..., 1] + 1j * smooth[..., 2]).reshape(-1, len(_SMOOTH))  # np.interp takes both
    curves = np.stack([np.interp(COLUMNS, *curve) for curve in zip(x, yz, strict=True)])
    curves = curves.reshape(len(points), 3, -1)
    return curves.real.astype(np.float32), curves.imag.astype(np.float32)


def _normals(y: np.ndarray, depth: np.ndarray, height: np.ndarray) -> np.ndarray:
    """(E, 2, H, W) float32, x and y of the unit normal in the grid's axes; z is
    towards the viewer."""
    falls = (depth[:, 1:] - depth[:, :-1]) / np.minimum(y[:, 1:] - y[:, :-1], -1)
    falls = np.clip(falls, -LID_STEEPEST, LID_STEEPEST)
    below, above = falls[:, 0, None], falls[:, 1, None]
    gy = below + (above - below) * np.clip(height - 0.5, 0, 1)
    gy += LID_ROUNDNESS * np.clip(0.5 - height, -0.5, 0.5)
    gx = np.clip(slopes_along(depth[:, 1, None], 1), -LID_STEEPEST, LID_STEEPEST)
    shrink = 1 / np.sqrt(1 + gx * gx + gy * gy)
    return np.stack([gx * shrink, gy * shrink], axis=1)


def _catmull_rom(count: int, between: int) -> np.ndarray:
    """(M, count): from points to a smooth curve through them (Catmull and Rom, 1974)."""
    rows = []
    for at in np.linspace(0, count - 1, (count - 1) * between + 1):
        i = min(int(at), count - 2)
        t = at - i
        taps = 0.5 * np.array([
            -t + 2*t**2 - t**3, 2 - 5*t**2 + 3*t**3, t + 4*t**2 - 3*t**3, -(t**2) + t**3,
        ])  # fmt: skip
        row = np.zeros(count)
        for offset, tap in zip(range(-1, 3), taps, strict=True):
            row[min(max(i + offset, 0), count - 1)] += tap
        rows.append(row)
    return np.stack(rows)


_SMOOTH = _catmull_rom(LASH_POINTS, 4)
