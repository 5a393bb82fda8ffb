"""The depth of the head: a smooth surface through the face points, turned in perspective.

All lengths are canvas pixels; z here points TOWARDS the camera. Fields are sampled every
STEP canvas pixels: arrays (H / STEP, W / STEP[, 2]) float32.
"""

from __future__ import annotations

import json
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray
from picture import HEAD, HEIGHT, NECK, SCALE, WIDTH, blur, polygon, smoothstep, to_canvas
from scipy import ndimage
from scipy.interpolate import RBFInterpolator

Field = NDArray[np.float32]

STEP = 2  # canvas pixels between two samples of a field
PIVOT = np.array([224.0, 150.0, 70.0])  # the top of the neck; picture pixels
CAMERA_DISTANCE = 2100.0  # canvas pixels from the camera to the plane of the eyes
SKULL = (226.0, 88.0, 80.0, 76.0, 115.0)  # ellipsoid: centre x, y; semi-axes x, y, z
DEEPEST = -31.0  # picture pixels; no face point may lie further back
JAW_LINE = [172, 136, 150, 149, 176, 148, 152, 377, 400, 378, 379, 365, 397]


@dataclass(frozen=True)
class Pose:
    """Rotation of the head in degrees and its translation in canvas pixels."""

    yaw: float = 0.0
    pitch: float = 0.0
    roll: float = 0.0
    x: float = 0.0
    y: float = 0.0


def load_points() -> NDArray[np.float32]:
    """Load the checked face points in canvas pixels, (478, 3) float32, z away from the camera."""
    path = Path(__file__).parents[1] / "astronaut_points.json"
    return to_canvas(np.array(json.loads(path.read_text())["points"]))


def grid() -> tuple[Field, Field]:
    """Return canvas x and y of every field sample."""
    ys, xs = np.mgrid[0:HEIGHT:STEP, 0:WIDTH:STEP].astype(np.float32)
    return xs, ys


