"""Makeup on a surface, in linear light: recolouring, gloss, reflection, shimmer.

The numpy twin of material.h, in float64 over arrays of pixels, with its constants and its struct.
The two steps are those of Kips et al. (2021), section 3.1: recolouring, then texture.
"""

from dataclasses import dataclass
from operator import attrgetter
from typing import Any

import numpy as np
from makeup_video.kernels.definitions import Definitions

ENVIRONMENT_PX = 16  # side of an environment image
_ROOM_BITS = 10  # of each channel of an environment in the kernel: three in one word
FAINTEST_STEP = 1e-30  # of an environment: the inverse of a fainter one may overflow
_SHIFTS = _ROOM_BITS * np.arange(3, dtype=np.uint32)[:, None, None]
_MIDDLE, _LAST = (ENVIRONMENT_PX - 1) / 2, ENVIRONMENT_PX - 1.001  # texels that a ray may reach
_FINEST = 1.25  # times the broad light: brighter light is a highlight, not texture
_BRIGHTEST = 6.0  # times the broad light
_BRIGHTEST_SHADE = 4.0  # times the mean of the region
_OWN_HUE = 0.6  # of the pixel's hue, in highlights that the skin has; with all they are orange
_STEEPEST = 0.96  # of nx^2 + ny^2: a steeper normal would turn away from the viewer
LEAST_ROOM = 1e-4
_LOBE_TAIL = 0.3  # of the highlight's peak: the fainter rest would veil the product
# How fine light breaks up the synthetic highlight.
_BREAKUP_GAIN, _BREAKUP_START, _BREAKUP_MOST = 2.5, 1.5, 2.0
# Sparkles: added to coordinates so that cells count from 0; margin and spread of a sparkle's place
# within its cell; how far sparkles are tilted; how narrow their glint is.
_CELLS_BEFORE_ZERO = 4096
_SPARKLE_MARGIN, _SPARKLE_SPREAD, _SPARKLE_TILT, _SPARKLE_NARROWNESS = 0.3, 0.4, 1.3, 2.5

# The struct of material.h: the fields of Material.
MATERIAL = np.dtype([
    ("product", np.float32, 3),
    ("glint", np.float32, 3),
    ("sparkle", np.float32, 3),
    ("luminance", np.float32, 3),
    ("opacity", np.float32),
    ("texture", np.float32),
    ("undertone", np.float32),
    ("keep_highlights", np.float32),
    ("own_highlights", np.float32),
    ("lobe", np.float32),
    ("half_way", np.float32, 3),
    ("reflection", np.float32),
    ("fresnel_front", np.float32),
    ("fresnel_rim", np.float32),
    ("room", np.float32, 4),
    ("shimmer", np.float32),
    ("cells", np.float32),
    ("spot", np.float32),
    ("dark", np.float32),
    ("dark_gain", np.float32),
    ("dark_offset", np.float32),
    ("to_film", np.float32, 9),
    ("from_film", np.float32, 9),
    ("ceiling", np.float32),
])  # fmt: skip
DEFINITIONS = Definitions(
    {
        "MATERIAL_ENVIRONMENT_PX": ENVIRONMENT_PX,
        "MATERIAL_ROOM_BITS": _ROOM_BITS,
        "MATERIAL_MIDDLE": _MIDDLE,
        "MATERIAL_LAST": _LAST,
        "MATERIAL_FINEST": _FINEST,
        "MATERIAL_BRIGHTEST": _BRIGHTEST,
        "MATERIAL_BRIGHTEST_SHADE": _BRIGHTEST_SHADE,
        "MATERIAL_STEEPEST": _STEEPEST,
        "MATERIAL_OWN_HUE": _OWN_HUE,
        "MATERIAL_LEAST_ROOM": LEAST_ROOM,
        "MATERIAL_LOBE_TAIL": _LOBE_TAIL,
        "MATERIAL_BREAKUP_GAIN": _BREAKUP_GAIN,
        "MATERIAL_BREAKUP_START": _BREAKUP_START,
        "MATERIAL_BREAKUP_MOST": _BREAKUP_MOST,
        "MATERIAL_CELLS_BEFORE_ZERO": _CELLS_BEFORE_ZERO,
        "MATERIAL_SPARKLE_MARGIN": _SPARKLE_MARGIN,
        "MATERIAL_SPARKLE_SPREAD": _SPARKLE_SPREAD,
        "MATERIAL_SPARKLE_TILT": _SPARKLE_TILT,
        "MATERIAL_SPARKLE_NARROWNESS": _SPARKLE_NARROWNESS,
    },
    {"material": MATERIAL},
)


