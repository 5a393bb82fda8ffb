"""The least-squares similarity between two sets of points (Umeyama, 1991)."""

import numpy as np
from makeup_video.pipeline.smoothing.face_space import as_complex


def fit_similarity(from_xy: np.ndarray, to_xy: np.ndarray) -> np.ndarray:
    """The turn, scale and shift that lead from_xy to to_xy with the least squared error.

    from_xy, to_xy: (..., K, 2). Returns M, (..., 2, 3) float64, for `M[:, :2] @ xy + M[:, 2]`. M
    never reflects, and only shifts if all points of from_xy are the same. In the plane, the closed
    form of Umeyama (1991) is a division of complex numbers.
    """
    a, b = as_complex(from_xy), as_complex(to_xy)
    a_mean, b_mean = a.mean(-1), b.mean(-1)
    a = (a - a_mean[..., None]).conj()
    spread = (a * a.conj()).real.sum(-1)
    one_point = spread <= 0
    factor = (a * (b - b_mean[..., None])).sum(-1) / np.where(one_point, 1.0, spread)
    factor = np.where(one_point, 1.0, factor)
    shift = b_mean - factor * a_mean
    rows = [factor.real, -factor.imag, shift.real, factor.imag, factor.real, shift.imag]
    return np.stack(rows, -1).reshape(*factor.shape, 2, 3)
