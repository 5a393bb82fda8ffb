"""Scores of what is read as worn, and the model that turns numbers into probabilities."""

import numpy as np

_STEPS = 30  # of Newton's method, which settles within ten
_FLAT = 1e-6  # curvature that a row has at least, so that the equations can be solved
UNKNOWN = 255  # the label of a face that is neither clearly bare nor clearly made up


def area_under_curve(scores: np.ndarray, is_worn: np.ndarray) -> float:
    """The share of pairs of a made-up and a bare face that are in the right order, (N,) each.

    Half of those with the same score count.
    """
    _, place, counts = np.unique(scores, return_inverse=True, return_counts=True)
    order = (np.cumsum(counts) - (counts - 1) / 2)[place]  # ranks from 1, the mean of ties
    count = int(is_worn.sum())
    if count in (0, len(is_worn)):
        return float("nan")
    rank = float(order[is_worn].sum()) - count * (count + 1) / 2
    return rank / (count * (len(scores) - count))


def logistic(
    rows: np.ndarray, is_worn: np.ndarray, counts: np.ndarray | float = 1.0, ridge: float = 0.0
) -> np.ndarray:
    """(N,) weights of logistic regression on rows (M, N), by Newton's method.

    counts: how much each row counts.  ridge: on the squares of the weights.
    """
    weights = np.zeros(rows.shape[1])
    for _ in range(_STEPS):
        found = 1 / (1 + np.exp(-rows @ weights))
        curve = rows.T @ (rows * (found * (1 - found) * counts + _FLAT)[:, None])
        slope = rows.T @ ((found - is_worn) * counts) + ridge * weights
        weights -= np.linalg.solve(curve + ridge * np.eye(len(weights)), slope)
    return weights


def agreement(name: str, found: np.ndarray, true: np.ndarray) -> str:
    """In words, how numbers that are found agree with the truth where that is known (not nan)."""
    known = np.isfinite(true)
    found, true = found[known], true[known]
    correlation = np.corrcoef(found, true)[0, 1]
    return f"{name}: correlation {correlation:.2f}, mean {found.mean():.3f}, true {true.mean():.3f}"
