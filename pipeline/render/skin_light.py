"""The light on a face, read from its skin and from the frame around it.

Observed skin is albedo times light, so in logarithms it is a sum. Skin varies along one line, from
light and pale to dark and saturated. Light varies in other directions: in exposure, and between red
and blue. Both are modelled as Gaussians, and the frame's mean is weaker evidence. The most probable
light is then linear in the observations: dark skin is read as dark skin, a blue cast as light.

Some seventy pixels of a face and two thousand of a frame are read, whatever the size of the frame.
"""

import math
from dataclasses import dataclass
from functools import lru_cache

import cv2
import numpy as np
from makeup_video.kernels.colour import (
    SRGB,
    Coding,
    from_srgb_primaries,
    matrices,
    to_linear,
    to_srgb_primaries,
    to_xyz,
)
from makeup_video.kernels.material import ENVIRONMENT_PX
from makeup_video.pipeline.faces.face import Face
from makeup_video.pipeline.frames.frame import Frame

STRENGTHS = 0.15, 2.0
_TINT = 0.8  # largest log of a channel of the light's colour: 2.2 times
_BLACK = 1e-3  # linear light; darker is noise
_DIM = 0.01  # skin darker than this has a doubtful colour
_CLIPPED = 0.9  # of SDR: where a channel of typical skin exceeds this, parts of it are clipped
# Veils take on some of what makes skin darker and warmer than TYPICAL_SKIN: shares of the
# difference in hue and in light, in logarithms. Otherwise the pink of a blush on pale skin would be
# lilac on tanned skin, and ashen on dark skin. _DEEPEST is the largest difference that counts.
_VEIL_HUE, _VEIL_LIGHT, _DEEPEST = 0.8, 0.3, 2.5
_GREY = 0.06  # skin whose channels differ by less than this share of the brightest has no colour

# Log linear light in sRGB's primaries. `python -m makeup_video.training.skin_light` fits both: the
# covariance on 625 foundation shades (pudding, MIT), the mean on portraits in soft light. Every
# lightness counts the same in each.
SKIN_MEAN = np.array([-0.646, -1.382, -1.897])
SKIN_COVARIANCE = np.array([
    [0.2731, 0.3841, 0.4720],
    [0.3841, 0.5707, 0.7271],
    [0.4720, 0.7271, 0.9933],
])  # fmt: skip
# The median of plain skin in photos of makeup, in neutral light: linear R, G, B.
TYPICAL_SKIN = 0.753, 0.48, 0.374
_LOG_TYPICAL = np.log(TYPICAL_SKIN)
_USUAL_SKIN = float(np.log(to_xyz(1)[1] @ np.exp(SKIN_MEAN)))
_EXPECTED_TINT = SKIN_MEAN - SKIN_MEAN.mean()
# Mean log red - 2 log green + log blue: a warm or cold light does not change it.
_RED_BEYOND = float(SKIN_MEAN @ [1, -2, 1])
# Standard deviations of a light's log exposure, of its log red to blue, log green to magenta.
_LIGHT_SPREAD = 0.35, 0.4, 0.1
_ROOM_SPREAD = 0.6, 0.45, 0.2  # of a frame's mean in white light
_ROOM_MEAN = np.log([0.27, 0.22, 0.18])  # what cameras expose for, a little warm

