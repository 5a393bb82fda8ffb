"""A face in coordinates of its own: where it is, how large and turned, and what shape it has.

Smoothing these apart is what lets a filter be strong on a still mouth while the head moves.
"""

import cmath
import math

import cv2
import numpy as np
from makeup_video.pipeline.faces.face import POINTS, Face, LipPatch
from makeup_video.pipeline.faces.topology import EYE, EYE_CONTOUR, LIPS, RIGHT_EYE

# Points that speech and blinks move least: eye corners, the bridge and wings of the nose, brows,
# and the upper half of the oval. Many of them, so that their own noise averages out.
STABLE = np.array([
    33, 133, 362, 263, 168, 6, 197, 195, 5, 4, 129, 358,
    70, 63, 105, 66, 107, 336, 296, 334, 293, 300,
    10, 338, 297, 332, 284, 251, 389, 356, 454, 234, 127, 162, 21, 54, 103, 67, 109,
])  # fmt: skip

# What moments of a face are compared by, and how strongly each is smoothed. Of the eyes only the lids
# are compared: the rings around them hardly move in a blink and would hide it. Of the rest every
# fifth point is enough.
REGIONS = ("lips", "left lids", "right lids", "rest", "pose", "patch")
LIPS_REGION, POSE_REGION, PATCH_REGION = 0, 4, 5
_REST = np.setdiff1d(np.arange(POINTS), np.concatenate([LIPS, EYE, RIGHT_EYE]))
_LIDS = len(EYE_CONTOUR)
_KEY_POINTS = [LIPS, EYE[:_LIDS], RIGHT_EYE[:_LIDS], _REST[::5]]
_KEYS = (2 * np.concatenate(_KEY_POINTS)[:, None] + [0, 1]).ravel()  # columns of `values`
_KEY_COUNTS = [len(points) for points in _KEY_POINTS]
_REGION_OF_POINT = np.full(POINTS, 3)


for _region, _points in enumerate((LIPS, EYE, RIGHT_EYE)):
    _REGION_OF_POINT[_points] = _region


REGION_OF_COLUMN = np.concatenate([np.repeat(_REGION_OF_POINT, 2), _REGION_OF_POINT])  # of `values`
_EVERY = 8  # along each side of the patch; its logits are smoother than that
# A crop that strays from the track's window by more than this part of its size begins a new one.
_STRAY = 0.08
_SAME_PX = 0.01  # closer than this, a crop is the window: no interpolation


class Readings:
    """Faces of one track at several moments, as numbers that may be averaged.

    values: (N, 478 * 3) float32, x and y of one point after the other in the face's own frame, then
    z of all. pose: (N, 4) float64, x, y, log scale, turn of that frame. patches: (N, H, W) float32,
    the logits in the track's window. keys: (N, K) float64, what moments are compared by.
    apart: (regions, N, N) float64, how far moments lie apart: mean squared distances of points (of the
    pose: of the stable points; of the patch: of its samples).
    Lengths are in units of the stable points' rms distance from their middle when the track
    began (0.55 of the distance of the outer eye corners); scale and turn count by what they
    do to these points.
    """

    def __init__(self, space: "FaceSpace", count: int) -> None:
        self.values = np.zeros((count, 3 * POINTS), np.float32)
        self.pose = np.zeros((count, 4))
        self.patches = np.zeros((count, *space.patch_hw), np.float32)
        self.keys = np.zeros((count, int(space.key_ends[-1])))
        self.apart = np.zeros((len(REGIONS), count, count))


