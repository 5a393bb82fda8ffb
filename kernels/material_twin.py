"""Makeup on a surface, in linear light: recolouring, gloss, reflection, shimmer.

The numpy twin of material.h, in float64 over arrays of pixels.
The two steps are those of Kips et al. (2021), section 3.1: recolouring, then texture.
"""

from dataclasses import dataclass
from operator import attrgetter
from typing import Any

import numpy as np
from makeup_video.kernels.material import (
    BREAKUP_GAIN,
    BREAKUP_MOST,
    BREAKUP_START,
    BRIGHTEST,
    BRIGHTEST_SHADE,
    CELLS_BEFORE_ZERO,
    FAINTEST_STEP,
    FINEST,
    LAST,
    LEAST_ROOM,
    LOBE_TAIL,
    MATERIAL,
    MIDDLE,
    OWN_HUE,
    ROOM_BITS,
    SPARKLE_MARGIN,
    SPARKLE_NARROWNESS,
    SPARKLE_SPREAD,
    SPARKLE_TILT,
    STEEPEST,
)

_SHIFTS = ROOM_BITS * np.arange(3, dtype=np.uint32)[:, None, None]


@dataclass(slots=True, eq=False)  # not frozen: a frozen one takes three times as long to make
class Material:
    """A product under the light of a scene: the fields of MATERIAL, see there."""

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

    words: (16, 16) uint32, three channels of linear light each, red in the lowest bits.  step: the
    light of one step of a channel.
    """

    words: np.ndarray
    step: float

    @classmethod
    def of(cls, linear: np.ndarray) -> "Environment":
        """Pack linear light, (3, 16, 16) float32, 0 or more."""
        most = 2**ROOM_BITS - 1
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
        channels: np.ndarray = (self.words >> _SHIFTS) & np.uint32(2**ROOM_BITS - 1)
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
    shrink = np.sqrt(STEEPEST / (STEEPEST + np.maximum(steep - STEEPEST, 0)))
    nx, ny = nx * shrink, ny * shrink
    nz = np.sqrt(1 - (nx * nx + ny * ny))
    shade = np.minimum((coarse + m.dark) / (mean + m.dark), BRIGHTEST_SHADE)
    facing = np.maximum(nx * m.half_way[0] + ny * m.half_way[1] + nz * m.half_way[2], 0)
    # Trowbridge and Reitz's lobe (GGX), 1 at its peak, without its tail
    lobe = (m.lobe / (1 - facing * facing * (1 - m.lobe))) ** 2
    lobe = exposed * np.maximum(lobe - LOBE_TAIL, 0) / (1 - LOBE_TAIL)
    mirror = exposed * m.reflection * (m.fresnel_front + m.fresnel_rim * (1 - nz) ** 3)
    rx, ry = 2 * nz * nx, 2 * nz * ny
    ex = np.clip(MIDDLE + m.room[0] * rx + m.room[1] * ry, 0, LAST)
    ey = np.clip(MIDDLE + m.room[2] * rx + m.room[3] * ry, 0, LAST)
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
    iu, iv = ((along + np.float32(CELLS_BEFORE_ZERO)).astype(np.uint32) for along in (u, v))
    number = iu * np.uint32(374761393) + iv * np.uint32(668265263)
    number = (number ^ (number >> np.uint32(13))) * np.uint32(1274126177)
    number ^= number >> np.uint32(16)

    def bits(shift: int) -> np.ndarray:
        part: np.ndarray = ((number >> np.uint32(shift)) & np.uint32(255)).astype(np.float64) / 256
        return part

    origin = float(CELLS_BEFORE_ZERO)
    du = u - (iu - origin) - SPARKLE_MARGIN - SPARKLE_SPREAD * bits(8)
    dv = v - (iv - origin) - SPARKLE_MARGIN - SPARKLE_SPREAD * bits(16)
    tx = skin.nx - m.half_way[0] + SPARKLE_TILT * (bits(4) - 0.5)
    ty = skin.ny - m.half_way[1] - SPARKLE_TILT * (0.5 - bits(12))
    spot = np.maximum(1 - (du * du + dv * dv) / m.spot, 0)
    glint = np.maximum(1 - SPARKLE_NARROWNESS * (tx * tx + ty * ty), 0)
    sparkle: np.ndarray = np.where(bits(0) < np.float32(m.shimmer), spot**2 * glint, 0)
    return sparkle


@dataclass(slots=True)
class Varying:
    """The numbers of a Material that may vary over a region, at every pixel.

    product, glint: (h, w, 3), in place of the material's own.  opacity: (h, w), likewise.
    shine: (h, w), factor of its sparkle, own_highlights and reflection.
    """

    product: np.ndarray
    opacity: np.ndarray
    glint: np.ndarray
    shine: np.ndarray


def even(m: Material) -> Varying:
    """The material's own numbers, the same everywhere."""
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
    fine = np.minimum(lit / broad, BRIGHTEST)
    matte = np.minimum(fine, FINEST)
    shade = skin.shade * (1 + m.texture * (matte - 1))
    below = np.minimum(shade, 1)
    bright = (local.product @ np.array(m.luminance)) / lit  # as a multiple of the pixel's light
    through = m.undertone * bright
    # dark places are spared only where the product would lighten them
    kept = np.clip(m.dark_offset + m.dark_gain * fine, 0, 1)
    lighter = np.maximum(bright * shade - 1, 0)
    opaque = weight * local.opacity * (1 - np.minimum(1 - kept, lighter))
    weight = weight * kept
    # as a multiple of the pixel's light; bright skin at the makeup's edge is no highlight
    highlight = weight * (fine - matte) * broad / lit
    breakup = np.clip(BREAKUP_GAIN * fine - BREAKUP_START, 0, BREAKUP_MOST)
    lobe = weight * skin.lobe * breakup
    shown = weight * local.shine * m.own_highlights * highlight
    sparkle = weight * local.shine * sparkles(u, v, skin, m)

    seen = np.maximum(under, 0)
    own = m.texture * m.keep_highlights
    base = local.product * (1 - m.undertone) + seen * through[..., None]
    shining = (1 - OWN_HUE) * lit[..., None] + OWN_HUE * seen
    extra = base * (shade - below)[..., None] + (own * highlight)[..., None] * shining
    laid = added(base * below[..., None], extra, m.ceiling)
    # A thin film takes light from what is under it, so it deepens before it covers. A mix of linear
    # light would look milky. A mix of roots of light is close to what painting programs do.
    opaque = opaque[..., None]
    root = np.sqrt(seen)
    root = root + opaque * (np.sqrt(np.abs(laid)) - root)
    film = under + root * root - seen - opaque * (under - seen)
    more = lobe[..., None] * local.glint + shown[..., None] * shining
    more = more + sparkle[..., None] * np.array(m.sparkle)
    more = more + (weight * local.shine * skin.mirror)[..., None] * skin.room
    made: np.ndarray = bare + (added(film, more, m.ceiling) - under) @ from_film.T
    return made
