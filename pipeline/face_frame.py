"""A face in coordinates of its own: where it is, how large and turned, and what shape it has.

Smoothing these apart is what lets a filter be strong on a still mouth while the head moves.
"""

import cmath
import math

import cv2
import numpy as np
from makeup_video.pipeline.crop import compose
from makeup_video.pipeline.face import POINTS, Face, LipPatch
from makeup_video.pipeline.topology import EYE, EYE_CONTOUR, LIPS, RIGHT_EYE

# Points that speech and blinks move least: eye corners, the bridge and wings of the nose, brows,
# and the upper half of the oval. Many of them, so that their own noise averages out.
STABLE = np.array([
    33, 133, 362, 263, 168, 6, 197, 195, 5, 4, 129, 358,
    70, 63, 105, 66, 107, 336, 296, 334, 293, 300,
    10, 338, 297, 332, 284, 251, 389, 356, 454, 234, 127, 162, 21, 54, 103, 67, 109,
])  # fmt: skip

_REST = np.setdiff1d(np.arange(POINTS), np.concatenate([LIPS, EYE, RIGHT_EYE]))
_ORDER = np.concatenate([LIPS, EYE, RIGHT_EYE, _REST])  # `values` holds the points like this
_BACK = np.argsort(_ORDER)
_ENDS = np.cumsum([len(LIPS), len(EYE), len(RIGHT_EYE), len(_REST)])
# Columns of `values` (x, y, z of one point after the other) that belong to one region.
SPANS = [(3 * int(a), 3 * int(b)) for a, b in zip([0, *_ENDS[:-1]], _ENDS, strict=True)]

# What moments of a face are compared by. Of the eyes only the lids: the rings around them hardly
# move in a blink and would hide it. Of the rest every fifth point is enough.
REGIONS = ("lips", "left lids", "right lids", "rest", "pose", "patch")
LIPS_REGION, POSE_REGION, PATCH_REGION = 0, 4, 5
_LIDS = len(EYE_CONTOUR)
_KEY_POINTS = [
    np.arange(_ENDS[0]),
    np.arange(_ENDS[0], _ENDS[0] + _LIDS),
    np.arange(_ENDS[1], _ENDS[1] + _LIDS),
    np.arange(_ENDS[2], _ENDS[3], 5),
]
_KEYS = (3 * np.concatenate(_KEY_POINTS)[:, None] + [0, 1]).ravel()  # columns of `values`
_KEY_COUNTS = [len(points) for points in _KEY_POINTS]
_MEAN = np.full(len(LIPS), 1 / len(LIPS), np.float32)
_EVERY = 8  # along each side of the patch; its logits are smoother than that
# A crop that strays from the track's window by more than this part of its size begins a new one.
_STRAY = 0.08
_SAME_PX = 0.01  # closer than this, a crop is the window: no interpolation


def fit_similarity(from_xy: np.ndarray, to_xy: np.ndarray) -> np.ndarray:
    """The turn, scale and shift that bring from_xy onto to_xy with the least squared error.

    Both (..., K, 2). Returns (..., 2, 3) float64, for `M[:, :2] @ xy + M[:, 2]`. No reflection;
    when all of from_xy is one point, a shift. The closed form of Umeyama (1991), which in the
    plane is a division of complex numbers.
    """
    a, b = _complex(from_xy), _complex(to_xy)
    a_mean, b_mean = a.mean(-1), b.mean(-1)
    a = (a - a_mean[..., None]).conj()
    spread = (a * a.conj()).real.sum(-1)
    one_point = spread <= 0
    factor = (a * (b - b_mean[..., None])).sum(-1) / np.where(one_point, 1.0, spread)
    factor = np.where(one_point, 1.0, factor)
    shift = b_mean - factor * a_mean
    rows = [factor.real, -factor.imag, shift.real, factor.imag, factor.real, shift.imag]
    return np.stack(rows, -1).reshape(*factor.shape, 2, 3)


class Readings:
    """Faces of one track at several moments, as numbers that may be averaged.

    values: (N, 478 * 3) float32, x, y, z of the points in the face's own frame, by region.
    pose: (N, 4) float64, x, y, log scale, turn of that frame. patches: (N, H, W) float32, the
    logits in the track's window. keys: (N, K) float32, what moments are compared by.
    Lengths are in units of the stable points' rms distance from their middle when the track
    began (0.55 of the distance of the outer eye corners); scale and turn count by what they
    do to these points.
    """

    def __init__(self, space: "FaceSpace", count: int) -> None:
        self.values = np.zeros((count, 3 * POINTS), np.float32)
        self.pose = np.zeros((count, 4))
        self.patches = np.zeros((count, *space.patch_hw), np.float32)
        self.keys = np.zeros((count, int(space.key_ends[-1])), np.float32)


