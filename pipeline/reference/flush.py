"""Finds a blush by the cheek around it: where the cheek is redder than it would be without blush.

Comparing with forehead and nose says little about a soft blush: in strong or tinted light the whole
cheek is paler or yellower than they are. But a blush is a patch, while light changes evenly over
the cheeks, or from one side to the other. How much light changes is known from bare faces.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import product

import numpy as np
from makeup_video.pipeline.reference.cheeks import Cheeks, density

# The shapes that are tried.
_SHAPES: tuple[dict[str, float], ...] = tuple(
    {"height": height, "reach": reach, "size": size, "across": across}
    for height, reach, size, across in product(
        (0.0, 0.5, 1.0), (0.0, 0.4, 0.9), (0.3, 0.6, 0.95), (0.0, 0.8)
    )
)
# The nodes that count: blush and the cheek around it, as `across` and `down` of FaceFields, where
# bare cheeks are known at least so well.
_ACROSS, _DOWN, _KNOWN = (0.14, 0.88), (0.02, 0.8), 0.3
_LEAST_NODES, _LEAST_WEIGHT = 100, 0.05
_UNLIKE_SKIN = 0.5  # weight of a node that is visible but unlike skin
# Attributes of Cheeks that `density` reads: two for the places; of `skin` only the array's shape.
_PLACES = ("across", "down", "skin")
_MIDDLE = 0.5, 0.4  # across, down: the place from which changes of light are counted
# How much light may change over the cheeks, as standard deviations of the logarithms of _tint, in
# the order of _light: even, across, down, from side to side, this difference changing across and
# down, and three curvatures. The first is measured on bare cheeks. Most others are smaller than
# measured, or else a broad blush would be taken for light.
_LIGHT = np.array([0.13, 0.2, 0.15, 0.15, 0.15, 0.1, 0.6, 0.4, 0.4])
# Standard deviation of a node's noise; and neighbours are alike, so all nodes together say as much
# as this number of independent nodes.
_NOISE, _NODES = 0.05, 12.0
_DARKEST = 0.03  # least root
# The least red that a blush adds. Red counts as at least the second times the blue.
_LEAST_RED, _PINK = 0.03, 0.8
_OLIVE = 0.9  # a patch that adds less red than this share of its yellow would be a shadow
_LEAST_GAIN = 3.0  # twice the gain in log-likelihood; with less, a patch may be chance


@dataclass(frozen=True, slots=True)
class Flush:
    """A blush as it stands out from the cheek around it.

    shape: of the layer.  red, blue: what the blush adds, where it is densest, to the logarithms of
    R / G and B / G of the light from the cheek.
    """

    shape: Mapping[str, float]
    red: float
    blue: float


def find_flush(cheeks: Cheeks) -> Flush | None:
    """The patch that explains the cheeks best; None when no patch that reddens does."""
    weights = np.maximum(cheeks.skin, _UNLIKE_SKIN * cheeks.visible)
    weights *= cheeks.within(_ACROSS, _DOWN, _KNOWN)
    at = weights > _LEAST_WEIGHT
    if at.sum() < _LEAST_NODES:
        return None
    counts = weights[at] * (_NODES / _NOISE**2 / weights[at].sum())
    tint, light = _tint(cheeks, at), _light(cheeks, at)
    nodes = replace(cheeks, **{name: getattr(cheeks, name)[at] for name in _PLACES})
    patches = np.stack([density(nodes, shape) for shape in _SHAPES], -1)
    # the part of the patches that light explains is removed from them (Frisch and Waugh 1933)
    weighted = light.T * counts
    of_light = weighted @ light + np.diag(1 / _LIGHT**2)
    own = patches.T * counts - np.linalg.solve(of_light, weighted @ patches).T @ weighted
    power = np.maximum(np.einsum("in,ni->i", own, patches), 1e-9)
    red, blue = (own @ tint / power[:, None]).T
    is_blush = (red > np.maximum(-_OLIVE * blue, 0)) & (np.maximum(red, _PINK * blue) > _LEAST_RED)
    gain = np.where(is_blush, (red**2 + blue**2) * power, 0)
    best = int(gain.argmax())
    if gain[best] < _LEAST_GAIN:
        return None
    return Flush(_SHAPES[best], max(float(red[best]), _PINK * float(blue[best])), float(blue[best]))


def _tint(cheeks: Cheeks, at: np.ndarray) -> np.ndarray:
    """(N, 2): how much the logarithms of R / G and B / G at some nodes exceed bare cheeks'."""
    seen, bare = (
        2 * np.log(np.maximum(roots[at], _DARKEST)) for roots in (cheeks.roots, cheeks.film().bare)
    )
    off = seen - bare
    tint: np.ndarray = off[:, [0, 2]] - off[:, 1:2]
    return tint


def _light(cheeks: Cheeks, at: np.ndarray) -> np.ndarray:
    """(N, 9): the ways in which light may change over some nodes, in the order of _LIGHT."""
    across, side = np.abs(cheeks.across[at]) - _MIDDLE[0], np.sign(cheeks.across[at])
    down = cheeks.down[at] - _MIDDLE[1]
    even = np.ones_like(across)
    curved = (across * across, across * down, down * down)
    parts = (even, across, down, 0.5 * side, side * across, side * down, *curved)
    return np.stack(parts, -1)
