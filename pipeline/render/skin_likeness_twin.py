"""How much each place of a face looks like the face's own skin.

Hair, a mask, the frame of glasses, a phone or a sleeve in front of the cheek differ from the skin
in lightness or in colour. Skin varies, too: it is lit from one side, it shines, and it flushes. So
for each of three numbers (log luminance, log red to green, log blue to green) a plane is fitted to
this face's skin. A place's distance from the planes is measured by how much this face's skin itself
varies. The numpy twin of face_skin.h, a part of kernels/face.cl.
"""

import math
from dataclasses import dataclass

import numpy as np
from makeup_video.kernels.face import (
    BESIDE,
    BRIGHTER,
    COLOUR_RIDGE,
    DARK,
    EXPECTED,
    FAR,
    FEWEST,
    LEAST_LIGHT,
    LEVEL_RIDGE,
    LIGHT_RIDGE,
    LIGHTER,
    MIDDLE,
    MOST_LIGHTER,
    MOST_RED,
    OTHER,
    PALER,
    PARTS,
    REDDER,
    SHINE_PALES,
    SKIN,
    SPREAD,
)

_SPREAD = np.array(SPREAD)
_EXPECTED_SPREAD = np.diag(_SPREAD**2)
_RIDGE = np.array([
    np.diag([LEVEL_RIDGE, *slopes]) for slopes in (LIGHT_RIDGE, COLOUR_RIDGE, COLOUR_RIDGE)
])  # fmt: skip
_TO_NUMBERS = np.array([[1.0, 0, 0, 0], [0, 1, -1, 0], [0, 0, -1, 1]])


@dataclass(frozen=True, slots=True, eq=False)
class _Skin:
    """planes: (3, 3), for each number the plane's height and its slopes along `across` and `down`.
    to_deviations: (3, 3), from distances off the planes to independent standard deviations."""

    planes: np.ndarray
    to_deviations: np.ndarray


def skin_likeness(
    rgb: np.ndarray, luminance: np.ndarray, across: np.ndarray, down: np.ndarray, seen: np.ndarray
) -> np.ndarray:
    """(N,) float32: 1 where the face looks like its skin, 0 where it certainly does not.

    rgb: (3, N) float32 linear light in sRGB's primaries.  luminance: (N,) float32, its luminance.
    across, down: (N,) float32, places on the face in IOD.
    seen: indices of the places that are samples of skin. Too few of them make all places 1.
    """
    if len(seen) < FEWEST:
        return np.ones(len(luminance), np.float32)
    given = np.empty((7, len(luminance)), np.float32)  # four logs, then 1, x and y for planes
    given[0], given[1:4], given[4], given[5] = luminance, rgb, 1, across
    np.subtract(down, np.float32(MIDDLE), out=given[6])
    usual = float(np.partition(luminance[seen], len(seen) // 2)[len(seen) // 2])
    logs = given[:4]
    logs += np.float32(max(DARK * usual, LEAST_LIGHT))
    np.log(np.maximum(logs, np.float32(1e-9), out=logs), out=logs)
    samples = given.take(seen, 1).astype(np.float64)
    skin = _fit(_TO_NUMBERS @ samples[:4], samples[4:], math.log(max(usual, LEAST_LIGHT)))
    if skin is None:
        return np.ones(len(luminance), np.float32)
    to_off = np.concatenate([_TO_NUMBERS, -skin.planes], axis=1, dtype=np.float32)
    off = to_off @ given
    shine = np.maximum(off[0], 0)
    off[0] -= (1 - BRIGHTER) * shine
    shine *= SHINE_PALES
    off[1] += shine
    off[2] -= shine
    paler = np.maximum(off[2] - off[1], 0)
    paler *= 1 / PALER
    paler *= paler
    off = skin.to_deviations @ off
    off *= off
    like: np.ndarray = off[0]
    like += paler
    like += off[1]
    like += off[2]
    np.sqrt(like, out=like)
    like *= -1 / (OTHER - SKIN)
    like += OTHER / (OTHER - SKIN)
    np.minimum(np.maximum(like, 0, out=like), 1, out=like)
    like *= like * (3 - 2 * like)
    return like


def _fit(numbers: np.ndarray, slopes: np.ndarray, usual: float) -> _Skin | None:
    """Fit the planes to the samples; None where too little of every part of the face is seen.

    numbers: (3, S).  slopes: (3, S): 1, x and y.  usual: the log of the face's luminance.
    """
    start = _start(numbers, slopes, usual)
    if start is None:
        return None
    far = (numbers - start[:, None]) / _SPREAD[:, None]
    far *= far
    weight = 1 + far.sum(0) * (1 / FAR)
    weight *= weight
    weighted = slopes / weight
    normal = weighted @ slopes.T + _RIDGE
    planes = np.linalg.solve(normal, (numbers @ weighted.T)[..., None])[..., 0]
    off = numbers - planes @ slopes
    few = EXPECTED * numbers.shape[1]
    spread = (off / weight) @ off.T + few * _EXPECTED_SPREAD
    spread /= float((1 / weight).sum()) + few
    to_deviations = np.linalg.inv(np.linalg.cholesky(spread))
    return _Skin(planes, to_deviations.astype(np.float32))


def _start(numbers: np.ndarray, slopes: np.ndarray, usual: float) -> np.ndarray | None:
    """The medians (3,) of the part of the face most like skin; None where no part is seen."""
    near = np.abs(slopes[1]) < BESIDE
    best, found = -math.inf, None
    for low, high in PARTS:
        here = np.flatnonzero(near & (slopes[2] > low - MIDDLE) & (slopes[2] < high - MIDDLE))
        part = np.sort(numbers.take(here, 1), axis=1)
        if part.shape[1] < FEWEST:
            continue
        medians = part[:, part.shape[1] // 2]
        light, red, _ = medians.tolist()
        light -= usual
        likely = LIGHTER * min(light, MOST_LIGHTER) + REDDER * min(red, MOST_RED)
        if likely > best:
            best, found = likely, medians
    return found
