"""How much each product shows where several lie over each other on one surface.

The kernel lays a film by mixing square roots of light, so films over each other are one film again.
Its opacity and its root of light follow from the operator "over", as for transparent pictures.
kernels/product.cl composes the products.
"""

from collections.abc import Sequence

import numpy as np


def shares_of(densities: np.ndarray, opacities: Sequence[float]) -> np.ndarray:
    """How much each layer shows: its density times what the layers above it let through.

    densities: (layers, ...) float32, 0..1, the lowest first.  opacities: of each product, 0..1.
    Returns the same shape, float32.
    """
    shares: np.ndarray = densities.copy()
    through = 1 - np.float32(opacities[-1]) * shares[-1]
    for one, opacity in zip(shares[-2::-1], opacities[-2::-1], strict=True):
        one *= through
        through -= np.float32(opacity) * one
    return shares