class FaceSpace:
    """Face <-> Readings, for one track. Points in a plane are complex numbers here."""

    def __init__(self, face: Face) -> None:
        stable = _complex(face.points_px.take(STABLE, 0))
        self._origin = complex(stable.mean())
        stable -= self._origin
        # A face of no extent still gets finite readings.
        self._unit = max(math.sqrt((stable * stable.conj()).real.mean()), 1e-3)
        stable /= self._unit
        self._fit = stable.conj() / max((stable * stable.conj()).real.sum(), 1e-12)
        self._turn = 0.0
        self._window: np.ndarray | None = None  # (2, 3): patch px -> lip frame
        self.patch_hw = face.lips.logits.shape
        sample = -(-self.patch_hw[0] // _EVERY) * -(-self.patch_hw[1] // _EVERY)
        # Where the regions' key columns begin and end, and by what the sum of their squares is
        # divided to be a mean squared distance of points (the pose: of the stable points).
        self.key_ends = np.cumsum([*(2 * n for n in _KEY_COUNTS), 4, sample])
        self.key_starts = np.concatenate([[0], self.key_ends[:-1]])
        self.key_counts = np.array([*_KEY_COUNTS, 1, sample], np.float64)

    def split(self, face: Face, into: Readings, at: int) -> None:
        """Write the face to place `at`; the other places hold the same track's."""
        points = face.points_px.take(_ORDER, 0)
        stable = _complex(face.points_px.take(STABLE, 0))
        middle = complex(stable.mean())
        factor = complex((self._fit * (stable - middle)).sum())
        scale = max(abs(factor), 1e-6 * self._unit)
        # Turns add up, so that a face turning past 180 degrees does not jump.
        self._turn += math.remainder(cmath.phase(factor) - self._turn, 2 * math.pi)
        values = into.values[at].reshape(POINTS, 3)
        own = (_complex(points) - middle) * (cmath.rect(1, -self._turn) / scale)
        values[:, 0], values[:, 1] = own.real, own.imag
        values[:, 2] = points[:, 2] * (1 / scale)
        moved = (middle - self._origin) / self._unit
        into.pose[at] = moved.real, moved.imag, math.log(scale / self._unit), self._turn
        self._take_patch(face.lips, into, at)
        keys = into.keys[at]
        keys[: len(_KEYS)] = into.values[at].take(_KEYS)
        keys[len(_KEYS) : len(_KEYS) + 4] = into.pose[at]
        sample = into.patches[at, ::_EVERY, ::_EVERY].ravel()
        # Cheaper than the logistic function, and as good for telling patches apart.
        keys[len(_KEYS) + 4 :] = sample / (1 + np.abs(sample))

    def join(
        self,
        values: np.ndarray,
        pose: np.ndarray,
        logits: np.ndarray,
    ) -> tuple[np.ndarray, LipPatch]:
        """points_px (478, 3) and lip patch of one reading, which may be an average.

        values: (478 * 3,), pose: (4,), logits: (H, W) or so many in a row.
        """
        factor, middle = self._frame(pose)
        own = values.reshape(POINTS, 3).take(_BACK, 0)
        at = _complex(own) * factor + middle
        points = np.empty((POINTS, 3), np.float32)
        points[:, 0], points[:, 1] = at.real, at.imag
        points[:, 2] = own[:, 2] * abs(factor)
        assert self._window is not None  # there is no reading before the first `split`
        to_px = compose(self._lip_frame(values, pose), self._window)
        return points, LipPatch(logits.reshape(self.patch_hw), to_px)

    def _frame(self, pose: np.ndarray) -> tuple[complex, complex]:
        """Own frame to px: what to multiply by and what to add."""
        x, y, log_scale, turn = pose.tolist()
        scale = self._unit * math.exp(log_scale)
        return cmath.rect(scale, turn), self._origin + self._unit * complex(x, y)

    def _lip_frame(self, values: np.ndarray, pose: np.ndarray) -> np.ndarray:
        """(2, 3) to px from a frame that moves with the lips' middle and turns with the face."""
        factor, middle = self._frame(pose)
        x, y, _ = (_MEAN @ values[: 3 * len(LIPS)].reshape(-1, 3)).tolist()
        middle += factor * complex(x, y)
        c, s = factor.real, factor.imag
        return np.array([[c, -s, middle.real], [s, c, middle.imag]])

    def _take_patch(self, patch: LipPatch, into: Readings, at: int) -> None:
        """Write the patch as the track's window would have seen it.

        The window goes with the lips, and the crop nearly does too: so one interpolation, on
        arrival, lets all patches of the track be averaged pixel by pixel.
        """
        lip_frame = self._lip_frame(into.values[at], into.pose[at])
        if self._window is None:
            self._window = compose(cv2.invertAffineTransform(lip_frame), patch.to_px)
        to_own = compose(cv2.invertAffineTransform(patch.to_px), compose(lip_frame, self._window))
        stray = self._stray_px(to_own)
        if stray > _STRAY * max(self.patch_hw):
            own = compose(cv2.invertAffineTransform(lip_frame), patch.to_px)
            to_old = compose(cv2.invertAffineTransform(self._window), own)
            for earlier in into.patches:
                earlier[:] = _warp(earlier, to_old)
            self._window, stray = own, 0.0
        into.patches[at] = patch.logits if stray < _SAME_PX else _warp(patch.logits, to_own)

    def _stray_px(self, matrix: np.ndarray) -> float:
        """How far a (2, 3) matrix moves the corners of the patch, at most."""
        h, w = self.patch_hw
        a, b, x, c, d, y = (float(v) for v in matrix.flat)
        corners = (0, 0), (w, 0), (0, h), (w, h)
        moved = [(a * u + b * v + x - u, c * u + d * v + y - v) for u, v in corners]
        return max(max(abs(across), abs(down)) for across, down in moved)


def _complex(xy: np.ndarray) -> np.ndarray:
    """(..., 2 or more) to (...) complex128, x + iy; float32 would lose pixels' fractions."""
    out = np.empty(xy.shape[:-1], np.complex128)
    out.real, out.imag = xy[..., 0], xy[..., 1]
    return out


def _warp(logits: np.ndarray, to_source: np.ndarray) -> np.ndarray:
    """(H, W) float32 with each pixel taken at to_source (2, 3); the border goes on for ever."""
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    size_wh = logits.shape[1], logits.shape[0]
    return cv2.warpAffine(logits, to_source, size_wh, flags=flags, borderMode=cv2.BORDER_REPLICATE)