@dataclass(slots=True, eq=False)  # not frozen: that takes three times as long to make
class Material:
    """A product under the light of a scene, as the kernel takes it. Light is linear; colours are
    in sRGB's primaries.

    product: the product's colour, lit.
    glint, sparkle: colour and strength of the synthetic highlight and of shimmer.
    luminance: weights of red, green and blue.
    opacity: 0..1.
    texture: how much of the skin's fine light and dark survives, 0..1.
    undertone: how much of the skin's chroma survives, 0..1.
    keep_highlights: how much of the skin's own highlights stays on the film, 0..1.
    own_highlights: gain of the highlights that the skin has.
    lobe: squared width of the synthetic highlight, 0..1.
    half_way: unit vector between light and viewer, z towards the viewer.
    reflection: 0..1.
    fresnel_front, fresnel_rim: share of the reflection where the surface faces the viewer, and what
    is added where the surface turns away.
    room: (2, 2) by rows, from the x and y of a reflected ray to texels of the environment.
    shimmer: share of the cells that hold a sparkle.
    cells: number of cells per unit of the coordinates that stick to the skin.
    spot: squared radius of a sparkle, in cells.
    dark: light below which differences do not count.
    dark_gain, dark_offset: the weight is multiplied by dark_offset + dark_gain * fine light,
    clipped to 0..1. So what is dark is spared, except from a film that darkens it.
    to_film, from_film: (3, 3) by rows, from the frame's primaries to sRGB's and back.
    ceiling: the brightest light that is painted.
    """

    product: tuple[float, ...]
    glint: tuple[float, ...]
    sparkle: tuple[float, ...]
    luminance: tuple[float, ...]
    opacity: float
    texture: float
    undertone: float
    keep_highlights: float
    own_highlights: float
    lobe: float
    half_way: tuple[float, float, float]
    reflection: float
    fresnel_front: float
    fresnel_rim: float
    room: tuple[float, float, float, float]
    shimmer: float
    cells: float
    spot: float
    dark: float
    dark_gain: float
    dark_offset: float
    to_film: tuple[float, ...]
    from_film: tuple[float, ...]
    ceiling: float

    def record(self) -> tuple[Any, ...]:
        """Return the fields in the order of MATERIAL, to be assigned to such a record."""
        values: tuple[Any, ...] = _of_record(self)
        return values


_of_record = attrgetter(*(MATERIAL.names or ()))


@dataclass(frozen=True, slots=True, eq=False)
class Environment:
    """What glossy makeup mirrors, as the kernel takes it.

    words: (16, 16) uint32, three channels of linear light each, red in the lowest bits.  step: of a
    channel.
    """

    words: np.ndarray
    step: float

    @classmethod
    def of(cls, linear: np.ndarray) -> "Environment":
        """linear: (3, 16, 16) float32, 0 or more."""
        most = 2**_ROOM_BITS - 1
        step = float(linear.max()) / most
        if step < FAINTEST_STEP:
            return cls(np.zeros(linear.shape[1:], np.uint32), 0.0)
        steps = linear * np.float32(1 / step)
        steps += np.float32(0.5)
        red, green, blue = steps.astype(np.uint32) << _SHIFTS
        red |= green
        red |= blue
        return cls(red, step)

    def linear(self) -> np.ndarray:
        """(3, 16, 16) float64."""
        channels: np.ndarray = (self.words >> _SHIFTS) & np.uint32(2**_ROOM_BITS - 1)
        return channels * self.step