class FaceSpace:
    """Face <-> Readings, for one track. Points in a plane are complex numbers here."""

    def __init__(self, face: Face) -> None:
        stable = as_complex(face.points_px.take(STABLE, 0))
        self._origin = complex(stable.mean())
        stable -= self._origin
        # A face of no extent still gets finite readings.
        self._unit = max(math.sqrt((stable * stable.conj()).real.mean()), 1e-3)
        stable /= self._unit
        self._fit = stable.conj() / max((stable * stable.conj()).real.sum(), 1e-12)
        self._turn = 0.0
        self._window: Plain | None = None  # patch px -> lip frame
        self.patch_hw = face.lips.logits.shape
        sample = -(-self.patch_hw[0] // _EVERY) * -(-self.patch_hw[1] // _EVERY)
        # Where the regions' key columns begin and end, and by what the sum of their squares is
        # divided to be a mean squared distance of points (the pose: of the stable points).
        self.key_ends = np.cumsum([*(2 * n for n in _KEY_COUNTS), 4, sample])
        self.key_starts = np.concatenate([[0], self.key_ends[:-1]])
        self.key_counts = np.array([*_KEY_COUNTS, 1, sample], np.float64)
        regions = np.repeat(np.arange(len(REGIONS)), np.diff(self.key_ends, prepend=0))
        self._shares = np.eye(len(REGIONS))[regions] / self.key_counts  # (K, regions)

    def split(self, face: Face, into: Readings, at: int) -> None:
        """Write the face to place `at`; the other places hold the same track's."""
        points = as_complex(face.points_px)
        stable = points.take(STABLE)
        middle = complex(stable.sum()) / len(STABLE)
        factor = complex(self._fit @ (stable - middle))
        scale = max(abs(factor), 1e-6 * self._unit)
        # Turns add up, so that a face turning past 180 degrees does not jump.
        self._turn += math.remainder(cmath.phase(factor) - self._turn, 2 * math.pi)
        xy, z = _parts(into.values[at])
        points -= middle
        points *= cmath.rect(1, -self._turn) / scale
        xy[:] = points
        np.multiply(face.points_px[:, 2], 1 / scale, out=z)
        moved = (middle - self._origin) / self._unit
        pose = [moved.real, moved.imag, math.log(scale / self._unit), self._turn]
        into.pose[at] = pose
        self._take_patch(face.lips, into, at, self._lip_frame(xy, pose))
        keys = into.keys[at]
        keys[: len(_KEYS)] = into.values[at].take(_KEYS)
        keys[len(_KEYS) : len(_KEYS) + 4] = pose
        sample = into.patches[at, ::_EVERY, ::_EVERY].ravel()
        # Cheaper than the logistic function, and as good for telling patches apart.
        keys[len(_KEYS) + 4 :] = sample / (1 + np.abs(sample))
        off = into.keys - keys
        off *= off
        apart = (off @ self._shares).T
        into.apart[:, at], into.apart[:, :, at] = apart, apart

    def join(
        self,
        values: np.ndarray,
        pose: np.ndarray,
        logits: np.ndarray,
    ) -> tuple[np.ndarray, LipPatch]:
        """points_px (478, 3) and lip patch of one reading, which may be an average.

        values: (478 * 3,), pose: (4,), logits: (H, W) or so many in a row.
        """
        plain = pose.tolist()
        factor, middle = self._frame(plain)
        xy, z = _parts(values)
        at = np.multiply(xy, factor, dtype=np.complex128)
        at += middle
        points = np.empty((POINTS, 3), np.float32)
        points[:, 0], points[:, 1] = at.real, at.imag
        np.multiply(z, abs(factor), out=points[:, 2])
        assert self._window is not None  # there is no reading before the first `split`
        a, b, x, c, d, y = _compose(self._lip_frame(xy, plain), self._window)
        return points, LipPatch(logits.reshape(self.patch_hw), np.array([[a, b, x], [c, d, y]]))

    def _frame(self, pose: list[float]) -> tuple[complex, complex]:
        """Own frame to px: what to multiply by and what to add."""
        x, y, log_scale, turn = pose
        scale = self._unit * math.exp(log_scale)
        return cmath.rect(scale, turn), self._origin + self._unit * complex(x, y)

    def _lip_frame(self, xy: np.ndarray, pose: list[float]) -> "Plain":
        """To px from a frame that moves with the lips' middle and turns with the face."""
        factor, middle = self._frame(pose)
        middle += factor * complex(xy.take(LIPS).sum()) / len(LIPS)
        return factor.real, -factor.imag, middle.real, factor.imag, factor.real, middle.imag

    def _take_patch(self, patch: LipPatch, into: Readings, at: int, lip_frame: "Plain") -> None:
        """Write the patch as the track's window would have seen it.

        The window goes with the lips, and the crop nearly does too: so one interpolation, on
        arrival, lets all patches of the track be averaged pixel by pixel.
        """
        (a, b, x), (c, d, y) = patch.to_px.tolist()
        crop = a, b, x, c, d, y
        if self._window is None:
            self._window = _compose(_inverse(lip_frame), crop)
        to_own = _compose(_inverse(crop), _compose(lip_frame, self._window))
        stray = self._stray_px(to_own)
        if stray > _STRAY * max(self.patch_hw):
            own = _compose(_inverse(lip_frame), crop)
            to_old = _compose(_inverse(self._window), own)
            for earlier in into.patches:
                earlier[:] = _warp(earlier, to_old)
            self._window, stray = own, 0.0
        into.patches[at] = patch.logits if stray < _SAME_PX else _warp(patch.logits, to_own)

    def _stray_px(self, matrix: "Plain") -> float:
        """How far a map moves the corners of the patch, at most."""
        h, w = self.patch_hw
        a, b, x, c, d, y = matrix
        corners = (0, 0), (w, 0), (0, h), (w, h)
        moved = [(a * u + b * v + x - u, c * u + d * v + y - v) for u, v in corners]
        return max(max(abs(across), abs(down)) for across, down in moved)


# A map (x, y) -> (a x + b y + x0, c x + d y + y0) as plain numbers a, b, x0, c, d, y0: quicker than
# numpy for six.
Plain = tuple[float, float, float, float, float, float]


def _compose(second: Plain, first: Plain) -> Plain:
    """The map that does `first`, then `second`."""
    a, b, x, c, d, y = second
    e, f, u, g, h, v = first
    across = a * e + b * g, a * f + b * h, a * u + b * v + x
    return *across, c * e + d * g, c * f + d * h, c * u + d * v + y


def _inverse(plain: Plain) -> Plain:
    """The map back; of one that cannot be undone, one that leads all to the origin."""
    a, b, x, c, d, y = plain
    area = a * d - b * c
    if area == 0:
        return 0.0, 0.0, 0.0, 0.0, 0.0, 0.0
    a, b, c, d = d / area, -b / area, -c / area, a / area
    return a, b, -a * x - b * y, c, d, -c * x - d * y


def _parts(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Views of one row of `Readings.values`: x + iy, (478,) complex64, and z, (478,) float32."""
    return values[: 2 * POINTS].view(np.complex64), values[2 * POINTS :]


def as_complex(xy: np.ndarray) -> np.ndarray:
    """(..., 2 or more) to (...) complex128, x + iy; float32 would lose pixels' fractions."""
    out = np.empty(xy.shape[:-1], np.complex128)
    out.real, out.imag = xy[..., 0], xy[..., 1]
    return out


def _warp(logits: np.ndarray, to_source: Plain) -> np.ndarray:
    """(H, W) float32 with each pixel taken at to_source; the border goes on for ever."""
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    size_wh = logits.shape[1], logits.shape[0]
    matrix = np.array([to_source[:3], to_source[3:]])
    return cv2.warpAffine(logits, matrix, size_wh, flags=flags, borderMode=cv2.BORDER_REPLICATE)
