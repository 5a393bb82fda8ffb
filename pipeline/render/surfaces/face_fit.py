"""Where each place of a face's picture lies on the mean face, and how it is turned there.

The 478 points say it at themselves only. Between them a cubic in the picture's x and y holds for
the whole face, and a sum of Gaussians around the points adds what the cubic misses. Both come from
one solve: a Gaussian process with these two as its covariance (Rasmussen and Williams 2006, 2.7).
Points that turn away from the viewer, or that another part of the face hides (the cheek behind the
nose), count for next to nothing.
"""

from dataclasses import dataclass
from functools import cache

import numpy as np
from makeup_video.pipeline.faces.net import read_array
from makeup_video.pipeline.faces.topology import EYE, LIPS, RIGHT_EYE

# All lengths are in IOD, the distance of the outer eye corners.
UP, DOWN = -0.5, 1.0  # which points are used: from above the brows to the chin's upper half
_GAP = 0.15  # between the points that are used: 60 of them
_DEGREE = 3
_SIGMA = 0.14  # of the Gaussians
_NOISE = 0.1  # variance of a point's place against that of the Gaussians; more is smoother
_FARTHEST = -20.0  # exponents of Gaussians: below, their products are too small to be quick
_CUBIC = np.float32(3.0)  # variance of the cubic's coefficients: nearly free
_FACING = 0.1, 0.5  # z of a point's normal, from which it counts, and counts fully
_LEAST = 1e-4  # weight of the other points, so that every solve has an answer
# A point counts as hidden by one that is so much nearer to the viewer (0 to 1 between the two), as
# close in the picture, and so far off on the mean face.
_NEARER = 0.07, 0.14
_CLOSE = 0.08
_APART = 0.12, 0.245
_HIDES = 1.5  # how soon
_FRONT = -0.15  # z of the mean face: points in front of it may hide others
_TANGENT_DEGREE, _TANGENT_SPAN = 5, 0.8

# The mobile parts of eyes and mouth would bend the surface beside them: all of the eyes but their
# corners and the outer ring, and the lips inside their border.
_MOBILE = np.concatenate([
    LIPS[20:], EYE[1:8], EYE[9:32], EYE[-5:], RIGHT_EYE[1:8], RIGHT_EYE[9:32], RIGHT_EYE[-5:],
])  # fmt: skip
# Used whatever is beside them: nose, cheeks, cupid's bow.
_KEPT = [4, 1, 5, 195, 197, 168, 0, 37, 164, 50, 205, 117, 187, 101]


@dataclass(frozen=True, slots=True, eq=False)
class _Model:
    """What every fit shares, float32.

    points: (P,) places in points_px.  mean_xy: (P, 2), on the mean face.
    to_tangents: (2P, P), from points to the derivatives along x, then y, of the mean face.
    front: (F,) places in P of the points of nose and mouth, which may hide others.
    may_hide: (P, F), 0 for neighbours, 1 for points far from each other.
    """

    points: np.ndarray
    mean_xy: np.ndarray
    to_tangents: np.ndarray
    front: np.ndarray
    may_hide: np.ndarray