# Where skin is bare and a face has few creases: triangles over cheeks, forehead, nose and chin,
# wound so that (b - a) x (c - a) points out of the face.
TRIANGLES = np.array([
    9, 108, 69, 9, 151, 108, 9, 337, 151, 9, 299, 337, 196, 419, 9, 196, 47, 236, 236, 3, 196,
    196, 3, 195, 197, 196, 195, 3, 5, 195, 248, 195, 5, 197, 195, 419, 419, 195, 248, 456, 419,
    248, 419, 456, 277, 117, 123, 50, 101, 117, 50, 101, 36, 142, 101, 142, 100, 142, 47, 100,
    134, 47, 142, 134, 5, 236, 236, 5, 3, 363, 5, 134, 456, 248, 5, 363, 456, 5, 363, 371, 277,
    371, 329, 277, 330, 329, 371, 330, 371, 266, 330, 280, 346, 346, 280, 352, 50, 123, 147, 187,
    205, 50, 50, 205, 101, 101, 205, 36, 330, 266, 425, 280, 330, 425, 411, 280, 425, 280, 376,
    352, 187, 50, 147, 207, 205, 187, 427, 411, 425, 411, 376, 280, 147, 192, 187, 192, 207, 187,
    416, 411, 427, 376, 411, 416, 192, 214, 207, 207, 214, 202, 427, 422, 434, 416, 427, 434, 202,
    214, 210, 422, 430, 434, 211, 202, 210, 431, 430, 422, 211, 194, 202, 32, 194, 211, 201, 194,
    32, 421, 262, 418, 262, 431, 418, 431, 422, 418, 32, 208, 201, 208, 199, 201, 201, 199, 200,
    421, 200, 199, 428, 421, 199, 262, 421, 428,
]).reshape(-1, 3)  # fmt: skip
SKIN_POINTS, _CORNERS = np.unique(TRIANGLES, return_inverse=True)
_CORNERS = np.ascontiguousarray(_CORNERS.reshape(-1, 3).T)  # (3, T): a, b, c in SKIN_POINTS
# Skin right under the eyes, which glasses cover: five points for each eye.
_UNDER_EYES = np.array([228, 229, 230, 231, 232, 448, 449, 450, 451, 452])
_READ_POINTS = np.concatenate([SKIN_POINTS, _UNDER_EYES])
# The samples that count as skin, as shares of all samples in order of luminance: below are beard,
# hair, shadow and frames of glasses, above are highlights.
_BAND = 0.35, 0.85
_ENOUGH = 12  # samples of skin; with fewer, the frame alone is used
_CHIN, _BROW = 152, 10  # the line from the first to the second points up

# The shading of a triangle with the normal n is a + b . n, in units of the face's median: ambient
# light a comes from everywhere, direct light b is expected from the front and above. A spread is a
# standard deviation; a triangle's is large, because neighbours err together.
_AMBIENT, _AMBIENT_SPREAD = 0.4, 0.3
_DIRECT, _DIRECT_SPREAD = 0.8, 0.35
_TRIANGLE_SPREAD = 0.6
_SHADING = 0.25, 1.9  # bounds of a triangle's shading: beyond them are hair and highlights
_STEEPEST = -0.35  # largest z of a light's direction: a light at the side, never behind the face
_FEWEST_TRIANGLES = 8

_GRID_WH = (64, 32)  # columns and rows of samples of a frame


@dataclass(frozen=True, slots=True, eq=False)
class Optics:
    """How a coding encodes colour, as this stage needs it."""

    transfer: int
    to_rgb: np.ndarray  # (3, 3) float32, codes as rows @ to_rgb + offset
    offset: np.ndarray  # (3,) float32
    luminance: np.ndarray  # (3,) float32, of linear light in the frame's primaries
    to_srgb: np.ndarray  # (3, 3) between linear lights
    from_srgb: np.ndarray

    def decode(self, codes: np.ndarray) -> np.ndarray:
        """Codes (N, 3) float32 -> linear light (N, 3): `decode` of kernels.colour, in float32."""
        return to_linear(codes @ self.to_rgb + self.offset, self.transfer)


@dataclass(frozen=True, slots=True, eq=False)
class Skin:
    """What is seen of a face's skin.

    log: (3,) log of typical linear light in sRGB's primaries.
    trust: how far its colour counts, 0 to 1.
    luminance: (N,) linear, at SKIN_POINTS. usual: its median.
    inside: (N,) bool, which of these points lie in the picture.
    under_eyes: linear luminance of the skin right under the brighter eye; None where some of that
    skin is outside the picture.
    """

    log: np.ndarray
    trust: float
    luminance: np.ndarray
    usual: float
    inside: np.ndarray
    under_eyes: float | None