def sample(field: Field, x: Field, y: Field) -> Field:
    """Interpolate a field at canvas positions bilinearly; its border is continued."""
    x32, y32 = np.float32(x) / STEP, np.float32(y) / STEP
    out = cv2.remap(field, x32, y32, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
    return out.reshape(x32.shape + field.shape[2:])


def interpolate(at: NDArray, values: NDArray, smoothing: float = 0.0) -> Field:
    """Return a thin-plate spline through values at canvas points (n, 2), as a field."""
    coarse = 4  # field samples; the spline is smooth, and slow to evaluate
    xs, ys = grid()
    xs, ys = xs[::coarse, ::coarse], ys[::coarse, ::coarse]
    spline = RBFInterpolator(at / 100, values, smoothing=smoothing)
    out = spline(np.stack([xs, ys], -1).reshape(-1, 2) / 100).reshape(*xs.shape, -1)
    rows, columns = np.mgrid[0 : HEIGHT // STEP, 0 : WIDTH // STEP].astype(np.float32) / coarse
    planes = [
        cv2.remap(p.astype(np.float32), columns, rows, cv2.INTER_CUBIC,
                  borderMode=cv2.BORDER_REPLICATE)
        for p in np.moveaxis(out, -1, 0)
    ]  # fmt: skip
    return np.stack(planes, -1)


def invert(forward: Field, xs: Field, ys: Field, rounds: int = 24) -> tuple[Field, Field]:
    """Return the positions that p -> p + forward(p) moves to (xs, ys).

    The damped fixed-point iteration converges where forward changes by less than 2 pixels per pixel
    and nothing folds over.
    """
    x, y = xs, ys
    for _ in range(rounds):
        shift = sample(forward, x, y)
        x = x + 0.65 * (xs - shift[..., 0] - x)
        y = y + 0.65 * (ys - shift[..., 1] - y)
    return x, y


class Head:
    """The depth and rigidity of the head layer, and its motion for a pose."""

    def __init__(self, points: NDArray[np.float32]) -> None:
        self.depth = _depth(points)  # towards the camera
        self.rigid = _rigidity(points)  # 1 moves with the skull, 0 stays with the body

    def turn(self, pose: Pose, depth: Field | None = None) -> Field:
        """Return the forward field of a pose: shifts of the samples, (h, w, 2), canvas pixels."""
        xs, ys = grid()
        z = self.depth if depth is None else depth
        moved = project(np.stack([xs, ys, z], -1), pose)
        return ((moved[..., :2] - np.stack([xs, ys], -1)) * self.rigid[..., None]).astype(
            np.float32
        )

    def move_points(self, points: NDArray, pose: Pose) -> NDArray[np.float32]:
        """Move face points (n, 3), z away from the camera, as the rendered surface moves."""
        x, y = np.float32(points[:, 0]), np.float32(points[:, 1])
        z, rigid = sample(self.depth, x, y), sample(self.rigid, x, y)
        shift = project(np.stack([x, y, z], -1), pose)[:, :2] - points[:, :2]
        turned = project(points * [1, 1, -1], pose)[:, 2]
        return np.column_stack([points[:, :2] + shift * rigid[:, None], -turned]).astype(np.float32)


def project(points: NDArray, pose: Pose) -> NDArray:
    """Turn canvas points (..., 3) about the pivot and project x and y; z stays a depth."""
    yaw, pitch, roll = np.radians([pose.yaw, pose.pitch, pose.roll])
    cy, sy, cp, sp, cr, sr = (f(a) for a in (yaw, pitch, roll) for f in (np.cos, np.sin))
    turn_yaw = np.array([[cy, 0, sy], [0, 1, 0], [-sy, 0, cy]])
    turn_pitch = np.array([[1, 0, 0], [0, cp, sp], [0, -sp, cp]])
    turn_roll = np.array([[cr, -sr, 0], [sr, cr, 0], [0, 0, 1]])
    pivot = to_canvas(PIVOT) * [1, 1, -1]
    out = (points - pivot) @ (turn_roll @ turn_yaw @ turn_pitch).T + pivot + [pose.x, pose.y, 0]
    centre = np.array([WIDTH / 2, HEIGHT / 2])
    nearer = CAMERA_DISTANCE / (CAMERA_DISTANCE - out[..., 2:])
    # The photograph is a perspective view itself: divide out its perspective at rest.
    rest = CAMERA_DISTANCE / (CAMERA_DISTANCE - points[..., 2:])
    out[..., :2] = (out[..., :2] - centre) * nearer / rest + centre
    return out


def _depth(points: NDArray[np.float32]) -> Field:
    """Return the depth of the head layer: the face points, and an ellipsoid for the hair."""
    xs, ys = grid()
    cx, cy, ax, ay, az = SKULL
    px, py = xs / SCALE + _origin()[0], ys / SCALE + _origin()[1]
    round_ = 1 - ((px - cx) / ax) ** 2 - ((py - cy) / ay) ** 2
    skull = (np.sqrt(np.maximum(round_, 0.25)) * az - az + 6) * SCALE
    # The rim of the face is so deep that it would fold over itself in a turn.
    toward = np.maximum(-points[:468, 2:], DEEPEST * SCALE)
    face = interpolate(points[:468, :2], toward, 3e-3)[..., 0]
    hull = cv2.convexHull(np.ascontiguousarray(points[:468, :2])).astype(np.int32)
    mask = cv2.fillConvexPoly(np.zeros((HEIGHT, WIDTH), np.uint8), hull, 1)[::STEP, ::STEP]
    # The spline is accurate only near its points: freeze it beyond the hull, then blend.
    near = ndimage.distance_transform_edt(mask == 0, return_indices=True, return_distances=False)
    face = face[tuple(near)]
    share = blur(cv2.erode(mask.astype(np.float32), np.ones((13, 13))), 8)
    throat = smoothstep(*to_canvas(np.array([[0, 150.0], [0, 176.0]]))[:, 1], ys)
    outer = skull * (1 - throat) + (-38 * SCALE) * throat
    return _less_steep(blur((face * share + outer * (1 - share)).astype(np.float32), 3))


def _less_steep(depth: Field) -> Field:
    """Smooth the depth where it is so steep that it would fold in a turn."""
    for _ in range(8):
        gx, gy = cv2.Sobel(depth, -1, 1, 0, scale=1 / 8), cv2.Sobel(depth, -1, 0, 1, scale=1 / 8)
        steep = blur(smoothstep(1.4, 2.1, np.hypot(gx, gy) / STEP), 4)
        depth = depth + steep * (blur(depth, 5) - depth)
    return depth.astype(np.float32)


def _origin() -> tuple[float, float]:
    """Return the picture coordinates of canvas (0, 0)."""
    zero = to_canvas(np.zeros((1, 2)))[0]
    return -float(zero[0]) / SCALE, -float(zero[1]) / SCALE


def _rigidity(points: NDArray[np.float32]) -> Field:
    """Return 1 on head and hair, falling to 0 down the neck, so that nothing tears."""
    inside = polygon(HEAD)[::STEP, ::STEP] > 0.5
    jaw = points[JAW_LINE, :2]
    xs, ys = grid()
    line = np.interp(xs, jaw[:, 0], jaw[:, 1]).astype(np.float32)
    below = np.maximum(ys - line, 0) / SCALE
    neck = polygon(NECK, 4)[::STEP, ::STEP]
    rigid = 1 - smoothstep(2, 40, below) * np.maximum(neck, smoothstep(24, 40, below))
    return blur(np.where(inside, rigid, rigid).astype(np.float32), 4)
