"""Several products that lie over each other on one surface -> layers that the kernel composes.

The kernel lays a film by mixing square roots of light, so films over each other are one film again:
its share of opacity and its root of light are found by "over", as for pictures with transparency.
`blend` is the twin of kernels/product.cl.
"""

from collections.abc import Sequence
from operator import attrgetter, mul

import numpy as np
from makeup_video.kernels.material import Material
from makeup_video.kernels.paint import Layers
from makeup_video.kernels.product import NONE

# By what a layer counts for the numbers that are the same all over the surface: the opacity, the
# synthetic highlight, the shine of the layer that shows. Numbers that are not named here come from
# the scene, and are the same in every layer.
_BY_OPACITY = "texture", "undertone", "keep_highlights", "dark_gain", "dark_offset"
_BY_REFLECTION = "fresnel_front", "fresnel_rim"
_opacities, _reflections = attrgetter(*_BY_OPACITY), attrgetter(*_BY_REFLECTION)


def shares_of(densities: np.ndarray, opacities: Sequence[float]) -> np.ndarray:
    """How much each layer shows: its density times what the layers above it let through.

    densities: (layers, ...) float32, 0..1, the lowest first.  opacities: of the products, 0..1.
    Returns the same shape, float32.
    """
    shares: np.ndarray = densities.copy()
    through = 1 - np.float32(opacities[-1]) * shares[-1]
    for one, opacity in zip(shares[-2::-1], opacities[-2::-1], strict=True):
        one *= through
        through -= np.float32(opacity) * one
    return shares


def blend(shares: np.ndarray, materials: Sequence[Material]) -> tuple[Layers, Material]:
    """Compose layers, the lowest first, as if each were painted on the ones before it.

    shares: (layers, H, W) float32, of `shares_of`, on the surface's grid.
    materials: at least one; the products, all under the light of one scene.
    Returns the layers and the material of a PaintedRegion. Where all shares are 0, opacity, glint
    and shine are 0. Highlights are covered by the opacity of what lies over them. Painting one
    after another would mix their roots of light, too, so a highlight that is seen through another
    film is an approximation.
    Raises ValueError for no layers, or another number of shares.
    """
    if not materials or len(shares) != len(materials):
        raise ValueError(
            f"layers must be at least one, each with its shares; got {len(materials)} products "
            f"and {len(shares)} shares"
        )
    shines = _shines(materials)
    numbers = [
        (*_scaled_root(m), m.opacity, *m.glint, shine)
        for m, shine in zip(materials, shines, strict=True)
    ]
    seen = shares.reshape(len(shares), -1).sum(1).tolist()
    red, green, blue, opacity, *_ = (
        sum(map(mul, column, seen)) for column in zip(*numbers, strict=True)
    )
    opacity = max(opacity, NONE)
    mean_root = red / opacity, green / opacity, blue / opacity
    return Layers(shares, numbers, mean_root), _common(materials, shines, seen)


def _scaled_root(m: Material) -> tuple[float, ...]:
    """The square root of the product's light, times its opacity."""
    return tuple([m.opacity * max(part, 0.0) ** 0.5 for part in m.product])


def _shines(materials: Sequence[Material]) -> list[float]:
    """How much each layer shines beside the one that shines most in some way, 0..1."""
    kinds = [[m.own_highlights, m.reflection, m.shimmer * max(m.sparkle)] for m in materials]
    most = [max(kind) for kind in zip(*kinds, strict=True)]
    return [
        max(part / top if top > 0 else 0.0 for part, top in zip(kind, most, strict=True))
        for kind in kinds
    ]


def _common(
    materials: Sequence[Material], shines: Sequence[float], seen: Sequence[float]
) -> Material:
    """The numbers that the kernel takes as the same all over a surface.

    seen: how much each layer shows.  shines: see `_shines`.
    """
    if len(materials) == 1:
        return materials[0]
    opaque = [part * m.opacity for part, m in zip(seen, materials, strict=True)]
    glints = [part * max(m.glint) for part, m in zip(seen, materials, strict=True)]
    mirrors = [part * m.reflection for part, m in zip(seen, materials, strict=True)]
    sparkling = [part * m.shimmer * max(m.sparkle) for part, m in zip(seen, materials, strict=True)]
    # where the map of shine is 1, what shines is as strong as the layers' own mean there
    shining = max(sum(p * s for p, s in zip(seen, shines, strict=True)), NONE)
    most = materials[max(range(len(materials)), key=sparkling.__getitem__)]
    full = most.shimmer * max(most.sparkle)
    dimmed = min(sum(sparkling) / shining / full, 1.0) if full > 0 else 1.0
    own = sum(p * m.own_highlights for p, m in zip(seen, materials, strict=True))
    common = Material(*most.record())
    common.own_highlights = own / shining
    common.reflection = min(sum(mirrors) / shining, 1.0)
    common.sparkle = tuple([dimmed * part for part in most.sparkle])
    a, b, c, d = _means([m.room for m in materials], mirrors)
    common.room = a, b, c, d
    for of, names, shares in (
        (_opacities, _BY_OPACITY, opaque),
        (_reflections, _BY_REFLECTION, mirrors),
    ):
        for name, mean in zip(names, _means([of(m) for m in materials], shares), strict=True):
            setattr(common, name, mean)
    (common.lobe,) = _means([(m.lobe,) for m in materials], glints)
    return common


def _means(rows: Sequence[Sequence[float]], shares: Sequence[float]) -> list[float]:
    """Of each column the mean by share; the plain mean where no layer has a share."""
    total = sum(shares)
    if total <= NONE:
        shares, total = [1.0] * len(rows), float(len(rows))
    return [sum(map(mul, column, shares)) / total for column in zip(*rows, strict=True)]