@lru_cache
def optics_of(coding: Coding) -> Optics:
    to_rgb, _ = matrices(coding)
    return Optics(
        coding.transfer,
        np.ascontiguousarray(to_rgb[:, :3].T, np.float32),
        to_rgb[:, 3].astype(np.float32),
        to_xyz(coding.primaries)[1].astype(np.float32),
        to_srgb_primaries(coding.primaries),
        from_srgb_primaries(coding.primaries),
    )


def read_room(frame: Frame, optics: Optics) -> np.ndarray:
    """The frame in linear light, (16, 16, 3) float32, from a sparse grid."""
    wide, high = _GRID_WH
    light = optics.decode(_codes(frame, *_grid(frame.width_px, frame.height_px)))
    light = light.astype(np.float32, copy=False).reshape(high, wide, 3)
    size = ENVIRONMENT_PX, ENVIRONMENT_PX
    return np.maximum(cv2.resize(light, size, interpolation=cv2.INTER_AREA), 0)


def log_mean(environment: np.ndarray, optics: Optics) -> np.ndarray:
    mean = optics.to_srgb @ cv2.mean(environment)[:3]
    return np.asarray(np.log(np.maximum(mean, _BLACK)))


@lru_cache
def _grid(width_px: int, height_px: int) -> tuple[np.ndarray, np.ndarray]:
    """x and y of the samples, row by row, each in the middle of its cell."""
    wide, high = _GRID_WH
    x = ((np.arange(wide) + 0.5) / wide * width_px).astype(np.intp)
    y = ((np.arange(high) + 0.5) / high * height_px).astype(np.intp)
    return np.tile(x, high), np.repeat(y, wide)


def _codes(frame: Frame, x: np.ndarray, y: np.ndarray) -> np.ndarray:
    """Y'CbCr codes (N, 3) float32 of pixels; those of grey pictures have no colour."""
    planes = frame.planes
    codes = np.empty((len(x), 3), np.float32)
    codes[:, 0] = planes[0][y, x]
    if len(planes) < 3 and planes[-1].ndim == 2:
        codes[:, 1:] = 2 ** (frame.bit_depth - 1)
        return codes
    across, down = frame.chroma
    x, y = x // across, y // down
    if planes[1].ndim == 3:  # NV12 keeps both in one plane
        codes[:, 1:] = planes[1][y, x]
    else:
        codes[:, 1], codes[:, 2] = planes[1][y, x], planes[2][y, x]
    return codes


def read_face(face: Face, frame: Frame, optics: Optics, room_log: np.ndarray) -> np.ndarray:
    """The light on a face from this frame alone: 13 numbers, see `_Track` in scene_light.py.

    room_log: `log_mean` of the frame.
    """
    off = room_log - _ROOM_MEAN
    expected = _expected_direction(face, frame)
    skin = read_skin(face.points_px, frame, optics)
    if skin is None:
        light = _sane(_FROM_ROOM @ off, 1.0, optics)
        veil = np.append(0.0, light[1:])
        return np.concatenate([light, expected, [light[0] + _USUAL_SKIN, 0.0], veil])
    gain = _FROM_SKIN @ (skin.log - SKIN_MEAN) + _FROM_ROOM_TOO @ off
    light = _sane(gain, skin.trust, optics)
    direction = _direction(face.points_px, skin, expected)
    usual = math.log(max(skin.usual, _BLACK))
    under_eyes = 0.0
    if skin.under_eyes is not None:
        under_eyes = math.log(max(skin.under_eyes, _BLACK)) - usual
    veil = _veil(skin, gain, optics)
    return np.concatenate([light, direction, [usual, under_eyes], veil])


