"""A face in its own coordinates: its pose (place, scale and turn) apart from its shape.

Smoothing the two apart lets a filter be strong on a still mouth while the head moves.
"""

import cmath
import math

import cv2
import numpy as np
from makeup_video.pipeline.faces.face import POINTS, Face, LipPatch
from makeup_video.pipeline.faces.net import read_array
from makeup_video.pipeline.faces.topology import EYE, EYE_CONTOUR, LIPS, RIGHT_EYE
from makeup_video.pipeline.frames.affine import Affine
from makeup_video.pipeline.frames.clock import slot

# Points that speech and blinks move least: eye corners, the bridge and wings of the nose, brows,
# and the upper half of the oval. There are many, so that their own noise averages out.
STABLE = np.array([
    33, 133, 362, 263, 168, 6, 197, 195, 5, 4, 129, 358,
    70, 63, 105, 66, 107, 336, 296, 334, 293, 300,
    10, 338, 297, 332, 284, 251, 389, 356, 454, 234, 127, 162, 21, 54, 103, 67, 109,
])  # fmt: skip

# Parts of a face that are compared between moments, and smoothed, independently of each other.
# Of the eyes only the lids are compared: the rings around the lids hardly move in a blink and would
# hide the blink. Of the rest every fifth point is enough.
PARTS = ("lips", "left lids", "right lids", "rest", "pose", "lips' place", "patch")
LIPS_PART, POSE_PART, PLACE_PART, PATCH_PART = 0, 4, 5, 6
_REST = np.setdiff1d(np.arange(POINTS), np.concatenate([LIPS, EYE, RIGHT_EYE]))
_LIDS = len(EYE_CONTOUR)
_KEY_POINTS = [LIPS, EYE[:_LIDS], RIGHT_EYE[:_LIDS], _REST[::5]]
_KEYS = (2 * np.concatenate(_KEY_POINTS)[:, None] + [0, 1]).ravel()  # columns of `values`
_KEY_COUNTS = [len(points) for points in _KEY_POINTS]
_PART_OF_POINT = np.full(POINTS, 3)
for _part, _points in enumerate((LIPS, EYE, RIGHT_EYE)):
    _PART_OF_POINT[_points] = _part
PART_OF_COLUMN = np.concatenate([np.repeat(_PART_OF_POINT, 2), _PART_OF_POINT])  # of `values`
PART_OF_POSE = np.repeat([POSE_PART, PLACE_PART], [4, 2])  # of columns of `pose`
_EVERY = 8  # px between samples of the patch, each way; its logits vary more slowly than that
# A crop that differs from the track's crop by more than this share of its size becomes the track's
# crop.
_MOST_OFF = 0.08
_SAME_PX = 0.01  # a crop that differs by less counts as the track's: no interpolation
# Once in a slot of this length the crop of a frame becomes the track's crop, which then does not
# depend on where a run begins in the video.
_CROP_SECONDS = 0.5


def _to_factor() -> np.ndarray:
    """Weights whose sum over the stable points, about their mean, is a face's scale and turn.

    The weights come from the mean face, not from a track's first face, so that the same frames give
    the same readings, wherever a run begins in the video.
    """
    stable = as_complex(read_array("mean_face.npy").astype(np.float64)[STABLE])
    stable -= stable.mean()
    stable /= math.sqrt((stable * stable.conj()).real.mean())
    weights: np.ndarray = stable.conj() / len(stable)
    return weights


class Readings:
    """Faces of one track at several moments, as numbers that may be averaged.

    values: (N, 478 * 3) float32, x and y of one point after the other in the face's own
    coordinates, then z of all points. The points of the lips are relative to the mean of the lips.
    pose: (N, 6) float64, x, y, log scale and turn of those coordinates, and x and y of the mean of
    the lips. That mean stands apart because the lips are read in every frame, without the errors of
    the points that give the pose. In the face's coordinates the mean would carry those errors with
    the opposite sign.
    patches: (N, H, W) float32, the logits in the track's crop.
    spans: (N,) float64, the widths of the crops that the logits were read from, in IOD.
    keys: (N, K) float64, the numbers by which moments are compared.
    apart: (parts, N, N) float64, mean squared distances between moments: of points; for the pose,
    of the stable points; for the patch, of its samples. The pose and the lips' place are compared
    in units of the later face.

    The unit of length is the rms distance of the mean face's stable points from their mean, when
    the mean face is laid over the face that began the track (0.55 of the distance of the outer eye
    corners). Scale and turn count by how far they move the stable points.
    """

    def __init__(self, space: "FaceSpace", count: int) -> None:
        self.values = np.zeros((count, 3 * POINTS), np.float32)
        self.pose = np.zeros((count, len(PART_OF_POSE)))
        self.patches = np.zeros((count, *space.patch_hw), np.float32)
        self.spans = np.zeros(count)
        self.keys = np.zeros((count, int(space.key_ends[-1])))
        self.apart = np.zeros((len(PARTS), count, count))


