"""The numpy twins of kernels/product.cl.

They light products, compose them where they lie over each other, and find what they mirror.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from operator import attrgetter, mul

import numpy as np
from makeup_video.kernels.colour import Coding
from makeup_video.kernels.material import ENVIRONMENT_PX, LEAST_ROOM
from makeup_video.kernels.material_twin import Environment, Material
from makeup_video.kernels.paint_twin import Layers
from makeup_video.kernels.product import (
    DARK,
    DISSOLVE,
    LARGEST_SPOT,
    LEAST_CELL_PX,
    LEAST_SPOT_PX,
    NONE,
    SPOT,
    VEIL,
)
from makeup_video.pipeline.frames.affine import Affine
from makeup_video.pipeline.look.params import GraphicsParams
from makeup_video.pipeline.render.environment import blur_matrix, room_colours
from makeup_video.pipeline.render.product_material import (
    LUMINANCE,
    ceiling_of,
    film_matrices,
    least_cell,
    sparing,
    unlit,
)
from makeup_video.pipeline.render.scene import SceneLight

# Numbers of a material that are the same all over a surface: each is the mean over its layers,
# weighted by how much of a layer's opacity or reflection shows. `_common` finds the other numbers.
_BY_OPACITY = "texture", "undertone", "keep_highlights", "dark_gain", "dark_offset"
_BY_REFLECTION = "fresnel_front", "fresnel_rim"
_opacities, _reflections = attrgetter(*_BY_OPACITY), attrgetter(*_BY_REFLECTION)


@dataclass(frozen=True, slots=True)
class SkinAxes:
    """How a region lies in the frame.

    turn: (2, 2) unit columns, the directions of the region's x and y axes in the frame.
    skin_px: the distance of the eyes in px of the frame. That distance is the unit of coordinates
    that stick to the skin.
    """

    turn: tuple[tuple[float, float], tuple[float, float]]
    skin_px: float


def material(
    params: GraphicsParams,
    amount: float,
    light: SceneLight,
    axes: SkinAxes,
    coding: Coding,
    spared: float = 0.0,
    shade: float = 1.0,
    keep_highlights: float = 1.0,
) -> Material:
    """A product under a light, as the kernel paints it.

    amount: 0..1, scales all of the product (strength, intensity).
    spared: see `sparing`.  shade: share of the light that falls on the region.
    keep_highlights: how much of the skin's own highlights stays on the product, 0..1.
    """
    whole, ceiling = unlit(params), ceiling_of(coding)
    to_film, from_film = film_matrices(coding.primaries)
    share = params.light_adaptation
    strength = light.strength_for_products * shade
    gain = [1 + share * (part * strength - 1) for part in _turned(light, to_film)]
    cell, spot, seen = _cells(params, axes)
    fine = 1 - 0.5 * seen  # sparkles that are not seen one by one make a sheen
    (red, green, blue), (r, g, b) = gain, [part * amount for part in gain]
    (xx, xy), (yx, yy), (dark_gain, dark_offset) = *axes.turn, sparing(spared)
    (r0, g0, b0), (r1, g1, b1), (r2, g2, b2), (r3, g3, b3) = whole.lights
    return Material(
        product=(_lit(r0, red, ceiling), _lit(g0, green, ceiling), _lit(b0, blue, ceiling)),
        glint=(r * (r1 + r2 * fine), g * (g1 + g2 * fine), b * (b1 + b2 * fine)),
        sparkle=(r * r3 * seen, g * g3 * seen, b * b3 * seen),
        luminance=LUMINANCE,
        opacity=params.opacity * amount,
        texture=params.texture_keep,
        undertone=params.undertone,
        keep_highlights=keep_highlights,
        own_highlights=whole.own_highlights * amount,
        lobe=whole.lobe,
        half_way=_half_way(light, axes),
        reflection=params.reflection * amount,
        fresnel_front=whole.fresnel_front,
        fresnel_rim=whole.fresnel_rim,
        room=(whole.room * xx, whole.room * xy, whole.room * yx, whole.room * yy),
        shimmer=whole.shimmer,
        cells=1 / cell,
        spot=spot * spot,
        dark=DARK * max(strength, 0.1),
        dark_gain=dark_gain,
        dark_offset=dark_offset,
        to_film=to_film,
        from_film=from_film,
        ceiling=ceiling,
    )


@lru_cache(maxsize=16)  # all layers on a face are in the same light
def _turned(light: SceneLight, rows: tuple[float, ...]) -> list[float]:
    """The light's colour in other primaries, 0 or more; rows: a (3, 3) matrix, row by row."""
    red, green, blue = light.colour.tolist()
    parts = (rows[i] * red + rows[i + 1] * green + rows[i + 2] * blue for i in (0, 3, 6))
    return [max(part, 0.0) for part in parts]


