"""The numpy twin of the fit in kernels/face.cl.

The fit finds where each place of a face's picture lies on the mean face, and how the face is turned
there. Points of the face tell this only where they lie. Between them a cubic in the picture's x and
y holds for the whole face, and a sum of Gaussians around points adds what the cubic misses.
Both come from one solve: a Gaussian process with these two as its covariance (Rasmussen and
Williams 2006, 2.7).
Points that turn away from the viewer, or that another part of the face hides (the cheek behind the
nose), count for next to nothing.
"""

from dataclasses import dataclass

import numpy as np
from makeup_video.kernels.face import (
    CLOSE,
    CUBIC,
    DEGREE,
    FARTHEST,
    HIDES,
    LEAST,
    MOST_OFF,
    NEARER,
    NOISE,
    POINT_FACING,
    SIGMA,
    FitTables,
)
from makeup_video.pipeline.render.surfaces.face_points import fit_tables, products


@dataclass(frozen=True, slots=True, eq=False)
class FaceFit:
    """Five smooth functions of the picture: across, down, and x, y and facing of the normal.

    xy: (P, 2) float32, the points in the picture, in IOD.
    cubic: (5, 10), coefficients.  bumps: (5, P), heights of the Gaussians.
    """

    xy: np.ndarray
    cubic: np.ndarray
    bumps: np.ndarray

    def on(self, columns: np.ndarray, rows: np.ndarray, cubics: np.ndarray) -> np.ndarray:
        """(5, H, W) float32 on a grid of columns (W,) and rows (H,) in IOD.

        cubics: (10, H * W), `monomials` of the grid, transposed.
        """
        near_x = _gaussian(columns[:, None] - self.xy[:, 0])
        near_y = _gaussian(rows[:, None] - self.xy[:, 1])
        # one product for each field: OpenBLAS would spread one large product over all cores
        fields: np.ndarray = (self.bumps[:, None] * near_y) @ near_x.T
        fields += (self.cubic @ cubics).reshape(fields.shape)
        return fields


def fit(points: np.ndarray) -> FaceFit:
    """Fit the functions to a face.

    points: (P, 3) float32, `fit_points` of the face in IOD, turned upright; z away from the viewer.
    """
    model = fit_tables()
    points = points.clip(-MOST_OFF, MOST_OFF)
    normals = _normals(points, model)
    across, down, away = points.T
    off = across[:, None] - across
    squares = off * off
    np.subtract(down[:, None], down, out=off)
    off *= off
    squares += off
    terms = monomials(points)
    values = np.concatenate([model.mean_xy, normals.T], axis=1)
    noise = NOISE / _weights(normals[2], away, squares, model)
    squares *= -0.5 / SIGMA**2
    np.maximum(squares, FARTHEST, out=squares)
    alike = np.exp(squares, out=squares)
    alike += (np.float32(CUBIC) * terms) @ terms.T
    alike.ravel()[:: len(points) + 1] += noise
    bumps = np.linalg.solve(alike, values).T.copy()
    return FaceFit(points[:, :2], np.float32(CUBIC) * (bumps @ terms), bumps)


def monomials(xy: np.ndarray) -> np.ndarray:
    """(N, 2 or more), of which the first columns are x and y -> (N, 10): terms up to degree 3."""
    return products(xy, DEGREE)


def _gaussian(off: np.ndarray) -> np.ndarray:
    """Heights of a Gaussian; `off` is used up."""
    off *= off
    off *= -0.5 / SIGMA**2
    np.maximum(off, FARTHEST, out=off)
    near: np.ndarray = np.exp(off, out=off)
    return near


def _normals(points: np.ndarray, model: FitTables) -> np.ndarray:
    """(3, P): x, y, and z towards the viewer, of unit length."""
    count = len(points)
    tangents = model.to_tangents @ points
    (ax, ay, az), (bx, by, bz) = tangents[:count].T, tangents[count:].T
    normals = np.stack([az * by - ay * bz, ax * bz - az * bx, ax * by - ay * bx])
    normals /= np.sqrt((normals * normals).sum(0)) + 1e-9
    return normals


def _weights(
    facing: np.ndarray, away: np.ndarray, squares: np.ndarray, model: FitTables
) -> np.ndarray:
    """(P,): 1 for a point that faces the viewer and that nothing hides, else LEAST or more.

    squares: (P, P), squared distances in the picture.
    """
    weight = facing * (1 / (POINT_FACING[1] - POINT_FACING[0]))
    weight -= POINT_FACING[0] / (POINT_FACING[1] - POINT_FACING[0])
    nearer = away[:, None] - away[model.front]
    nearer *= 1 / (NEARER[1] - NEARER[0])
    nearer -= NEARER[0] / (NEARER[1] - NEARER[0])
    for share in (weight, nearer):
        np.maximum(share, 0, out=share)
        np.minimum(share, 1, out=share)
    weight *= weight * (3 - 2 * weight)
    close = squares[:, model.front]
    close *= -0.5 / CLOSE**2
    np.maximum(close, FARTHEST, out=close)
    nearer *= np.exp(close, out=close)
    nearer *= model.may_hide
    seen = np.maximum(1 - HIDES * nearer.max(1), 0)
    seen *= seen
    weight *= seen
    return np.maximum(weight, LEAST, out=weight)
