"""One face of one picture: from a guess to its points, scores and lips; and which is which."""

import math
from dataclasses import dataclass

import numpy as np
from makeup_video.pipeline.crop import Affine, Picture, compose
from makeup_video.pipeline.face import MIN_FACE_PX, Face, LipPatch
from makeup_video.pipeline.face_nets import FaceNets, iod_of, middle_of

DETECTOR_THRESHOLD = 0.35
FACE_THRESHOLD = 0.5  # of the mesh net's score
_FACE_WIDTH = 1.75  # of the mean face's oval, in IOD
_FIRST_PASSES = 3  # of the mesh net, from a detector's guess
_MOVED_FAR = 0.12  # IOD, or log scale, or radians, between two frames: look again
_SAME_FACE = 0.6  # IOD between the middles of two that are one
_PART_OF_FACE = 1.15, 0.7  # IOD of the larger, and ratio of sizes: a mouth taken for a face
# Mean distance, in IOD, between the points of a crop and of the same crop mirrored. Of faces 99 %
# stay below 0.027, masked ones too; of the detector's mistakes hardly any.
_AGREE, _AGREE_STILL = 0.035, 0.05


@dataclass(slots=True)
class Sighting:
    """What the nets tell of one face, in upright px of a Picture."""

    points: np.ndarray  # (478, 3)
    scores: np.ndarray  # (2,) probabilities: a face, a visible mouth
    frame: Affine  # the face frame of the points
    lips: LipPatch


def detect(nets: FaceNets, picture: Picture, sides_px: tuple[int, ...]) -> list[Affine]:
    """The detector's guesses at all these sizes (at most the picture's own), each face once."""
    frames: list[Affine] = []
    longer_px = math.ceil(max(picture.width_px, picture.height_px))
    for side_px in sorted({min(side_px, longer_px) for side_px in sides_px}):
        for frame in nets.detect(picture, side_px, DETECTOR_THRESHOLD):
            if not any(is_same(frame, other) for other in frames):
                frames.append(frame)
    return frames


def sight(
    nets: FaceNets, picture: Picture, guess: Affine, carefully: bool = False
) -> Sighting | None:
    """The face at a detector's guess; None when there is none after all.

    carefully: the mean of several looks, for a picture that stands alone.
    """
    frame = guess
    for _ in range(_FIRST_PASSES):
        points, scores = nets.read_mesh(picture, frame)
        frame = nets.face_frame(points)
        if not _is_plausible(points, picture):
            return None
    mirrored, scores_mirrored = nets.read_mesh(picture, frame, mirrored=True)
    scores = (scores + scores_mirrored) / 2
    if scores[0] < FACE_THRESHOLD or _disagreement(points, mirrored, frame) > _AGREE:
        return None
    if carefully:
        looks = [nets.read_mesh(picture, f, m)[0] for f in _around(frame) for m in (False, True)]
        points = np.mean([points, mirrored, *looks], axis=0)
    nets.refine(picture, points, both_ways=carefully)
    lips = nets.refine(picture, points, both_ways=carefully)
    return Sighting(points, scores, nets.face_frame(points), lips)


def sight_again(
    nets: FaceNets, picture: Picture, frame: Affine, doubtfully: bool = False
) -> Sighting | None:
    """The same face a frame later, given where it was; None when it is gone.

    doubtfully: look at the mirrored crop too, to see whether this still is a face.
    """
    points, scores = nets.read_mesh(picture, frame)
    moved = nets.face_frame(points)
    if _distance(frame, moved) > _MOVED_FAR:
        points, scores = nets.read_mesh(picture, moved)
    if scores[0] < FACE_THRESHOLD or not _is_plausible(points, picture):
        return None
    if doubtfully:
        mirrored, _ = nets.read_mesh(picture, moved, mirrored=True)
        if _disagreement(points, mirrored, moved) > _AGREE_STILL:
            return None
    lips = nets.refine(picture, points)
    return Sighting(points, scores, nets.face_frame(points), lips)


def to_face(sighting: Sighting, picture: Picture, track_id: int) -> Face:
    """Upright px -> a Face in px of the stored picture."""
    to_stored, points = picture.to_stored, sighting.points
    stored = np.empty(points.shape, np.float32)
    stored[:, :2] = points[:, :2] @ to_stored[:, :2].T + to_stored[:, 2]
    stored[:, 2] = points[:, 2] * np.sqrt(abs(np.linalg.det(to_stored[:, :2])))
    lips = LipPatch(sighting.lips.logits, compose(to_stored, sighting.lips.to_px))
    return Face(stored, float(sighting.scores[0]), float(sighting.scores[1]), track_id, lips)


def is_tiny(frame: Affine) -> bool:
    """Narrower than MIN_FACE_PX."""
    return iod_of(frame) * _FACE_WIDTH < MIN_FACE_PX


def is_same(a: Affine, b: Affine) -> bool:
    """Two frames on one face, or one of them on a part of the other's face."""
    small, large = sorted((iod_of(a), iod_of(b)))
    apart = np.hypot(*(middle_of(a) - middle_of(b))) / large
    reach, ratio = _PART_OF_FACE
    return bool(apart < (reach if small < ratio * large else _SAME_FACE))


def is_near(before: Affine, now: Affine) -> bool:
    """A face that was lost may be this one: not far off, and of a like size."""
    apart = np.hypot(*(middle_of(before) - middle_of(now)))
    return bool(apart < 1.5 * iod_of(now) and 0.6 < iod_of(now) / iod_of(before) < 1.7)


def _around(frame: Affine) -> list[Affine]:
    """A little smaller and larger frames about the same middle."""
    middle = middle_of(frame)
    frames = []
    for scale in (0.94, 1.06):
        linear = frame[:, :2] * scale
        shift = middle - linear @ np.linalg.solve(frame[:, :2], middle - frame[:, 2])
        frames.append(np.column_stack([linear, shift]))
    return frames


def _distance(a: Affine, b: Affine) -> float:
    """The largest of shift (IOD), log scale and turn (radians) between two frames."""
    ratio = complex(*b[:, 0]) / complex(*a[:, 0])
    shift = np.hypot(*(middle_of(a) - middle_of(b))) / iod_of(a)
    return float(max(shift, abs(np.log(max(abs(ratio), 1e-6))), abs(np.angle(ratio))))


def _disagreement(points: np.ndarray, mirrored: np.ndarray, frame: Affine) -> float:
    """Mean distance of two readings of one face, in IOD."""
    return float(np.linalg.norm((points - mirrored)[:, :2], axis=1).mean()) / iod_of(frame)


def _is_plausible(points: np.ndarray, picture: Picture) -> bool:
    """Finite, of a size, and at least partly in the picture."""
    if not np.isfinite(points).all():
        return False
    low, high = points[:, :2].min(0), points[:, :2].max(0)
    size = np.array([picture.width_px, picture.height_px])
    inside = np.minimum(high, size) - np.maximum(low, 0)
    return bool((inside > 0.15 * (high - low)).all() and (high - low).max() > MIN_FACE_PX / 3)
