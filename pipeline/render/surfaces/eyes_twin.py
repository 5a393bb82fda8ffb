"""The lids' surface in numpy, the twin of kernels/surface.cl; pipeline/reference uses it, too."""

from functools import partial

import numpy as np
from makeup_video.kernels.surface import (
    BROW_POINTS,
    LASH_POINTS,
    LID_BELOW,
    LID_BROW_BELOW,
    LID_BROW_HELD,
    LID_CORNERS,
    LID_FALLS,
    LID_FOLD_LEAST,
    LID_FOLD_UP,
    LID_HELD,
    LID_HW,
    LID_LEAN,
    LID_LEAST,
    LID_LIGHT_BESIDE,
    LID_LIGHT_FROM,
    LID_LIGHT_TO,
    LID_LIT,
    LID_ROUND_TO,
    LID_ROUNDNESS,
    LID_SEEDS,
    LID_SETTLE,
    LID_SIGMA_PX,
    LID_STEEPEST,
    LID_STEP,
    LID_TURNS,
)
from makeup_video.pipeline.faces.face import Face
from makeup_video.pipeline.render.grid import Grid, slopes_along
from makeup_video.pipeline.render.luminance_twin import broad
from makeup_video.pipeline.render.surfaces.both_eyes import COLUMNS, OUTWARDS, SIZE_WH, BothEyes
from makeup_video.pipeline.render.surfaces.eyes import EYE_CURVES, LidSurface, eye_places
from makeup_video.pipeline.render.surfaces.face_outline import parts_on_face

_ROWS = np.arange(SIZE_WH[1], dtype=np.float32)[:, None]
_LIT = slice(8 * LID_LIT[0], 8 * LID_LIT[1])  # columns that light is read for


def lid_surfaces(face: Face) -> list[LidSurface]:
    """The lids of both eyes that are seen, in numpy: the twin of kernels/surface.cl."""
    seen = [eye for eye in _eyes(face) if eye is not None]
    if not seen:
        return []
    # both eyes in one go: (E, ...)
    y, depth = (np.stack(each) for each in zip(*(eye[1:] for eye in seen), strict=True))
    _settle(y[:, ::4])
    ring, up = _heights(y)
    steps_px = np.array([grid.step_px() for grid, *_ in seen], np.float32)[:, None, None]
    lash_px, lower_px = (_distance_px(y[:, curve, None], steps_px) for curve in (0, 4))
    normals = _normals(y, depth, ring)
    widths = [float(step) / LID_STEP for step in steps_px.ravel()]
    grids = [grid for grid, *_ in seen]
    both = BothEyes(up, lash_px, -lower_px, widths, partial(parts_on_face, face, grids))
    return [
        LidSurface(
            grid, up[number], lash_px[number], -lower_px[number], normals[number],
            widths[number], both, number,
        )
        for number, (grid, *_) in enumerate(seen)
    ]  # fmt: skip


def light_on_lid(surface: LidSurface, luminance: np.ndarray) -> tuple[np.ndarray, float]:
    """Luminance on the grid -> the broad light on the grid, and its mean over the lid."""
    is_lid = (surface.up > LID_LIGHT_FROM) & (surface.up < LID_LIGHT_TO)
    is_lid &= np.abs(OUTWARDS) < LID_LIGHT_BESIDE
    (light,), mean = broad(luminance, (is_lid,), LID_SIGMA_PX, _LIT)
    return light, mean


def lid_curves(face: Face) -> list[tuple[Grid, np.ndarray] | None]:
    """The grid of each eye, and its lash line, crease and fold.

    These are (3, 48), rows of the grid by column. The curves are the mesh's own, which meet at the
    corners of the eye. Only photos need them: the kernel makes no such curves. None for an eye that
    is too narrow to be seen.
    """
    return [None if eye is None else (eye[0], eye[1][:3]) for eye in _eyes(face)]


def _eyes(face: Face) -> list[tuple[Grid, np.ndarray, np.ndarray] | None]:
    """The grids of both eyes, with heights and depths of their curves, (5, columns) each; None for
    an eye that is too narrow."""
    eyes: list[tuple[Grid, np.ndarray, np.ndarray] | None] = []
    for place, curves in zip(eye_places(face), EYE_CURVES, strict=True):
        if place is None:
            eyes.append(None)
            continue
        grid = Grid.at(place.to_px, LID_HW)
        yz = np.stack([_curve(grid, face.points_px[curve]) for curve in curves])
        eyes.append((grid, yz.real.astype(np.float32), yz.imag.astype(np.float32)))
    return eyes


