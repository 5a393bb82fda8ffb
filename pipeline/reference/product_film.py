"""How a product shows on skin, as the renderer paints it, and which colour it must have.

Numbers are roots of linear light as shares of plain skin: the renderer mixes films by such roots
(render/blend_layers.py), so a film is a weighted mean of the skin's root and the product's.
"""

from dataclasses import dataclass

import numpy as np

_SWEEPS = 12


@dataclass(frozen=True, slots=True, eq=False)
class ProductFilm:
    """A place on bare faces, and how a product of opacity 1 shows there.

    bare: (..., 3) the median of bare faces.
    cover: (...) how much of the skin is hidden.  response: (...) how much of the product's own root
    is added: less than `cover` where less light falls.
    """

    bare: np.ndarray
    cover: np.ndarray
    response: np.ndarray

    def product_for(self, seen: np.ndarray, opacity: float) -> np.ndarray:
        """(..., 3) roots of the product that shows as these, roots below 0 included."""
        cover, response = (opacity * part[..., None] for part in (self.cover, self.response))
        roots: np.ndarray = (seen - (1 - cover) * self.bare) / response
        return roots


def ramp(value: float, ends: tuple[float, float]) -> float:
    """0 up to the first end, 1 from the second one on."""
    first, last = ends
    return min(max((value - first) / (last - first), 0.0), 1.0)


def likely_share(probability: float, all_from: float, least: float) -> float:
    """The share of its opacity that a product is painted with: the less likely it is worn, the
    sheerer. It rises from `least` to 1, which it reaches at the probability `all_from`."""
    return least + (1 - least) * min(probability / all_from, 1)


def bounded(a: np.ndarray, b: np.ndarray, most: np.ndarray) -> np.ndarray:
    """The least squares of `a @ x = b` with 0 <= x <= most.

    a: (N, N), positive definite, the normal equations.  b: (N, K).  most: (K,).  Returns (N, K).
    Exact where no bound is met; else by projected coordinate descent (Hildreth 1957).
    """
    x: np.ndarray = np.linalg.solve(a, b)
    if ((x >= 0) & (x <= most)).all():
        return x
    np.clip(x, 0, most, out=x)
    for _ in range(_SWEEPS):
        for row in range(len(a)):
            x[row] = np.clip(x[row] + (b[row] - a[row] @ x) / a[row, row], 0, most)
    return x
