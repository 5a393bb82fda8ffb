"""Varies the corner of an eye, for the net that reads eyeliner: draws what real corners have.

Real wings lie lower than those of drawn looks: half of the wings in liners_of_looks.csv rise by at
most 4 degrees above the line through the eye's corners. Other dark things occur there, too: lashes,
above all false ones, smoky eyeshadow, hair and folds.
"""

import math

import cv2
import numpy as np
from makeup_video.pipeline.reference.read_liner import ANGLE_UNIT, CORNER_WH, CORNER_XY, EYE_PX
from makeup_video.training.worn.corner import Corner
from makeup_video.training.worn.vary_photos import heights, moved, photographed

# How often a corner without a wing gets one, and how often the other things are drawn.
_WING_SHARE = 0.35
_SMOKE_SHARE, _LASHES_SHARE, _HAIR_SHARE, _FOLD_SHARE = 0.25, 0.55, 0.25, 0.35
_FINER = 4  # px of a drawing per px of the picture
_SUBPIXEL = 3  # fractional bits of OpenCV's coordinates
_BROWN = np.array([1.0, 0.85, 0.8])  # relative red, green and blue


def varied(corner: Corner, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """A corner as another photo shows it, (72, 112, 3) uint8, and its target, (5,) float32."""
    rgb8, target, lids = corner
    if target[1] == 0 and rng.random() < _WING_SHARE:
        rgb8, length, angle = _with_wing(rgb8, lids, rng)
        # the new line also thickens an old one, so nobody knows the thickness
        target = np.float32([1, 1, length, angle, math.nan])
    if rng.random() < _SMOKE_SHARE:
        rgb8 = _with_smoke(rgb8, rng)
    if rng.random() < _LASHES_SHARE:
        rgb8 = _with_lashes(rgb8, lids, rng)
    for share, add in ((_HAIR_SHARE, _with_hair), (_FOLD_SHARE, _with_fold)):
        if rng.random() < share:
            rgb8 = add(rgb8, rng)
    return photographed(moved(rgb8, np.array(CORNER_XY), rng), rng), target


def _with_wing(
    rgb8: np.ndarray, lids: np.ndarray, rng: np.random.Generator
) -> tuple[np.ndarray, float, float]:
    """Draw a line along the outer part of the upper lid that ends in a wing.

    Returns the picture, and the wing's length and angle as in a target.
    """
    length = 0.08 + 0.55 * rng.beta(1.5, 2)
    degrees = float(np.clip(rng.normal(7, 13), -20, 50))
    angle = math.radians(degrees)
    corner = np.array(CORNER_XY) + rng.normal(0, 1, 2)
    tip = corner + length * EYE_PX * _direction(angle)
    lid = lids[0] + rng.normal(0, 0.6, 2)
    x = np.linspace(rng.uniform(20, 64), corner[0] - rng.uniform(0, 5), 7)
    above = np.column_stack([x, heights(lid, x) - rng.uniform(0.5, 6) * np.linspace(0.3, 1, 7)])
    below = np.column_stack([x, heights(lid, x) + rng.uniform(0, 1)])[::-1]
    bend = rng.uniform(-0.1, 0.18) * length * EYE_PX
    across = np.array([math.sin(angle), math.cos(angle)])
    upper = _curve(above[-1], tip, bend * across)
    start = corner + np.array([rng.uniform(-8, 1), rng.uniform(-0.5, 2.5)])
    lower = _curve(tip, start, (bend + rng.uniform(-0.5, 1.5)) * across)
    drawing = _blank()
    cv2.fillPoly(drawing, [_finer(np.concatenate([above, upper, lower, below]))], 255, cv2.LINE_AA)
    thickness = int(rng.uniform(0.6, 2.2) * _FINER)
    cv2.polylines(drawing, [_finer(upper)], False, 255, thickness, cv2.LINE_AA)
    mask = _softened(drawing, 1.6, rng) * rng.uniform(0.45, 1)
    return _painted(rgb8, mask, _dark(rng)), length, degrees / ANGLE_UNIT


def _with_lashes(rgb8: np.ndarray, lids: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Draw lashes that fan out: few and short, or false. Some clump, some are below the eye."""
    drawing, false = _blank(), rng.random() < 0.5
    count = int(rng.integers(18, 50) if false else rng.integers(5, 22))
    longest = rng.uniform(10, 24) if false else rng.uniform(5, 15)
    first, flattest = rng.uniform(15, 50), rng.uniform(5, 45)
    roots = first + (CORNER_XY[0] + 1 - first) * rng.beta(1.4, 1, count)
    if rng.random() < 0.5:
        clump = rng.uniform(3, 7)
        roots = np.round(roots / clump) * clump + rng.normal(0, 0.5, count)
    for x in roots:
        inwards = float(np.clip((CORNER_XY[0] - x) / EYE_PX, 0, 1))
        steep = flattest + (100 - flattest) * min(1, 2 * inwards) + rng.normal(0, 9)
        root = np.array([x, float(heights(lids[0], x)) + rng.uniform(-2, 1)])
        length = longest * rng.uniform(0.6, 1.1) * (1 - 0.5 * inwards)
        _lash(drawing, root, math.radians(steep), length, rng)
    if rng.random() < 0.4:
        for x in rng.uniform(25, 72, rng.integers(4, 22)):
            angle = math.radians(-80 + 1.6 * (x - 45) + rng.normal(0, 12))
            root = np.array([x, float(heights(lids[1], x))])
            _lash(drawing, root, angle, rng.uniform(3, 9), rng)
    return _painted(rgb8, _softened(drawing, 1.1, rng) * rng.uniform(0.4, 1), _dark(rng))


def _lash(
    drawing: np.ndarray, root: np.ndarray, angle: float, length: float, rng: np.random.Generator
) -> None:
    """Draw one lash, which bends and becomes thinner."""
    bend = length * rng.uniform(0, 0.22) * np.array([math.sin(angle), math.cos(angle)])
    curve = _finer(_curve(root, root + length * _direction(angle), bend))
    thickness = rng.uniform(0.5, 1.5) * _FINER
    for part in range(len(curve) - 1):
        thinner = max(1, int(thickness * (1 - part / len(curve))))
        cv2.polylines(drawing, [curve[part : part + 2]], False, 255, thinner, cv2.LINE_AA)


def _with_smoke(rgb8: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Draw soft, mostly dark eyeshadow beside the corner."""
    smoke = np.zeros(CORNER_WH[::-1], np.float32)
    x, y = CORNER_XY[0] + rng.uniform(-6, 14), CORNER_XY[1] + rng.uniform(-12, 6)
    axes = int(rng.uniform(6, 24)), int(rng.uniform(2, 12))
    cv2.ellipse(smoke, (int(x), int(y)), axes, -rng.uniform(-10, 50), 0, 360, 1.0, -1)
    smoke = cv2.GaussianBlur(smoke, (0, 0), rng.uniform(2, 7))
    smoke *= rng.uniform(0.15, 0.75) / max(float(smoke.max()), 1e-3)
    return _painted(rgb8, smoke, _dark(rng) if rng.random() < 0.7 else rng.uniform(20, 160, 3))


def _with_hair(rgb8: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Draw strands of hair that hang down beside the eye."""
    drawn, colour = rgb8.copy(), (rng.uniform(10, 110) * np.array([1, 0.8, 0.65])).tolist()
    x, bend = rng.uniform(74, CORNER_WH[0]), rng.normal(0, 12)
    down = np.linspace(0, 1, 5)
    for _ in range(rng.integers(1, 12)):
        across = x + rng.normal(0, 6) + bend * down + rng.normal(0, 1, 5)
        line = np.column_stack([across, CORNER_WH[1] * down])
        _line(drawn, line, colour, int(rng.integers(1, 4)))
    return drawn


def _with_fold(rgb8: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Draw a soft dark fold that begins at the corner."""
    fold = np.zeros(CORNER_WH[::-1], np.float32)
    start = np.array([rng.uniform(62, 74), rng.uniform(36, 46)])
    along = rng.uniform(6, 26) * _direction(math.radians(rng.uniform(-50, 40)))
    _line(fold, np.array([start, start + along]), [1.0], int(rng.integers(1, 4)))
    fold = cv2.GaussianBlur(fold, (0, 0), rng.uniform(0.8, 2.2))
    depth = rng.uniform(0.1, 0.4) / max(float(fold.max()), 1e-3)
    darker: np.ndarray = (rgb8 * (1 - depth * fold[..., None])).astype(np.uint8)
    return darker


def _direction(angle: float) -> np.ndarray:
    """The unit vector of a line that rises by an angle (radians); y runs down."""
    return np.array([math.cos(angle), -math.sin(angle)])


def _curve(start: np.ndarray, end: np.ndarray, bend: np.ndarray) -> np.ndarray:
    """(8, 2) px of a quadratic Bezier curve; bend: (2,) px, the offset of its control point."""
    t = np.linspace(0, 1, 8)[:, None]
    middle = (start + end) / 2 + bend
    curve: np.ndarray = (1 - t) ** 2 * start + 2 * t * (1 - t) * middle + t * t * end
    return curve


def _blank() -> np.ndarray:
    wide, high = CORNER_WH
    return np.zeros((high * _FINER, wide * _FINER), np.uint8)


def _finer(points: np.ndarray) -> np.ndarray:
    """Points in px of a picture -> the same points in px of a drawing."""
    return np.rint((points + 0.5) * _FINER - 0.5).astype(np.int32)


def _softened(drawing: np.ndarray, most_px: float, rng: np.random.Generator) -> np.ndarray:
    """The share of each pixel that a drawing covers, often blurred; most_px: the largest sigma."""
    mask = cv2.resize(drawing, CORNER_WH, interpolation=cv2.INTER_AREA).astype(np.float32) / 255
    if rng.random() < 0.6:
        mask = cv2.GaussianBlur(mask, (0, 0), rng.uniform(0.3, most_px))
    return mask


def _painted(rgb8: np.ndarray, mask: np.ndarray, rgb: np.ndarray) -> np.ndarray:
    mixed: np.ndarray = rgb8 + mask[..., None] * (rgb.astype(np.float32) - rgb8)
    return mixed.astype(np.uint8)


def _dark(rng: np.random.Generator) -> np.ndarray:
    """The colour of a liner or of lashes: black to brown."""
    return rng.uniform(0, 60) * _BROWN + rng.uniform(0, 12, 3)


def _line(picture: np.ndarray, line: np.ndarray, colour: list[float], thickness: int) -> None:
    fixed = np.rint(line * 2**_SUBPIXEL).astype(np.int32)
    cv2.polylines(picture, [fixed], False, colour, thickness, cv2.LINE_AA, _SUBPIXEL)