@dataclass(slots=True)
class Skin:
    """The surface of the skin at every pixel, as material_at returns it: (h, w); room (h, w, 3)."""

    coarse: np.ndarray
    shade: np.ndarray
    nx: np.ndarray
    ny: np.ndarray
    lobe: np.ndarray
    mirror: np.ndarray
    room: np.ndarray


def skin_at(
    coarse: np.ndarray,
    mean: float,
    nx: np.ndarray,
    ny: np.ndarray,
    environment: np.ndarray,
    m: Material,
    exposed: np.ndarray | float = 1.0,
) -> Skin:
    """Compute the skin's surface: the twin of material_at.

    environment: (3, 16, 16), linear.
    exposed: the share of the synthetic highlight and the reflection that is seen.
    """
    steep = nx * nx + ny * ny
    shrink = np.sqrt(_STEEPEST / (_STEEPEST + np.maximum(steep - _STEEPEST, 0)))
    nx, ny = nx * shrink, ny * shrink
    nz = np.sqrt(1 - (nx * nx + ny * ny))
    shade = np.minimum((coarse + m.dark) / (mean + m.dark), _BRIGHTEST_SHADE)
    facing = np.maximum(nx * m.half_way[0] + ny * m.half_way[1] + nz * m.half_way[2], 0)
    # Trowbridge and Reitz's lobe (GGX), 1 at its peak, without its tail
    lobe = (m.lobe / (1 - facing * facing * (1 - m.lobe))) ** 2
    lobe = exposed * np.maximum(lobe - _LOBE_TAIL, 0) / (1 - _LOBE_TAIL)
    mirror = exposed * m.reflection * (m.fresnel_front + m.fresnel_rim * (1 - nz) ** 3)
    rx, ry = 2 * nz * nx, 2 * nz * ny
    ex = np.clip(_MIDDLE + m.room[0] * rx + m.room[1] * ry, 0, _LAST)
    ey = np.clip(_MIDDLE + m.room[2] * rx + m.room[3] * ry, 0, _LAST)
    return Skin(coarse, shade, nx, ny, lobe, mirror, bilinear(environment, ex, ey))


