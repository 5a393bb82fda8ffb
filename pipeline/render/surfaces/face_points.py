"""The points of a face that its surface is fitted to, and what the fits of all faces share."""

from functools import cache

import numpy as np
from makeup_video.kernels.face import FitTables
from makeup_video.pipeline.faces.net import read_array
from makeup_video.pipeline.faces.topology import EYE, LIPS, RIGHT_EYE

# All lengths are in IOD, the distance of the outer eye corners.
UP, DOWN = -0.5, 1.0  # which points are used: from above the brows to the chin's upper half
_GAP = 0.15  # least distance of the points that are used
# Distances on the mean face: up to the first a point hides no other, from the second on it may.
_APART = 0.12, 0.245
_FRONT = -0.15  # z of the mean face: points in front of it may hide others
_TANGENT_DEGREE, _TANGENT_SPAN = 5, 0.8

# Points that are not used: the mobile parts of eyes and mouth would bend the surface beside them.
# They are all of the eyes but their corners and the outer ring, and the lips inside their border.
_MOBILE = np.concatenate([
    LIPS[20:], EYE[1:8], EYE[9:32], EYE[-5:], RIGHT_EYE[1:8], RIGHT_EYE[9:32], RIGHT_EYE[-5:],
])  # fmt: skip
# Always used, however close others are: nose, cheeks, cupid's bow.
_KEPT = [4, 1, 5, 195, 197, 168, 0, 37, 164, 50, 205, 117, 187, 101]


@cache
def fit_points() -> np.ndarray:
    """The points that a fit uses, (P,) indices of points_px."""
    return _spread_points(read_array("mean_face.npy"), read_array("mirror.npy"))


@cache
def fit_tables() -> FitTables:
    """The tables of kernels/face.cl and of its twin."""
    mean, points = read_array("mean_face.npy").astype(np.float64), fit_points()
    xy = mean[points, :2]
    apart = np.linalg.norm(xy[:, None] - xy, axis=2)
    front = np.flatnonzero(mean[points, 2] < _FRONT)
    may_hide = np.clip((apart[:, front] - _APART[0]) / (_APART[1] - _APART[0]), 0, 1)
    own = (xy - [0, (UP + DOWN) / 2]) / _TANGENT_SPAN
    to_terms = np.linalg.pinv(products(own, _TANGENT_DEGREE))
    along, down = _exponents(_TANGENT_DEGREE)
    x, y = _powers(own[:, 0], _TANGENT_DEGREE), _powers(own[:, 1], _TANGENT_DEGREE)
    slopes = np.concatenate(
        [
            along * x[:, np.maximum(along - 1, 0)] * y[:, down],
            down * x[:, along] * y[:, np.maximum(down - 1, 0)],
        ]
    )
    return FitTables(
        xy.astype(np.float32),
        (slopes @ to_terms).astype(np.float32),
        front,
        may_hide.astype(np.float32),
    )


def products(xy: np.ndarray, degree: int) -> np.ndarray:
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


def _spread_points(mean: np.ndarray, mirror: np.ndarray) -> np.ndarray:
    """Points of the mean face, and their mirror images: _KEPT, and others at least _GAP apart."""
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
