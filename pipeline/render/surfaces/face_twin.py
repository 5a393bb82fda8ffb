"""The surface of a face in numpy: the twin that kernels/face.cl is tested against."""

from functools import cache

import cv2
import numpy as np
from makeup_video.kernels.colour import Coding, to_srgb_primaries
from makeup_video.kernels.face import (
    CHEEK_ACROSS,
    CHEEK_DOWN,
    EDGE_PX,
    FACING,
    HIGHEST,
    HOLE_GAIN,
    HOLE_PX,
    LOWEST,
    MARGIN,
    ON_EDGE,
    SAMPLED,
    SIDE,
    SIGMA_PX,
    STEP,
)
from makeup_video.pipeline.faces.face import Face
from makeup_video.pipeline.frames.frame import Frame
from makeup_video.pipeline.render.grid import Grid
from makeup_video.pipeline.render.light_planes import light_planes
from makeup_video.pipeline.render.luminance_twin import broad, codes_on, linear_rgb, luminance_of
from makeup_video.pipeline.render.skin_likeness_twin import skin_likeness
from makeup_video.pipeline.render.surfaces.face import (
    FaceSurface,
    drawn,
    face_on_grid,
    points_in_iod,
    sampled_down,
)
from makeup_video.pipeline.render.surfaces.face_fit_twin import fit, monomials

# Every second node of every second row.
_SECOND = np.arange(SIDE * SIDE).reshape(SIDE, SIDE)[::2, ::2].ravel()


def face_surface_twin(
    face: Face, frame: Frame, coding: Coding
) -> tuple[FaceSurface, np.ndarray, float] | None:
    """`face_surface` in numpy, the twin of kernels/face.cl."""
    at = face_on_grid(face)
    if at is None:
        return None
    place, grid, on_grid, _ = at
    along, terms = _nodes()
    across, down, x, y, facing = fit(points_in_iod(on_grid)).on(along, along, terms)
    np.clip(facing, 0, 1, out=facing)
    visible = _visible(_shown(*drawn(on_grid)), down, facing)
    light = light_planes(frame, coding, [place], grid.corners_px())
    rgb = linear_rgb(codes_on(light, grid), coding)
    luminance = luminance_of(rgb, coding)
    seen = _samples(visible, down, sampled_down(face), grid, frame)
    to_srgb = to_srgb_primaries(coding.primaries).astype(np.float32)
    likeness = skin_likeness(to_srgb @ rgb, luminance, across.ravel(), down.ravel(), seen)
    normals = np.stack([x, y])
    surface = FaceSurface(
        grid, across, down, normals, facing, visible, likeness.reshape(SIDE, SIDE)
    )
    return surface, *light_on_face(surface, luminance.reshape(SIDE, SIDE))


def light_on_face(surface: FaceSurface, luminance: np.ndarray) -> tuple[np.ndarray, float]:
    """Luminance on the grid -> the broad light on the grid, and its mean over the cheeks."""
    skin = surface.visible * surface.likeness
    (light,), mean = broad(luminance, (skin,), SIGMA_PX)
    aside, down = np.abs(surface.across), surface.down
    (left, right), (top, bottom) = CHEEK_ACROSS, CHEEK_DOWN
    skin *= (aside > left) & (aside < right) & (down > top) & (down < bottom)
    total = float(skin.sum())
    return light, float((luminance * skin).sum()) / total if total >= 1 else mean


@cache
def _nodes() -> tuple[np.ndarray, np.ndarray]:
    """(40,) columns or rows in IOD, and the terms of the fit's cubic at the nodes, (10, 1600)."""
    along = ((np.arange(SIDE) - (SIDE - 1) / 2) * STEP).astype(np.float32)
    x, y = np.meshgrid(along, along)
    terms = monomials(np.column_stack([x.ravel(), y.ravel()]))
    return along, np.ascontiguousarray(terms.T)


def _shown(inside: np.ndarray, holes: np.ndarray) -> np.ndarray:
    """(40, 40) float32, 0..1 and beyond: what the drawn masks leave of each node."""
    part = np.s_[MARGIN:-MARGIN, MARGIN:-MARGIN]
    edge = cv2.GaussianBlur(inside.astype(np.float32), (2 * MARGIN + 1,) * 2, EDGE_PX)[part]
    hole = cv2.GaussianBlur(holes.astype(np.float32), (MARGIN + 1,) * 2, HOLE_PX)[part]
    shown: np.ndarray = np.minimum(_line(edge, ON_EDGE, 255), _line(hole, 255 / HOLE_GAIN, 0))
    return shown


def _line(at: np.ndarray, bare: float, full: float) -> np.ndarray:
    """The straight line that is 0 at `bare` and 1 at `full`; values are not limited to 0..1."""
    share: np.ndarray = (at - np.float32(bare)) * np.float32(1 / (full - bare))
    return share


def _visible(shown: np.ndarray, down: np.ndarray, facing: np.ndarray) -> np.ndarray:
    """(40, 40) float32: `visible` of FaceSurface.  shown: the result of `_shown`."""
    lines = _line(facing, *FACING), _line(down, *HIGHEST), _line(down, *LOWEST)
    visible: np.ndarray = np.clip(np.minimum.reduce([shown, *lines]), 0, 1)
    visible *= visible * (3 - 2 * visible)
    return visible


def _samples(
    visible: np.ndarray, down: np.ndarray, lowest: float, grid: Grid, frame: Frame
) -> np.ndarray:
    """Indices of the nodes that are samples of the skin: each second node of each second row that
    is seen in the picture.

    lowest: the result of `sampled_down`.
    """
    here = visible.take(_SECOND) > SAMPLED
    here &= down.take(_SECOND) < lowest
    x, y = grid.places().take(_SECOND, 1)
    here &= (x > -0.5) & (x < frame.width_px - 0.5) & (y > -0.5) & (y < frame.height_px - 0.5)
    return _SECOND[here]
