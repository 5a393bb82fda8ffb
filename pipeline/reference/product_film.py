"""How the renderer shows a product on skin, and which colour a product needs to show as it does.

"Root" means, here and in the files beside this one, the square root of linear light as a share of
plain skin's light. The renderer mixes films by such roots (render/blend_layers.py), so the root of
a film is a weighted mean of the skin's root and the product's.
"""

from dataclasses import dataclass

import numpy as np

_SWEEPS = 12


@dataclass(frozen=True, slots=True, eq=False)
class ProductFilm:
    """Places on bare faces, and how a product of opacity 1 shows there.

    bare: (..., 3) roots of usual bare faces, as training/worn/bare_skin.py measures them.
    cover: (...) how much of the skin the product hides.
    response: (...) how much of the product's own root it adds: less than `cover` where less light
    falls.
    """

    bare: np.ndarray
    cover: np.ndarray
    response: np.ndarray

    def product_for(self, seen: np.ndarray, opacity: float) -> np.ndarray:
        """(..., 3) roots of the product that shows as the roots `seen`; they may be below 0."""
        cover, response = (opacity * part[..., None] for part in (self.cover, self.response))
        roots: np.ndarray = (seen - (1 - cover) * self.bare) / response
        return roots


def ramp(value: float, ends: tuple[float, float]) -> float:
    """0 up to the first end, 1 from the second end on, linear in between."""
    first, last = ends
    return min(max((value - first) / (last - first), 0.0), 1.0)


def likely_share(probability: float, all_from: float, least: float) -> float:
    """The share of its opacity with which a product is painted: the less likely, the sheerer.

    The share rises from `least` at probability 0 to 1 at the probability `all_from`.
    """
    return least + (1 - least) * min(probability / all_from, 1)


def bounded(a: np.ndarray, b: np.ndarray, most: np.ndarray) -> np.ndarray:
    """The least-squares solution x, (N, K), of normal equations `a @ x = b`, in 0 <= x <= most.

    a: (N, N), positive definite.  b: (N, K).  most: (K,).
    The solution is exact if it meets no bound; else projected coordinate descent (Hildreth 1957)
    approximates it.
    """
    x: np.ndarray = np.linalg.solve(a, b)
    if ((x >= 0) & (x <= most)).all():
        return x
    np.clip(x, 0, most, out=x)
    for _ in range(_SWEEPS):
        for row in range(len(a)):
            x[row] = np.clip(x[row] + (b[row] - a[row] @ x) / a[row, row], 0, most)
    return x
