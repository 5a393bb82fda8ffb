"""Makeup on a surface, in linear light: recolouring, gloss, reflection, shimmer.

The numpy twin of material.h, in float64 over arrays of pixels, and what its struct means. The two
steps are those of Kips et al. (2021), section 3.1: recolouring, then texture.
"""

from dataclasses import dataclass, fields

import numpy as np

ENVIRONMENT_PX = 16  # side of an environment image
_FINEST = 1.25  # times the broad light: what is brighter counts as a highlight, not as texture
_BRIGHTEST = 6.0
_STEEPEST = 0.96  # of nx^2 + ny^2: beyond, a normal would turn away from the viewer
LEAST_ROOM = 1e-4


@dataclass(frozen=True, slots=True, eq=False)
class Material:
    """A product under the light of a scene, as the kernel takes it. Light is linear; colours are
    in sRGB's primaries.

    product: its colour, lit.  glint, sparkle: colour and strength of synthetic highlights and of
    shimmer.  luminance: weights of red, green and blue.  opacity: 0..1.  texture: how much fine
    light and dark of the skin survives, 0..1.  undertone: how much of its chroma, 0..1.
    own_highlights: how much is added to highlights that the skin has.  lobe: squared width of the
    synthetic highlight, 0..1.  half_way: unit vector between light and viewer, z to the viewer.
    reflection: 0..1; fresnel_front, fresnel_rim: its share where the surface faces the viewer, and
    what comes on top where it turns away.  room: turns a reflected ray into texels of the
    environment.  shimmer: share of the cells that hold a sparkle.  cells: their number for each
    unit of the coordinates that stick to the skin.  spot: a sparkle's squared radius, in cells.
    dark: light below which nothing is told apart.  dark_gain,
    dark_offset: the weight is multiplied by dark_offset + dark_gain * fine light, held in 0..1.  to_film,
    from_film: (3, 3) by rows, from the frame's primaries to sRGB's and back.  ceiling: the brightest light that is painted.
    """

    product: tuple[float, ...]
    glint: tuple[float, ...]
    sparkle: tuple[float, ...]
    luminance: tuple[float, ...]
    opacity: float
    texture: float
    undertone: float
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

    def numbers(self) -> list[float]:
        """The struct `material` of material.h: 52 numbers."""
        numbers: list[float] = []
        for name in _NAMES:
            value = getattr(self, name)
            numbers.extend(value) if isinstance(value, tuple) else numbers.append(value)
        return numbers


_NAMES = [field.name for field in fields(Material)]


@dataclass(slots=True)
class Skin:
    """What material_at finds out of every pixel. (h, w) arrays; room (h, w, 3)."""

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
) -> Skin:
    """The twin of material_at. environment: (3, 16, 16) linear."""
    steep = nx * nx + ny * ny
    shrink = np.sqrt(_STEEPEST / (_STEEPEST + np.maximum(steep - _STEEPEST, 0)))
    nx, ny = nx * shrink, ny * shrink
    nz = np.sqrt(1 - (nx * nx + ny * ny))
    shade = np.minimum((coarse + m.dark) / (mean + m.dark), 4)
    facing = np.maximum(nx * m.half_way[0] + ny * m.half_way[1] + nz * m.half_way[2], 0)
    # Trowbridge and Reitz's lobe (GGX), 1 at its peak
    lobe = (m.lobe / (1 - facing * facing * (1 - m.lobe))) ** 2
    mirror = m.reflection * (m.fresnel_front + m.fresnel_rim * (1 - nz) ** 3)
    rx, ry = 2 * nz * nx, 2 * nz * ny
    middle, last = (ENVIRONMENT_PX - 1) / 2, ENVIRONMENT_PX - 1.001
    ex = np.clip(middle + m.room[0] * rx + m.room[1] * ry, 0, last)
    ey = np.clip(middle + m.room[2] * rx + m.room[3] * ry, 0, last)
    return Skin(coarse, shade, nx, ny, lobe, mirror, bilinear(environment, ex, ey))