class FaceSpace:
    """Converts faces of one track to Readings and back. Points are complex numbers, x + iy."""

    def __init__(self, face: Face) -> None:
        stable = as_complex(face.points_px.take(STABLE, 0))
        self._origin = complex(stable.mean())
        # A face of no extent still gets finite readings.
        self._unit = max(abs(complex(_TO_FACTOR @ (stable - self._origin))), 1e-3)
        self._turn = 0.0
        self._crop: Affine | None = None  # the track's crop: patch px -> lip coordinates
        self._crop_slot = 0
        self._span = face.lips.span  # the width of the track's crop in IOD
        self.patch_hw = face.lips.logits.shape
        sample = -(-self.patch_hw[0] // _EVERY) * -(-self.patch_hw[1] // _EVERY)
        # Where the parts' key columns begin and end, and what the sum of their squares is divided
        # by to give a mean squared distance of points (for the pose: of the stable points).
        self.key_ends = np.cumsum([*(2 * n for n in _KEY_COUNTS), 4, 2, sample])
        self.key_starts = np.concatenate([[0], self.key_ends[:-1]])
        self.key_counts = np.array([*_KEY_COUNTS, 1, 1, sample], np.float64)
        parts = np.repeat(np.arange(len(PARTS)), np.diff(self.key_ends, prepend=0))
        self._shares = np.eye(len(PARTS))[parts] / self.key_counts  # (K, parts)

    def split(self, face: Face, readings: Readings, index: int, seconds: float) -> None:
        """Write a face of this track, at `seconds` of the video, to `index` of the readings."""
        points = as_complex(face.points_px)
        stable = points.take(STABLE)
        middle = complex(stable.sum()) / len(STABLE)
        factor = complex(_TO_FACTOR @ (stable - middle))
        scale = max(abs(factor), 1e-6 * self._unit)
        # Turns add up, so that a face turning past 180 degrees does not jump.
        self._turn += math.remainder(cmath.phase(factor) - self._turn, 2 * math.pi)
        xy, z = _xy_and_z(readings.values[index])
        lips_middle = complex(points.take(LIPS).sum()) / len(LIPS)
        points -= middle
        points[LIPS] += middle - lips_middle
        points *= cmath.rect(1, -self._turn) / scale
        xy[:] = points
        np.multiply(face.points_px[:, 2], 1 / scale, out=z)
        moved, lips = ((at - self._origin) / self._unit for at in (middle, lips_middle))
        log_scale = math.log(scale / self._unit)
        pose = [moved.real, moved.imag, log_scale, self._turn, lips.real, lips.imag]
        readings.pose[index] = pose
        own_slot = slot(seconds, _CROP_SECONDS)
        self._write_patch(face.lips, readings, index, self._lips_to_px(pose), own_slot)
        self._compare(readings, index)

    def join(
        self, values: np.ndarray, pose: np.ndarray, logits: np.ndarray
    ) -> tuple[np.ndarray, LipPatch]:
        """points_px (478, 3) and lip patch of one reading, which may be an average.

        values: (478 * 3,), pose: (6,), logits: (H, W) or (H * W,).
        """
        plain = pose.tolist()
        factor, middle, lips_middle = self._to_px(plain)
        xy, z = _xy_and_z(values)
        xy_px = np.multiply(xy, factor, dtype=np.complex128)
        xy_px += middle
        xy_px[LIPS] += lips_middle - middle
        points = np.empty((POINTS, 3), np.float32)
        points[:, 0], points[:, 1] = xy_px.real, xy_px.imag
        np.multiply(z, abs(factor), out=points[:, 2])
        assert self._crop is not None  # there is no reading before the first `split`
        to_px = self._lips_to_px(plain).after(self._crop)
        return points, LipPatch(logits.reshape(self.patch_hw), to_px.array(), self._span)

    def _compare(self, readings: Readings, index: int) -> None:
        """Write the keys of a moment, and the distances of all moments from it."""
        keys = readings.keys[index]
        keys[: len(_KEYS)] = readings.values[index].take(_KEYS)
        ends = len(_KEYS), len(_KEYS) + len(PART_OF_POSE)
        keys[ends[0] : ends[1]] = readings.pose[index]
        sample = readings.patches[index, ::_EVERY, ::_EVERY].ravel()
        # Cheaper than the logistic function, and as good at distinguishing patches.
        keys[ends[1] :] = sample / (1 + np.abs(sample))
        off = readings.keys - keys
        # shifts count by the size that the face has now, not by that of the track's first face
        shrunk = math.exp(-readings.pose[index, 2])
        off[:, ends[0] : ends[0] + 2] *= shrunk
        off[:, ends[1] - 2 : ends[1]] *= shrunk
        off *= off
        apart = (off @ self._shares).T
        readings.apart[:, index], readings.apart[:, :, index] = apart, apart

    def _to_px(self, pose: list[float]) -> tuple[complex, complex, complex]:
        """From the face's own coordinates to px: the factor, the shift, and the lips' own shift."""
        x, y, log_scale, turn, lips_x, lips_y = pose
        factor = cmath.rect(self._unit * math.exp(log_scale), turn)
        middle, lips = (
            self._origin + self._unit * at for at in (complex(x, y), complex(lips_x, lips_y))
        )
        return factor, middle, lips

    def _lips_to_px(self, pose: list[float]) -> Affine:
        """From lip coordinates, which have the mean of the lips as origin, to px."""
        factor, _, at = self._to_px(pose)
        return Affine(factor.real, -factor.imag, at.real, factor.imag, factor.real, at.imag)

    def _write_patch(
        self, patch: LipPatch, readings: Readings, index: int, lips_to_px: Affine, own_slot: int
    ) -> None:
        """Write the patch as the track's crop would show it.

        The track's crop moves with the lips, and the crop of each frame nearly does, too. So one
        interpolation, on arrival, lets all patches of the track be averaged pixel by pixel.
        """
        to_px = Affine.from_array(patch.to_px)
        readings.spans[index] = patch.span
        # The track's crop is as wide as the widest crop in the readings. A narrower one would cut
        # off the lips of a mouth that was wide open a moment ago.
        span = float(readings.spans.max())
        wider = self._about_the_middle(span / patch.span)
        crop = lips_to_px.inverse().after(to_px.after(wider))
        is_new = self._crop is None or own_slot != self._crop_slot or span > self._span
        if is_new or self._off_px(self._to_track(crop)) > _MOST_OFF * max(self.patch_hw):
            self._take_crop(crop, readings)
            self._span = span
            self._crop_slot = own_slot if is_new else self._crop_slot
        to_patch = wider.after(self._to_track(crop))
        readings.patches[index] = (
            patch.logits if self._off_px(to_patch) < _SAME_PX else _warp(patch.logits, to_patch)
        )

    def _to_track(self, crop: Affine) -> Affine:
        """From px of the track's crop to px of another crop."""
        assert self._crop is not None  # there is no reading before the first crop is taken
        return crop.inverse().after(self._crop)

    def _about_the_middle(self, scale: float) -> Affine:
        """A map of patch px that scales about the patch's middle."""
        h, w = self.patch_hw
        x, y = (1 - scale) * (w - 1) / 2, (1 - scale) * (h - 1) / 2
        return Affine(scale, 0.0, x, 0.0, scale, y)

    def _take_crop(self, crop: Affine, readings: Readings) -> None:
        """Make a frame's crop the track's crop, and move the other patches to it."""
        if self._crop is not None:
            to_old = self._crop.inverse().after(crop)
            if self._off_px(to_old) < _SAME_PX:
                return
            for earlier in readings.patches:
                earlier[:] = _warp(earlier, to_old)
        self._crop = crop

    def _off_px(self, to_patch: Affine) -> float:
        """How far a map moves the corners of the patch, at most."""
        h, w = self.patch_hw
        a, b, x, c, d, y = to_patch
        corners = (0, 0), (w, 0), (0, h), (w, h)
        moved = [(a * u + b * v + x - u, c * u + d * v + y - v) for u, v in corners]
        return max(max(abs(across), abs(down)) for across, down in moved)


def as_complex(xy: np.ndarray) -> np.ndarray:
    """(..., 2 or more) to (...) complex128, x + iy; float32 would lose fractions of pixels."""
    out = np.empty(xy.shape[:-1], np.complex128)
    out.real, out.imag = xy[..., 0], xy[..., 1]
    return out


def _xy_and_z(values: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Views of one row of `Readings.values`: x + iy, (478,) complex64, and z, (478,) float32."""
    return values[: 2 * POINTS].view(np.complex64), values[2 * POINTS :]


def _warp(logits: np.ndarray, to_source: Affine) -> np.ndarray:
    """Logits (H, W) float32 whose pixels are sampled at the places that to_source gives.

    Beyond the edges the border is repeated.
    """
    flags = cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP
    size_wh = logits.shape[1], logits.shape[0]
    return cv2.warpAffine(
        logits, to_source.array(), size_wh, flags=flags, borderMode=cv2.BORDER_REPLICATE
    )


_TO_FACTOR = _to_factor()
