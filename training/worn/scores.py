"""Scores of the net that tells what is worn."""

import numpy as np

UNKNOWN = 255  # the label of a face that is neither clearly bare nor clearly made up


def area_under_curve(scores: np.ndarray, is_worn: np.ndarray) -> float:
    """The share of pairs of a made-up and a bare face that are in the right order, (N,) each."""
    order = np.argsort(np.argsort(scores, kind="stable"), kind="stable") + 1
    count = int(is_worn.sum())
    if count in (0, len(is_worn)):
        return float("nan")
    rank = float(order[is_worn].sum()) - count * (count + 1) / 2
    return rank / (count * (len(scores) - count))