def bilinear(image: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Sample an image (C, H, W) at places (...) within it -> (..., C)."""
    ix, iy = x.astype(int), y.astype(int)
    fx, fy = x - ix, y - iy
    corners = [(0, 0, (1 - fx) * (1 - fy)), (1, 0, fx * (1 - fy)),
               (0, 1, (1 - fx) * fy), (1, 1, fx * fy)]  # fmt: skip
    total: np.ndarray = sum(image[:, iy + dy, ix + dx] * share for dx, dy, share in corners)
    return np.moveaxis(total, 0, -1)


def added(base: np.ndarray, more: np.ndarray, ceiling: float) -> np.ndarray:
    """Add light to light: nearly `base + more` while there is room, and never above the ceiling."""
    room = np.maximum(ceiling - base, 0) + LEAST_ROOM
    sum_: np.ndarray = base + room * more / (room + more)
    return sum_


def sparkles(u: np.ndarray, v: np.ndarray, skin: Skin, m: Material) -> np.ndarray:
    """Light of sparkles that stick to the skin: one or none in each cell, each tilted."""
    # float32 as in the kernel, or cells would differ at their borders
    u = np.float32(m.cells) * u.astype(np.float32)
    v = np.float32(m.cells) * v.astype(np.float32)
    iu, iv = ((along + np.float32(_CELLS_BEFORE_ZERO)).astype(np.uint32) for along in (u, v))
    number = iu * np.uint32(374761393) + iv * np.uint32(668265263)
    number = (number ^ (number >> np.uint32(13))) * np.uint32(1274126177)
    number ^= number >> np.uint32(16)

    def bits(shift: int) -> np.ndarray:
        part: np.ndarray = ((number >> np.uint32(shift)) & np.uint32(255)).astype(np.float64) / 256
        return part

    origin = float(_CELLS_BEFORE_ZERO)
    du = u - (iu - origin) - _SPARKLE_MARGIN - _SPARKLE_SPREAD * bits(8)
    dv = v - (iv - origin) - _SPARKLE_MARGIN - _SPARKLE_SPREAD * bits(16)
    tx = skin.nx - m.half_way[0] + _SPARKLE_TILT * (bits(4) - 0.5)
    ty = skin.ny - m.half_way[1] - _SPARKLE_TILT * (0.5 - bits(12))
    spot = np.maximum(1 - (du * du + dv * dv) / m.spot, 0)
    glint = np.maximum(1 - _SPARKLE_NARROWNESS * (tx * tx + ty * ty), 0)
    sparkle: np.ndarray = np.where(bits(0) < np.float32(m.shimmer), spot**2 * glint, 0)
    return sparkle


@dataclass(slots=True)
class Varying:
    """What of a Material may vary over a region, at every pixel.

    product, glint: (h, w, 3), in place of the material's own.  opacity: (h, w), likewise.
    shine: (h, w), factor of its sparkle, own_highlights and reflection.
    """

    product: np.ndarray
    opacity: np.ndarray
    glint: np.ndarray
    shine: np.ndarray


def even(m: Material) -> Varying:
    """The same everywhere: what the material says itself."""
    one = np.ones((1, 1))
    product, glint = (np.reshape(rgb, (1, 1, 3)) for rgb in (m.product, m.glint))
    return Varying(product, m.opacity * one, glint, one)


def made_up(
    bare: np.ndarray,
    weight: np.ndarray,
    u: np.ndarray,
    v: np.ndarray,
    skin: Skin,
    m: Material,
    varying: Varying | None = None,
) -> np.ndarray:
    """Put makeup of a weight on the light of pixels (h, w, 3): the twin of material_paint.

    Makeup is computed in sRGB's primaries, so that a product looks the same in every video.
    varying: None for a product that is the same everywhere.
    """
    local = even(m) if varying is None else varying
    to_film, from_film = (np.array(rows).reshape(3, 3) for rows in (m.to_film, m.from_film))
    under = bare @ to_film.T
    lit = np.maximum(under @ np.array(m.luminance), 0) + m.dark
    broad = skin.coarse + m.dark
    fine = np.minimum(lit / broad, _BRIGHTEST)
    matte = np.minimum(fine, _FINEST)
    shade = skin.shade * (1 + m.texture * (matte - 1))
    below = np.minimum(shade, 1)
    bright = (local.product @ np.array(m.luminance)) / lit  # as a multiple of the pixel's light
    through = m.undertone * bright
    # what is dark is spared only where the product would lighten it
    kept = np.clip(m.dark_offset + m.dark_gain * fine, 0, 1)
    lighter = np.maximum(bright * shade - 1, 0)
    opaque = weight * local.opacity * (1 - np.minimum(1 - kept, lighter))
    weight = weight * kept
    # as a multiple of the pixel's light; at the edge bright skin is none
    highlight = weight * (fine - matte) * broad / lit
    breakup = np.clip(_BREAKUP_GAIN * fine - _BREAKUP_START, 0, _BREAKUP_MOST)
    lobe = weight * skin.lobe * breakup
    shown = weight * local.shine * m.own_highlights * highlight
    sparkle = weight * local.shine * sparkles(u, v, skin, m)

    seen = np.maximum(under, 0)
    own = m.texture * m.keep_highlights
    base = local.product * (1 - m.undertone) + seen * through[..., None]
    shining = (1 - _OWN_HUE) * lit[..., None] + _OWN_HUE * seen
    extra = base * (shade - below)[..., None] + (own * highlight)[..., None] * shining
    laid = added(base * below[..., None], extra, m.ceiling)
    # A thin film takes light from what is under it, so it deepens before it covers: mixing linear
    # light would look milky. The root of light is close to what painting programs mix.
    opaque = opaque[..., None]
    root = np.sqrt(seen)
    root = root + opaque * (np.sqrt(np.abs(laid)) - root)
    film = under + root * root - seen - opaque * (under - seen)
    more = lobe[..., None] * local.glint + shown[..., None] * shining
    more = more + sparkle[..., None] * np.array(m.sparkle)
    more = more + (weight * local.shine * skin.mirror)[..., None] * skin.room
    made: np.ndarray = bare + (added(film, more, m.ceiling) - under) @ from_film.T
    return made
