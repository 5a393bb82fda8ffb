"""Finds the colours of eyeshadow with which the fit begins, in four usual places.

Which four products, painted on a usual bare face, would look most like the photo? Their colours
follow by least squares, because films mix linearly in roots of light (product_film.py).
"""

from collections.abc import Sequence

import numpy as np
from makeup_video.pipeline.look.kinds.density_map import HW
from makeup_video.pipeline.reference.neutral_face import LUMINANCE
from makeup_video.pipeline.reference.product_film import bounded
from makeup_video.pipeline.reference.shadow_cells import LIGHTER, VIVID, Cells, density_of

# In the order of painting. The shapes end further out than usual, since outer ends lean inwards.
_SHAPES: tuple[dict[str, object], ...] = (
    {"slot": "full", "outer": 1.22},
    {"slot": "outer", "outer": 1.37, "low": -0.6},
    {"slot": "lid", "outer": 1.08},
    {"slot": "under", "outer": 1.25, "low": -0.45},
)
_MOST_OPAQUE, _LEAST_OPAQUE = 0.8, 0.3
_PALE_OPAQUE = 0.35  # a pale product is painted sheer: on darker skin it would look like chalk
_CONTRAST = 0.35  # from this difference of roots between product and skin on, it is most opaque
_NEARLY = 0.92  # from this share of white's root on, a channel counts as white
# The weight, in cells, with which a colour is kept near skin. Without it, a colour that its cells
# hardly determine, or whose cells other products cover, would become extreme.
_STIFF = 1.0


def first_shadows(
    seen: np.ndarray, cells: Cells, most: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """The roots of up to four products, (N, 3), and how much of each shows, (N, 27, 24).

    seen: (27, 24, 3) roots.  most: (3,) the roots of white. Products that would have to be white
    are left out: there, strong light lies on the skin, and white on other skin would look like a
    grey veil.
    """
    shapes = [density_of(shape) for shape in _SHAPES]
    while shapes:
        roots = _fit(seen, cells, _shares(shapes, [_MOST_OPAQUE] * len(shapes), cells), most)
        opacities = [
            _opacity(shape, root, cells) for shape, root in zip(shapes, roots, strict=True)
        ]
        shares = _shares(shapes, opacities, cells)
        roots = _fit(seen, cells, shares, most)
        white = (roots >= _NEARLY * most).sum(1) >= 2
        if not white.any():
            return roots, shares
        del shapes[int(white.argmax())]
    return np.zeros((0, 3)), np.zeros((0, *HW), np.float32)


def _fit(seen: np.ndarray, cells: Cells, shares: np.ndarray, most: np.ndarray) -> np.ndarray:
    """The roots of products, (N, 3), with which these shares look most like the roots `seen`."""
    film, weights = cells.film, cells.weights.ravel()
    rest = seen - film.bare * (1 - film.cover * shares.sum(0))[..., None]
    parts = (shares * film.response).reshape(len(shares), -1)
    weighted = parts * weights
    normal = weighted @ parts.T + _STIFF * np.eye(len(shares))
    return bounded(normal, weighted @ rest.reshape(-1, 3) + _STIFF, most)


def _shares(shapes: Sequence[np.ndarray], opacities: Sequence[float], cells: Cells) -> np.ndarray:
    """(N, 27, 24): how much of each product shows when later products lie over earlier ones."""
    shares = np.zeros((len(shapes), *HW), np.float32)
    through = np.ones(HW, np.float32)
    for at in reversed(range(len(shapes))):
        lies = opacities[at] * shapes[at]
        shares[at] = lies * through
        through = through * (1 - lies * cells.film.cover)
    return shares


def _opacity(shape: np.ndarray, root: np.ndarray, cells: Cells) -> float:
    """How opaque a product is: the less it differs from skin, the sheerer; so are pale ones."""
    film, share = cells.film, shape * cells.weights
    pure = film.response[..., None] / np.maximum(film.cover, 0.05)[..., None] * root
    off = ((pure - film.bare) * share[..., None]).sum((0, 1)) / max(float(share.sum()), 1e-9)
    most = _MOST_OPAQUE
    if off @ LUMINANCE > LIGHTER:
        vivid = min(max(-float(off.min()) / VIVID, 0), 1)
        most = _PALE_OPAQUE + vivid * (_MOST_OPAQUE - _PALE_OPAQUE)
    wanted = _MOST_OPAQUE * float(np.linalg.norm(off)) / _CONTRAST
    return round(min(max(wanted, _LEAST_OPAQUE), most), 3)