def _lit(product: float, gain: float, ceiling: float) -> float:
    """A channel of a product under a light of this gain; even in strong light a pale product keeps
    room for its highlights."""
    below, above = product * min(gain, 1.0), product * max(gain - 1, 0.0)
    room = max(ceiling - below, 0.0) + LEAST_ROOM  # as `added` does
    return below + room * above / (room + above)


def _cells(params: GraphicsParams, axes: SkinAxes) -> tuple[float, float, float]:
    """Shimmer: size of a cell, radius of a sparkle in cells, how far sparkles are seen (0..1).

    On a small face the cells are two, four or eight times as large, so that a sparkle covers
    several pixels. Around the sizes where this number changes, sparkles fade out: otherwise all of
    them would jump at once.
    """
    cell, most_doublings = least_cell(params)
    if not params.shimmer:
        return cell, SPOT, 0.0
    wanted = math.ceil(math.log2(LEAST_CELL_PX / (cell * axes.skin_px)))
    doublings = max(min(wanted, most_doublings), 0)
    cell *= 2**doublings
    cell_px = cell * axes.skin_px
    beyond = cell_px / LEAST_CELL_PX - 1
    seen = min(max(beyond / DISSOLVE, 0.0), 1.0)
    if doublings:
        seen *= min(max((1 - beyond) / DISSOLVE, 0.0), 1.0)
    return cell, min(max(SPOT, LEAST_SPOT_PX / cell_px), LARGEST_SPOT), seen


def _half_way(light: SceneLight, axes: SkinAxes) -> tuple[float, float, float]:
    """Unit vector between the light and the viewer, in the region's axes, z to the viewer."""
    (a, b), (c, d) = axes.turn
    right, down, away = light.direction.tolist()
    (x, y), z = Affine(a, b, 0.0, c, d, 0.0).solve(right, down), 1 - away
    length = math.sqrt(x * x + y * y + z * z)
    return x / length, y / length, z / length


def blend(shares: np.ndarray, materials: Sequence[Material]) -> tuple[Layers, Material]:
    """Compose layers, the lowest first, as if each were painted on the ones before it.

    shares: (layers, H, W) float32 on the surface's grid, from `shares_of`.
    materials: the products, at least one, all under the light of one scene.
    Returns the layers and the material of a PaintedRegion. Where all shares are 0, opacity, glint
    and shine are 0. A film over a highlight covers it by the film's opacity. Painting one layer
    after another would also mix the highlight's root of light, so a highlight that is seen through
    another film is an approximation.
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
    """How much each layer shines, 0..1: 1 for a layer that has most own highlights, most reflection
    or most sparkles of all."""
    kinds = [[m.own_highlights, m.reflection, m.shimmer * max(m.sparkle)] for m in materials]
    most = [max(kind) for kind in zip(*kinds, strict=True)]
    return [
        max(part / top if top > 0 else 0.0 for part, top in zip(kind, most, strict=True))
        for kind in kinds
    ]


def _common(
    materials: Sequence[Material], shines: Sequence[float], seen: Sequence[float]
) -> Material:
    """The material whose numbers the kernel uses all over a surface.

    seen: how much each layer shows.  shines: see `_shines`.
    """
    if len(materials) == 1:
        return materials[0]
    opaque = [part * m.opacity for part, m in zip(seen, materials, strict=True)]
    glints = [part * max(m.glint) for part, m in zip(seen, materials, strict=True)]
    mirrors = [part * m.reflection for part, m in zip(seen, materials, strict=True)]
    sparkling = [part * m.shimmer * max(m.sparkle) for part, m in zip(seen, materials, strict=True)]
    # The map of shine multiplies these strengths, so they are divided by the sum of the map
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
    """The mean of each column, weighted by share; the plain mean where no layer has a share."""
    total = sum(shares)
    if total <= NONE:
        shares, total = [1.0] * len(rows), float(len(rows))
    return [sum(map(mul, column, shares)) / total for column in zip(*rows, strict=True)]


def environment_of(room: np.ndarray, params: GraphicsParams, coding: Coding) -> Environment:
    """What the product mirrors, blurred as its parameters say.

    Most of the room's mean light is subtracted: gloss should show windows and lamps, and an even
    room would only lay a veil over the colour.

    room: (16, 16, 3), see SceneLight.
    """
    if not params.reflection:
        return Environment.of(np.zeros((3, ENVIRONMENT_PX, ENVIRONMENT_PX), np.float32))
    blur = blur_matrix(params)
    turned = np.moveaxis(room @ room_colours(coding.primaries).T, -1, 0)
    blurred = blur @ turned @ blur.T
    bright = np.maximum(blurred - VEIL * blurred.mean((1, 2), keepdims=True), 0)
    return Environment.of(bright.astype(np.float32))
