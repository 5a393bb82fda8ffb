"""The 68-point scheme, and mirror images; pipeline/faces/topology.py has the lips and the eyes."""

import numpy as np

# The usual 68 points, each as the nearest MediaPipe point. With this table, MediaPipe itself has
# the errors on human labels that docs/models.md quotes.
POINTS_68 = np.array([
    162, 234, 93, 58, 172, 136, 149, 148, 152, 377, 378, 365, 397, 288, 323, 454, 389,  # jaw
    71, 63, 105, 66, 107, 336, 296, 334, 293, 301,  # brows
    168, 197, 5, 4, 75, 97, 2, 326, 305,  # nose
    33, 160, 158, 133, 153, 144, 362, 385, 387, 263, 373, 380,  # eyes
    61, 39, 37, 0, 267, 269, 291, 405, 314, 17, 84, 181,  # outer lip
    78, 82, 13, 312, 308, 317, 14, 87,  # inner lip
])  # fmt: skip
EYES_68, MOUTH_68 = slice(36, 48), slice(48, 68)


def mirror_permutation(mean: np.ndarray) -> np.ndarray:
    """The point on the other side for each point of a symmetric mean face (478, 3)."""
    from scipy.optimize import linear_sum_assignment

    mirrored = mean * [-1, 1, 1]
    distance = np.linalg.norm(mean[:, None] - mirrored[None], axis=2)
    permutation = linear_sum_assignment(distance**2)[1]
    assert (permutation[permutation] == np.arange(len(mean))).all(), "not an involution"
    return permutation
