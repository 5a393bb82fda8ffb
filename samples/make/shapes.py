"""The shift of each face point in each expression, and smooth fields through these shifts.

Positions and fields are canvas pixels; the amounts are set in picture pixels.
"""

from __future__ import annotations

import numpy as np
from head import Field, interpolate
from numpy.typing import NDArray
from picture import SCALE, smoothstep, to_canvas

# The four rings of the lips from the outer border to the inner one, each from the corner
# on the left of the picture along the upper lip to the other corner, then back below.
RINGS = [
    [61, 185, 40, 39, 37, 0, 267, 269, 270, 409, 291, 375, 321, 405, 314, 17, 84, 181, 91, 146],
    [76, 184, 74, 73, 72, 11, 302, 303, 304, 408, 306, 307, 320, 404, 315, 16, 85, 180, 90, 77],
    [62, 183, 42, 41, 38, 12, 268, 271, 272, 407, 292, 325, 319, 403, 316, 15, 86, 179, 89, 96],
    [78, 191, 80, 81, 82, 13, 312, 311, 310, 415, 308, 324, 318, 402, 317, 14, 87, 178, 88, 95],
]
UPPER = [r[1:10] for r in RINGS]  # left to right
LOWER = [r[:10:-1] for r in RINGS]  # left to right
CORNERS = [i for r in RINGS for i in (r[0], r[10])]
BROW_POINTS = [70, 63, 105, 66, 107, 46, 53, 52, 65, 55, 336, 296, 334, 293, 300, 285, 295, 282,
               283, 276]  # fmt: skip
HINGE_Y, HINGE_DEPTH = 116.0, 42.0  # the jaw joint, picture pixels (depth away from camera)
JAW_ANGLE = 0.27  # radians at jaw = 1
SHAPES = ("close", "jaw", "narrow", "brows")


def lip_y(points: NDArray) -> float:
    return float(points[CORNERS, 1].mean())


def lower_points(points: NDArray) -> NDArray[np.bool_]:
    """Select those of the 478 points that belong to the sheet below the mouth line."""
    lower = points[:, 1] > lip_y(points) + 2
    lower[[i for r in UPPER for i in r] + CORNERS] = False
    lower[[i for r in LOWER for i in r]] = True
    return lower


def shape(name: str, points: NDArray, lower: NDArray[np.bool_]) -> NDArray[np.float32]:
    """Return the shifts of the 478 points for a shape at full strength, (478, 2) canvas pixels."""
    shift = np.zeros((len(points), 2), np.float32)
    x = (points[:, 0] - points[CORNERS, 0].mean()) / (np.ptp(points[CORNERS, 0]) / 2)
    if name == "brows":
        shift[BROW_POINTS, 1] = -2.0 * SCALE
    elif name == "narrow":
        lips = [i for r in RINGS for i in r]
        shift[lips, 0] = -2.8 * SCALE * x[lips]
    elif name == "close":
        _close(shift, points, x)
    else:
        _open(shift, points, lower)
    return shift


def _close(shift: NDArray, points: NDArray, x: NDArray) -> None:
    """Close the lips over the teeth: the inner borders meet, the outer borders follow partly."""
    gap = points[LOWER[3], 1] - points[UPPER[3], 1]
    follow_up, follow_low = (0.30, 0.60, 0.82, 1.0), (0.42, 0.62, 0.82, 1.0)
    for k in range(4):
        shift[UPPER[k], 1] = 0.45 * gap * follow_up[k]
        shift[LOWER[k], 1] = -(0.55 * gap + 0.5 * SCALE) * follow_low[k]
        for ring in (UPPER[k], LOWER[k]):
            shift[ring, 0] = -1.6 * SCALE * x[ring]
    shift[CORNERS, 0] = -1.6 * SCALE * x[CORNERS]
    shift[CORNERS, 1] = 1.0 * SCALE
    for i in (18, 83, 313, 182, 406):
        shift[i, 1] = -1.2 * SCALE


def _open(shift: NDArray, points: NDArray, lower: NDArray[np.bool_]) -> None:
    """Turn the jaw about its joint in front of the ears; the corners follow a little."""
    arm = HINGE_DEPTH * SCALE - points[:, 2]
    drop = JAW_ANGLE * np.maximum(arm, 0)
    corner = points[CORNERS].mean(0)
    reach = smoothstep(-0.25, 1.0, (points[:, 1] - corner[1]) / (16 * SCALE))
    shift[:, 1] = np.where(lower, drop * reach, 0)
    for ring in LOWER:
        # The lower lip hangs between its corners: full drop in the middle, 0.3 of it beside them.
        u = np.linspace(-1, 1, len(ring))
        shift[ring, 1] = drop[ring] * (0.30 + 0.70 * (1 - np.abs(u) ** 2.4))
        shift[ring, 0] = -1.6 * SCALE * u * np.abs(u)
    for ring in UPPER:
        u = np.linspace(-1, 1, len(ring))
        shift[ring, 1] = (-0.9 * (1 - u * u) + 1.4 * u * u) * SCALE
        shift[ring, 0] = -1.7 * SCALE * u * np.abs(u)
    shift[CORNERS, 1] = 2.4 * SCALE
    side = np.sign(points[CORNERS, 0] - corner[0])
    shift[CORNERS, 0] = -2.2 * SCALE * side


def field(points: NDArray, members: list[int], shift: NDArray) -> Field:
    """Return a smooth field through the shifts of members that falls to 0 around the face."""
    around = to_canvas(np.array([(x, y) for x in (150, 170, 225, 280, 300) for y in (20, 50)]
                                + [(165, 90), (165, 140), (290, 90), (285, 140), (150, 190),
                                   (160, 235), (225, 240), (290, 235), (300, 190)]))  # fmt: skip
    at = np.vstack([points[members, :2], around])
    return interpolate(at, np.vstack([shift[members], np.zeros((len(around), 2))]), 2e-4)