def bilinear(image: np.ndarray, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """(C, H, W) at places within it -> (..., C)."""
    ix, iy = x.astype(int), y.astype(int)
    fx, fy = x - ix, y - iy
    corners = [(0, 0, (1 - fx) * (1 - fy)), (1, 0, fx * (1 - fy)),
               (0, 1, (1 - fx) * fy), (1, 1, fx * fy)]  # fmt: skip
    total: np.ndarray = sum(image[:, iy + dy, ix + dx] * share for dx, dy, share in corners)
    return np.moveaxis(total, 0, -1)


def added(base: np.ndarray, more: np.ndarray, ceiling: float) -> np.ndarray:
    """Light upon light: nearly `base + more` while there is room, and never above the ceiling."""
    room = np.maximum(ceiling - base, 0) + LEAST_ROOM
    sum_: np.ndarray = base + room * more / (room + more)
    return sum_


def sparkles(u: np.ndarray, v: np.ndarray, skin: Skin, m: Material) -> np.ndarray:
    """Sparkles that stick to the skin: each cell has one or none, tilted its own way."""
    # float32 as in the kernel, or cells would differ at their borders
    u = np.float32(m.cells) * u.astype(np.float32)
    v = np.float32(m.cells) * v.astype(np.float32)
    iu, iv = ((at + np.float32(4096)).astype(np.uint32) for at in (u, v))
    number = iu * np.uint32(374761393) + iv * np.uint32(668265263)
    number = (number ^ (number >> np.uint32(13))) * np.uint32(1274126177)
    number ^= number >> np.uint32(16)

    def bits(shift: int) -> np.ndarray:
        part: np.ndarray = ((number >> np.uint32(shift)) & np.uint32(255)).astype(np.float64) / 256
        return part

    du = u - (iu - 4096.0) - 0.3 - 0.4 * bits(8)
    dv = v - (iv - 4096.0) - 0.3 - 0.4 * bits(16)
    tx = skin.nx - m.half_way[0] + 1.3 * (bits(4) - 0.5)
    ty = skin.ny - m.half_way[1] - 1.3 * (0.5 - bits(12))
    spot = np.maximum(1 - (du * du + dv * dv) / m.spot, 0)
    glint = np.maximum(1 - 2.5 * (tx * tx + ty * ty), 0)
    sparkle: np.ndarray = np.where(bits(0) < np.float32(m.shimmer), spot**2 * glint, 0)
    return sparkle


def made_up(
    bare: np.ndarray, weight: np.ndarray, u: np.ndarray, v: np.ndarray, skin: Skin, m: Material
) -> np.ndarray:
    """The light of pixels (h, w, 3) with makeup of that weight on them: material_paint's twin.

    It is computed in sRGB's primaries, so that a product looks the same in every video.
    """
    to_film, from_film = (np.array(rows).reshape(3, 3) for rows in (m.to_film, m.from_film))
    under = bare @ to_film.T
    lit = np.maximum(under @ np.array(m.luminance), 0) + m.dark
    broad = skin.coarse + m.dark
    fine = np.minimum(lit / broad, _BRIGHTEST)
    weight = weight * np.clip(m.dark_offset + m.dark_gain * fine, 0, 1)
    matte = np.minimum(fine, _FINEST)
    highlight = weight * (fine - matte) * broad  # at the edge bright skin is no highlight
    shade = skin.shade * (1 + m.texture * (matte - 1))
    below = np.minimum(shade, 1)
    product = np.array(m.product)
    through = m.undertone * (product @ np.array(m.luminance)) / lit
    breakup = np.clip(2.5 * fine - 1.5, 0, 2)
    lobe = weight * skin.lobe * breakup
    shown = weight * m.own_highlights * highlight
    sparkle = weight * sparkles(u, v, skin, m)

    seen = np.maximum(under, 0)
    base = product * (1 - m.undertone) + seen * through[..., None]
    extra = base * (shade - below)[..., None] + (m.texture * highlight)[..., None]
    laid = added(base * below[..., None], extra, m.ceiling)
    # A thin film takes light from what is under it, so it deepens before it covers: mixing light
    # itself would look milky. The root of light is near to what painting programs mix.
    opaque = (weight * m.opacity)[..., None]
    root = np.sqrt(seen)
    root = root + opaque * (np.sqrt(np.abs(laid)) - root)
    film = under + root * root - seen - opaque * (under - seen)
    more = lobe[..., None] * np.array(m.glint) + shown[..., None]
    more = more + sparkle[..., None] * np.array(m.sparkle)
    more = more + (weight * skin.mirror)[..., None] * skin.room
    made: np.ndarray = bare + (added(film, more, m.ceiling) - under) @ from_film.T
    return made