def _curve(grid: Grid, points_px: np.ndarray) -> np.ndarray:
    """Points (N, 3), px of the frame -> (columns,) complex: height and depth of a smooth curve
    through them, in steps of the grid."""
    step = grid.step_px()
    there = np.empty(points_px.shape)
    there[:, :2] = (points_px[:, :2] - grid.to_px[:, 2]) @ np.linalg.inv(grid.to_px[:, :2]).T
    there[:, 2] = points_px[:, 2] / step
    x, y, z = (_SMOOTH[len(there)] @ there).T
    curve: np.ndarray = np.interp(COLUMNS, np.maximum.accumulate(x), y + 1j * z)
    return curve


def _settle(lashes: np.ndarray) -> None:
    """Carry lash lines (..., columns) on beyond the corners, in their direction there; in place."""
    inner, outer = LID_CORNERS
    for beyond, at, inside in (
        (inner - COLUMNS, int(inner) + 1, int(inner) + 3),
        (COLUMNS - outer, int(outer), int(outer) - 2),
    ):
        slope = np.clip((lashes[..., at] - lashes[..., inside]) / 2, -1, 1)
        there = np.maximum(beyond, 0)
        lashes += slope[..., None] * (there / (1 + there / LID_SETTLE))


def _heights(y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Rows of the curves (E, 5, columns) -> heights by the rings of the mesh, 1 at the crease and 2
    at the fold, and by `up` of LidSurface; (E, H, W) each."""
    lash, crease, fold, brow = (y[:, curve, None] for curve in range(4))
    apart = crease - fold
    crease = _held(lash - _gap(lash - crease, lash - crease), lash, LID_HELD)
    brow = brow + LID_BROW_BELOW
    fold = crease - np.maximum(_gap(crease - fold, apart), LID_FOLD_LEAST * (crease - brow))
    fold = _held(fold, crease, LID_HELD)
    brow = _held(brow, fold, LID_BROW_HELD)
    ring = (lash - _ROWS) / (lash - crease)
    ring = np.where(ring < 1, ring, 1 + (crease - _ROWS) / (crease - fold))
    up = np.where(ring < 1, ring, 1 + (LID_FOLD_UP - 1) * (ring - 1))
    above = LID_FOLD_UP + (2 - LID_FOLD_UP) * (fold - _ROWS) / (fold - brow)
    return ring, np.where(ring < 2, up, above).astype(np.float32)


def _held(rows: np.ndarray, below: np.ndarray, share: float) -> np.ndarray:
    """The rows of a curve, held on the grid and above the curve below."""
    held: np.ndarray = np.clip(rows, share * below, below - LID_LEAST)
    return held


def _gap(gap: np.ndarray, apart: np.ndarray) -> np.ndarray:
    """The gap below a curve, rows (..., columns), held to at least LID_LEAST. Beyond the corners it
    is also kept from falling far below `apart`, the gap of the mesh's curves, just inside them."""
    held = np.full_like(gap, LID_LEAST)
    for seed, fall, side in zip(LID_SEEDS, LID_FALLS, (-1, 1), strict=True):
        beyond = side * (COLUMNS - seed)
        held = np.where(beyond > 0, np.maximum(held, apart[..., seed, None] - fall * beyond), held)
    at_least: np.ndarray = np.maximum(gap, held)
    return at_least


def _distance_px(lashes: np.ndarray, steps_px: np.ndarray) -> np.ndarray:
    """(E, H, W): how far places lie above lash lines, px of the frame, at right angles to the line.

    lashes: rows, (E, 1, columns).
    """
    slope = slopes_along(lashes, 1)
    above: np.ndarray = (lashes - _ROWS) * (steps_px / np.sqrt(1 + slope * slope))
    return above


def _normals(y: np.ndarray, depth: np.ndarray, ring: np.ndarray) -> np.ndarray:
    """(E, 2, H, W) float32: x and y of the unit normal in the grid's axes; z is to the viewer."""
    columns = np.clip(COLUMNS, LID_TURNS[0], LID_TURNS[1])
    slopes = slopes_along(depth[:, 1], 1)[:, None, columns]
    below_lower = np.clip(_ROWS - y[:, 4, None], 0, 1)
    lash, crease = y[:, :2, columns].swapaxes(0, 1)
    lash_depth, crease_depth = depth[:, :2, columns].swapaxes(0, 1)
    fall = ((crease_depth - lash_depth) / np.minimum(crease - lash, -1))[:, None]
    turned = LID_ROUNDNESS * np.clip(0.5 - ring, 0.5 - LID_ROUND_TO, 0.5) - LID_LEAN
    gy = np.clip(fall, -LID_STEEPEST, LID_STEEPEST) + turned + (LID_BELOW - turned) * below_lower
    gx = np.clip(slopes, -LID_STEEPEST, LID_STEEPEST)
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


_SMOOTH = {count: _catmull_rom(count, 4) for count in (LASH_POINTS, BROW_POINTS)}
