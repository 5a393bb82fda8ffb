"""Measures of how well makeup is read, and the logistic model that gives probabilities."""

import numpy as np

_STEPS = 30  # of Newton's method, which settles within ten
_FLAT = 1e-6  # added to the curvature of each row, so that the equations can be solved
UNKNOWN = 255  # the label of a face that is neither clearly bare nor clearly made up


def area_under_curve(scores: np.ndarray, is_worn: np.ndarray) -> float:
    """The share of the pairs of a made-up and a bare face in which the made-up one scores higher.

    scores, is_worn: (N,). A pair with equal scores counts half. nan without faces of both kinds.
    """
    _, place, counts = np.unique(scores, return_inverse=True, return_counts=True)
    order = (np.cumsum(counts) - (counts - 1) / 2)[place]  # ranks from 1; ties share their mean
    count = int(is_worn.sum())
    if count in (0, len(is_worn)):
        return float("nan")
    rank = float(order[is_worn].sum()) - count * (count + 1) / 2
    return rank / (count * (len(scores) - count))


def logistic(
    rows: np.ndarray, is_worn: np.ndarray, counts: np.ndarray | float = 1.0, ridge: float = 0.0
) -> np.ndarray:
    """(N,) weights of logistic regression on rows (M, N), by Newton's method.

    counts: the weight of each row.  ridge: the penalty on the squares of the weights.
    """
    weights = np.zeros(rows.shape[1])
    for _ in range(_STEPS):
        found = 1 / (1 + np.exp(-rows @ weights))
        curve = rows.T @ (rows * (found * (1 - found) * counts + _FLAT)[:, None])
        slope = rows.T @ ((found - is_worn) * counts) + ridge * weights
        weights -= np.linalg.solve(curve + ridge * np.eye(len(weights)), slope)
    return weights


def agreement(name: str, found: np.ndarray, true: np.ndarray) -> str:
    """One line on how well numbers that are read agree with the true ones, where those are known.

    found, true: (N,); an unknown true number is nan.
    """
    known = np.isfinite(true)
    found, true = found[known], true[known]
    correlation = np.corrcoef(found, true)[0, 1]
    return f"{name}: correlation {correlation:.2f}, mean {found.mean():.3f}, true {true.mean():.3f}"