def read_skin(points_px: np.ndarray, frame: Frame, optics: Optics) -> Skin | None:
    """Read the skin of a face with these points; None when too little of it is in the picture."""
    xy = points_px[_READ_POINTS, :2]
    size = np.array((frame.width_px, frame.height_px))
    there = np.all((xy > -0.5) & (xy < size - 0.5), axis=1)  # NaN is outside
    inside = there[: len(SKIN_POINTS)]
    seen = np.count_nonzero(inside)
    if seen < _ENOUGH:
        return None
    if not there.all():
        xy = np.where(there[:, None], xy, xy[: len(inside)][inside][0])
    at = np.rint(xy).astype(np.intp)
    light = optics.decode(_codes(frame, at[:, 0], at[:, 1]))
    luminances = light @ optics.luminance
    luminance = luminances[: len(inside)]
    order = np.argsort(luminance)
    if seen < len(inside):
        order = order[inside[order]]
    band = order[int(_BAND[0] * seen) : int(_BAND[1] * seen)]
    log, trust = _typical(light[band], optics)
    under_eyes = _under_eyes(luminances[len(inside) :], there[len(inside) :])
    return Skin(log, trust, luminance, float(luminance[order[seen // 2]]), inside, under_eyes)


def _under_eyes(luminance: np.ndarray, inside: np.ndarray) -> float | None:
    """The luminance right under the brighter eye; None where a point is outside the picture.

    It is that of the second brightest point: the frame of clear glasses may cover some points.
    luminance, inside: (10,), linear, at _UNDER_EYES.
    """
    if not inside.all():
        return None
    left, right = luminance.reshape(2, -1).tolist()
    brighter: float = max(sorted(left)[-2], sorted(right)[-2])
    return brighter


def _typical(light: np.ndarray, optics: Optics) -> tuple[np.ndarray, float]:
    """Linear light (N, 3) -> its mean log (3,) in sRGB's primaries, and how far its colour counts.

    light: in the frame's primaries.
    """
    log = np.log(np.maximum(light @ optics.to_srgb.T, _BLACK)).mean(0)
    red, green, blue = log.tolist()
    trust = min(1.0, math.exp(green) / _DIM)
    if optics.transfer == SRGB:
        # A clipped red may have been any amount higher: estimate it from green and blue.
        beyond = min(2 * green - blue + _RED_BEYOND, 1.0) - red
        log[0] += max(beyond, 0.0) * min(max(2 * (math.exp(red) - _CLIPPED) / (1 - _CLIPPED), 0), 1)
        trust = min(trust, max(0.0, (1 - math.exp(green)) / (1 - _CLIPPED)))
    if float(np.ptp(light, axis=1).max()) < _GREY * float(light.max()):  # black and white
        log += _EXPECTED_TINT - (log - log.mean())
        trust = 0.0
    return log, trust


def _sane(gain: np.ndarray, trust: float, optics: Optics) -> np.ndarray:
    """Bound a light: log (3,) in sRGB's primaries -> log strength and log colour (4,) in the
    frame's primaries."""
    strength = math.log(np.exp(gain) @ _SRGB_LUMINANCE)
    colour = _log_colour(trust * (gain - strength), optics)
    return np.append(min(max(strength, math.log(STRENGTHS[0])), math.log(STRENGTHS[1])), colour)


def _veil(skin: Skin, gain: np.ndarray, optics: Optics) -> np.ndarray:
    """Log share and log colour (4,) of the light for veils: see SceneLight.

    gain: the log of the light on the face, (3,) in sRGB's primaries.
    """
    deeper = np.clip(skin.log - gain - _LOG_TYPICAL, -_DEEPEST, 0)
    darker = math.log(np.exp(deeper) @ _SRGB_LUMINANCE)
    strength = math.log(np.exp(gain) @ _SRGB_LUMINANCE)
    tint = np.clip(skin.trust * (gain - strength), -_TINT, _TINT)  # bounded as in `_sane`
    tint += skin.trust * _VEIL_HUE * (deeper - darker)
    return np.append(_VEIL_LIGHT * darker, _log_colour(tint, optics))


def _log_colour(tint: np.ndarray, optics: Optics) -> np.ndarray:
    """Log colour (3,) in sRGB's primaries -> log colour of luminance 1 in the frame's primaries."""
    colour = np.maximum(optics.from_srgb @ np.exp(np.clip(tint, -_TINT, _TINT)), 0.1)
    log: np.ndarray = np.log(colour / (colour @ optics.luminance))
    return log


def _expected_direction(face: Face, frame: Frame) -> np.ndarray:
    """The direction from the front and above, where up is half-way between the viewer's up and the
    head's."""
    up = np.array(_UP[frame.rotation_degrees])
    own = face.points_px[_BROW, :2] - face.points_px[_CHIN, :2]
    length = math.hypot(*own.tolist())
    if 0 < length < math.inf:
        up = (up + own / length) / 2
    direction = np.array([0.5 * up[0], 0.5 * up[1], -(0.75**0.5)])
    return direction / math.sqrt(direction @ direction)


def _direction(points_px: np.ndarray, skin: Skin, expected: np.ndarray) -> np.ndarray:
    """Unit vector to the light, from how the skin's luminance varies with the mesh's normals."""
    corners = points_px.T[_XYZXY].take(TRIANGLES.T, 1)  # (5, 3, T)
    if not math.isfinite(corners.sum()):
        return expected
    b, c = corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0]
    normals = b[1:4] * c[2:5] - b[2:5] * c[1:4]
    lengths = np.sqrt((normals * normals).sum(0))
    seen = normals[2] < 0
    if not skin.inside.all():
        seen &= skin.inside[_CORNERS].all(0)
    if np.count_nonzero(seen) < _FEWEST_TRIANGLES:
        return expected
    design = np.empty((4, len(TRIANGLES)), np.float32)
    np.multiply(normals, seen / np.maximum(lengths, 1e-9), out=design[:3])
    design[3] = seen
    shading = skin.luminance[_CORNERS].mean(0) / max(skin.usual, _BLACK)
    shading = np.minimum(np.maximum(shading, _SHADING[0]), _SHADING[1]) * seen
    prior = np.append(_DIRECT * expected, _AMBIENT)
    off = np.linalg.solve(design @ design.T + _RIDGE, design @ (shading - prior @ design))
    x, y, z = (prior + off)[:3].tolist()
    length = math.hypot(x, y, z)
    if not 1e-3 < length < math.inf:
        return expected
    if z > _STEEPEST * length:
        z, beside = _STEEPEST, math.hypot(x, y) / math.sqrt(1 - _STEEPEST**2)
        if beside < 1e-6:
            return expected
        return np.array([x / beside, y / beside, z])
    return np.array([x, y, z]) / length


def _spread(deviations: tuple[float, float, float]) -> np.ndarray:
    """Covariance of logs of red, green, blue from the deviations of exposure and of two tints."""
    axes = np.array([[1, 1, 1], [0.5, 0, -0.5], [-1 / 3, 2 / 3, -1 / 3]]).T * deviations
    return np.asarray(axes @ axes.T)


def _gains() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Matrices from deviations of observed log light to the log of the light on the face: for skin
    and for the room where both are observed, and for the room where it is observed alone."""
    light, skin, room = (
        np.linalg.inv(c) for c in (_spread(_LIGHT_SPREAD), SKIN_COVARIANCE, _spread(_ROOM_SPREAD))
    )
    both = np.linalg.inv(light + skin + room)
    return both @ skin, both @ room, np.linalg.inv(light + room) @ room


_FROM_SKIN, _FROM_ROOM_TOO, _FROM_ROOM = _gains()
_SRGB_LUMINANCE = to_xyz(1)[1]
_RIDGE = np.diag(
    [(_TRIANGLE_SPREAD / _DIRECT_SPREAD) ** 2] * 3 + [(_TRIANGLE_SPREAD / _AMBIENT_SPREAD) ** 2]
)
_XYZXY = np.array([0, 1, 2, 0, 1])  # rows to take cross products by slices
# Up for the viewer, as a direction in the stored picture, by the turn that makes it upright.
_UP = {0: (0.0, -1.0), 90: (1.0, 0.0), 180: (0.0, 1.0), 270: (-1.0, 0.0)}