@dataclass(frozen=True, slots=True, eq=False)
class FaceFit:
    """Five smooth functions of the picture: across, down, and x, y and facing of the normal.

    xy: (P, 2) float32, the points in the picture, in IOD.
    cubic: (5, 10).  bumps: (5, P), heights of the Gaussians.
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
        # one product for each field: of one large product OpenBLAS makes work for all cores
        fields: np.ndarray = (self.bumps[:, None] * near_y) @ near_x.T
        fields += (self.cubic @ cubics).reshape(fields.shape)
        return fields


def fit_points() -> np.ndarray:
    """The points that a fit uses, (P,) places in points_px."""
    return _model().points


def fit(points: np.ndarray) -> FaceFit:
    """points: (P, 3) float32, `fit_points` of a face in IOD, turned upright; z away from the
    viewer."""
    model = _model()
    normals = _normals(points, model)
    across, down, away = points.T
    off = across[:, None] - across
    squares = off * off
    np.subtract(down[:, None], down, out=off)
    off *= off
    squares += off
    terms = monomials(points)
    values = np.concatenate([model.mean_xy, normals.T], axis=1)
    noise = _NOISE / _weights(normals[2], away, squares, model)
    squares *= -0.5 / _SIGMA**2
    np.maximum(squares, _FARTHEST, out=squares)
    alike = np.exp(squares, out=squares)
    alike += (_CUBIC * terms) @ terms.T
    alike.ravel()[:: len(points) + 1] += noise
    bumps = np.linalg.solve(alike, values).T.copy()
    return FaceFit(points[:, :2], _CUBIC * (bumps @ terms), bumps)


def monomials(xy: np.ndarray) -> np.ndarray:
    """(N, 10) of x and y, the first two columns of (N, 2 or more): up to the third degree."""
    return _products(xy, _DEGREE)


def _products(xy: np.ndarray, degree: int) -> np.ndarray:
    """(N, terms): x^i y^j with i + j up to the degree."""
    x, y = _powers(xy[:, 0], degree), _powers(xy[:, 1], degree)
    along, down = _exponents(degree)
    products: np.ndarray = x.take(along, 1)
    products *= y.take(down, 1)
    return products


@cache
def _exponents(degree: int) -> tuple[np.ndarray, np.ndarray]:
    pairs = [(i, j) for i in range(degree + 1) for j in range(degree + 1 - i)]
    along, down = np.array(pairs).T
    return along, down


def _powers(values: np.ndarray, degree: int) -> np.ndarray:
    powers = np.empty((len(values), degree + 1), values.dtype)
    powers[:, 0] = 1
    for i in range(degree):
        np.multiply(powers[:, i], values, out=powers[:, i + 1])
    return powers


def _gaussian(off: np.ndarray) -> np.ndarray:
    """Heights of a Gaussian; `off` is used up."""
    off *= off
    off *= -0.5 / _SIGMA**2
    np.maximum(off, _FARTHEST, out=off)
    near: np.ndarray = np.exp(off, out=off)
    return near


def _normals(points: np.ndarray, model: _Model) -> np.ndarray:
    """(3, P): x, y, and z towards the viewer, of unit length."""
    count = len(points)
    tangents = model.to_tangents @ points
    (ax, ay, az), (bx, by, bz) = tangents[:count].T, tangents[count:].T
    normals = np.stack([az * by - ay * bz, ax * bz - az * bx, ax * by - ay * bx])
    normals /= np.sqrt((normals * normals).sum(0)) + 1e-9
    return normals


def _weights(
    facing: np.ndarray, away: np.ndarray, squares: np.ndarray, model: _Model
) -> np.ndarray:
    """(P,): 1 for a point that faces the viewer and that nothing hides, else _LEAST or more.

    squares: (P, P), squared distances in the picture.
    """
    weight = facing * (1 / (_FACING[1] - _FACING[0]))
    weight -= _FACING[0] / (_FACING[1] - _FACING[0])
    nearer = away[:, None] - away[model.front]
    nearer *= 1 / (_NEARER[1] - _NEARER[0])
    nearer -= _NEARER[0] / (_NEARER[1] - _NEARER[0])
    for share in (weight, nearer):
        np.maximum(share, 0, out=share)
        np.minimum(share, 1, out=share)
    weight *= weight * (3 - 2 * weight)
    close = squares[:, model.front]
    close *= -0.5 / _CLOSE**2
    np.maximum(close, _FARTHEST, out=close)
    nearer *= np.exp(close, out=close)
    nearer *= model.may_hide
    seen = np.maximum(1 - _HIDES * nearer.max(1), 0)
    seen *= seen
    weight *= seen
    return np.maximum(weight, _LEAST, out=weight)


@cache
def _model() -> _Model:
    mean = read_array("mean_face.npy").astype(np.float64)
    points = _spread_points(mean, read_array("mirror.npy"))
    xy = mean[points, :2]
    apart = np.linalg.norm(xy[:, None] - xy, axis=2)
    front = np.flatnonzero(mean[points, 2] < _FRONT)
    may_hide = np.clip((apart[:, front] - _APART[0]) / (_APART[1] - _APART[0]), 0, 1)
    own = (xy - [0, (UP + DOWN) / 2]) / _TANGENT_SPAN
    to_terms = np.linalg.pinv(_products(own, _TANGENT_DEGREE))
    along, down = _exponents(_TANGENT_DEGREE)
    x, y = _powers(own[:, 0], _TANGENT_DEGREE), _powers(own[:, 1], _TANGENT_DEGREE)
    slopes = np.concatenate(
        [
            along * x[:, np.maximum(along - 1, 0)] * y[:, down],
            down * x[:, along] * y[:, np.maximum(down - 1, 0)],
        ]
    )
    return _Model(
        points,
        xy.astype(np.float32),
        (slopes @ to_terms).astype(np.float32),
        front,
        may_hide.astype(np.float32),
    )


def _spread_points(mean: np.ndarray, mirror: np.ndarray) -> np.ndarray:
    """Points of the mean face, at least _GAP apart but for _KEPT; with each its mirror image."""
    mobile = set(_MOBILE.tolist())
    free = [
        i
        for i in range(len(mean))
        if i not in mobile and UP < mean[i, 1] < DOWN and mean[i, 0] < 1e-6
    ]
    chosen = list(_KEPT)
    while True:
        off = np.linalg.norm(mean[free, None, :2] - mean[chosen, :2], axis=2).min(1)
        if off.max() < _GAP:
            return np.unique(np.concatenate([chosen, mirror[chosen]]))
        chosen.append(free[int(off.argmax())])
