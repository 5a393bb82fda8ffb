"""Smooth borders of a kind's shape.

numpy is imported where it is used: help pages read the kinds, too, and need not wait for it.
"""

from typing import TYPE_CHECKING

from makeup_video.pipeline.look.params import GraphicsParams

if TYPE_CHECKING:
    import numpy as np

_THINNEST = 1e-3  # least width of a border, so that nothing divides by zero


def smooth(share: "np.ndarray") -> "np.ndarray":
    """0 below 0, 1 above 1, and a smooth rise between (3t^2 - 2t^3); float32."""
    import numpy as np

    t: np.ndarray = np.minimum(share, 1, dtype=np.float32)
    np.maximum(t, 0, out=t)
    rest = t * -2
    rest += 3
    t *= t
    t *= rest
    return t


def rise(at: "np.ndarray", middle: float, width: float) -> "np.ndarray":
    """A smooth rise from 0 to 1 around a place, over a width."""
    return _ramp(at, middle, 1 / max(width, _THINNEST))


def fall(at: "np.ndarray", middle: float, width: float) -> "np.ndarray":
    """A smooth fall from 1 to 0 around a place, over a width."""
    return _ramp(at, middle, -1 / max(width, _THINNEST))


def _ramp(at: "np.ndarray", middle: float, slope: float) -> "np.ndarray":
    import numpy as np

    share = at * np.float32(slope)
    share += np.float32(0.5 - middle * slope)
    return smooth(share)


def faded(soft: float, product: GraphicsParams) -> float:
    """The share of a stroke's radius over which a product fades, for `stroke`.

    soft: this share for a product with the edge softness of the finishes, 0.8.
    """
    return min(soft * (0.2 + product.edge_softness), 1.0)


def stroke(
    x: "np.ndarray",
    y: "np.ndarray",
    ends: tuple[tuple[float, float], tuple[float, float]],
    radius: float,
    soft: float,
    beyond: float,
) -> "np.ndarray":
    """A stroke between two points, 1 along its middle, that fades to all sides.

    radius: half its width.  soft: 0..1, the share of the radius over which it fades.  beyond: how
    far it fades beyond the radius, as a share of `soft`.
    """
    import numpy as np

    away = from_segment(x, y, *ends) * np.float32(1 / radius)
    return smooth((1 + beyond * soft - away) * np.float32(1 / ((1 + beyond) * soft)))


def from_segment(
    x: "np.ndarray", y: "np.ndarray", a: tuple[float, float], b: tuple[float, float]
) -> "np.ndarray":
    """Distance of places from the line between two points."""
    import numpy as np

    right, down = b[0] - a[0], b[1] - a[1]
    length2 = max(right * right + down * down, 1e-12)
    along = np.clip(((x - a[0]) * right + (y - a[1]) * down) * (1 / length2), 0, 1)
    return np.hypot(x - a[0] - along * right, y - a[1] - along * down)
