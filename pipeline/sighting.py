"""One face of one picture: from a guess to its points, scores and lips; and which is which."""

import math
from dataclasses import dataclass, field
from functools import partial

import numpy as np
from makeup_video.pipeline.crop import Affine, Picture, compose
from makeup_video.pipeline.face import MIN_FACE_PX, Face, LipPatch
from makeup_video.pipeline.face_nets import FaceNets, View, distance, iod_of, middle_of

DETECTOR_THRESHOLD = 0.35
MAX_GUESSES = 64
# Of the mesh net's score. 99.5 % of faces score over 0.9, masked ones too; and a face that is
# followed already may look doubtful for a moment.
_A_FACE, _STILL_A_FACE = 0.85, 0.4
_FACE_WIDTH = 1.75  # of the mean face's oval, in IOD
# Passes of the mesh net from a detector's guess, which may be off by half a face: the score says
# nothing before the second. Below these the next is not worth while.
_HOPELESS, _HOPELESS_CAREFULLY = (0, 0.02, 0.5), (0, 0, 0.02, 0.5)
_MOVED_FAR = 0.12  # IOD, or log scale, or radians, between two frames: look again
_AT_REST = 0.015  # the same: not more than noise
_FAST = 0.08  # the same: the mesh net had better look at every frame
MESH_SECONDS = 0.09  # between two looks of the mesh net
# IOD between the mesh net's lips or eyes and those of the closer look: these look elsewhere.
_STRAYED = 0.2
_LIPS_JUMP = 0.05  # IOD in one frame, against the eyes
_SHRUNK = 0.3  # log scale in MESH_SECONDS: no face does that
_CORRECTION = 0.3  # of the face frame towards the mesh net's: at once would jolt the crops
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
    view: View  # where the nets looked
    middles: np.ndarray  # (5, 2), see FaceNets.middles
    meshed_seconds: float = -np.inf  # when the mesh net last looked at it
    # Its motion since the frame before, px -> px; and in IOD, log scale or radians, the most.
    step: Affine = field(default_factory=partial(np.eye, 2, 3))
    moved: float = 0.0
    painted: int = field(init=False)  # px of the lip patch

    def __post_init__(self) -> None:
        self.painted = int(np.count_nonzero(self.lips.logits > 0))


def detect(
    nets: FaceNets, picture: Picture, sides_px: tuple[int, ...], tilt_degrees: float = 0
) -> list[Affine]:
    """The detector's guesses at all these sizes (at most the picture's own), surest first.

    Several may be of one face. They bound the time of a frame: no more than MAX_GUESSES.
    """
    longer_px = math.ceil(max(picture.width_px, picture.height_px))
    found: list[tuple[float, Affine]] = []
    for side_px in dict.fromkeys(min(side_px, longer_px) for side_px in sides_px):
        found += nets.detect(picture, side_px, DETECTOR_THRESHOLD, tilt_degrees)
    found.sort(key=lambda guess: -guess[0])
    return [frame for _, frame in found[:MAX_GUESSES]]


def sight(
    nets: FaceNets, picture: Picture, guess: Affine, carefully: bool = False
) -> Sighting | None:
    """The face at a detector's guess; None when there is none after all.

    carefully: the mean of several looks, for a picture that stands alone.
    """
    frame = guess
    for hopeless in _HOPELESS_CAREFULLY if carefully else _HOPELESS:
        points, scores = nets.read_mesh(picture, frame)
        frame = nets.face_frame(points)
        if scores[0] < hopeless or not _is_plausible(points, picture):
            return None
    mirrored, scores_mirrored = nets.read_mesh(picture, frame, mirrored=True)
    scores = (scores + scores_mirrored) / 2
    if scores[0] < _A_FACE or _disagreement(points, mirrored, frame) > _AGREE:
        return None
    if carefully:
        looks = [nets.read_mesh(picture, f, m)[0] for f in _around(frame) for m in (False, True)]
        points = np.mean([points, mirrored, *looks], axis=0)
    for _ in range(2):
        view = nets.view(points)
        lips = nets.refine(picture, points, view, both_ways=carefully)
    frame, middles = nets.face_frame(points), nets.middles(points)
    return Sighting(points, scores, frame, lips, view, middles)


def sight_again(
    nets: FaceNets, picture: Picture, before: Sighting, seconds: float, doubtfully: bool = False
) -> Sighting | None:
    """The same face a frame later, at `seconds` of the film; None when it is gone.

    Lips and eyes are read in every frame, where the face's motion leads to. The mesh net sees to
    the rest, and to whether this still is a face, now and then; in between the rest is carried
    along. doubtfully: look at the mirrored crop too.
    """
    age = seconds - before.meshed_seconds
    is_due = doubtfully or before.moved > _FAST or not 0 <= age < MESH_SECONDS
    found = _follow(nets, picture, before, seconds if is_due else None, doubtfully)
    if found is not None and not is_due and _is_odd(before, found):
        found = _follow(nets, picture, before, seconds, doubtfully)
    return found


def _follow(
    nets: FaceNets,
    picture: Picture,
    before: Sighting,
    mesh_seconds: float | None,
    doubtfully: bool,
) -> Sighting | None:
    """mesh_seconds: the time, when the mesh net is to look; None: the rest is carried along."""
    points, view = _expected(nets, before)
    scores, meshed_seconds = before.scores, before.meshed_seconds
    if mesh_seconds is not None:
        seen = _mesh_again(nets, picture, view, doubtfully)
        if seen is None:
            return None
        mesh, scores, is_where_expected = seen
        meshed_seconds = mesh_seconds
        strayed_px = _STRAYED * iod_of(view.frame) if is_where_expected else 0
        if nets.take_rest(points, mesh, strayed_px):
            view = nets.view(points)
    lips = nets.refine(picture, points, view)
    middles = nets.middles(points)
    step = _step_of(before.middles, middles)
    frame = compose(step, before.frame)
    if mesh_seconds is not None:
        frame = frame + _CORRECTION * (nets.face_frame(points) - frame)
    else:
        points[nets.far_points] = _moved(before.points[nets.far_points], step)
    moved = distance(before.frame, frame)
    return Sighting(points, scores, frame, lips, view, middles, meshed_seconds, step, moved)


def _step_of(before: np.ndarray, now: np.ndarray) -> Affine:
    """The similarity that takes both rims of `middles` before to those now.

    What fit_similarity says of two points, in plain numbers: this runs for every face and frame.
    """
    left, right, new_left, new_right = (complex(*xy) for xy in (*before[3:], *now[3:]))
    across = right - left
    turn = (new_right - new_left) / across if across else 1 + 0j
    shift = new_left - turn * left
    return np.array([
        [turn.real, -turn.imag, shift.real],
        [turn.imag, turn.real, shift.imag],
    ])  # fmt: skip


def _is_odd(before: Sighting, found: Sighting) -> bool:
    """Lips that jump about the face, or vanish: something is in front of them, it may be."""
    off = found.middles[0] - found.step @ [*before.middles[0], 1]
    jumped = math.hypot(*off.tolist()) > _LIPS_JUMP * iod_of(found.frame)
    return jumped or found.painted < before.painted / 2


def _expected(nets: FaceNets, before: Sighting) -> tuple[np.ndarray, View]:
    """Where a face's points will be in the next frame, and where to look for them."""
    points, frame = before.points.copy(), before.frame
    if before.moved > _AT_REST:  # what moves moves on
        points, frame = _moved(points, before.step), compose(before.step, frame)
    view = nets.view(points, frame)
    # the crops of a still face stay where they are: after their own noise they would wander
    return points, before.view if before.view.strayed(view) < _AT_REST else view


def _mesh_again(
    nets: FaceNets, picture: Picture, view: View, doubtfully: bool
) -> tuple[np.ndarray, np.ndarray, bool] | None:
    """What the mesh net sees: points, scores, and whether the face is where it was expected."""
    mesh, scores = nets.read_mesh(picture, view.frame)
    frame = nets.face_frame(mesh)
    is_where_expected = distance(view.frame, frame) < _MOVED_FAR
    if not is_where_expected:
        mesh, scores = nets.read_mesh(picture, frame)
    frame = nets.face_frame(mesh)
    resized = abs(math.log(max(iod_of(frame), 1e-6) / iod_of(view.frame)))
    if scores[0] < _STILL_A_FACE or resized > _SHRUNK or not _is_plausible(mesh, picture):
        return None
    if doubtfully:
        mirrored, _ = nets.read_mesh(picture, frame, mirrored=True)
        if _disagreement(mesh, mirrored, frame) > _AGREE_STILL:
            return None
    return mesh, scores, is_where_expected


def _moved(points: np.ndarray, step: Affine) -> np.ndarray:
    """(K, 3) moved in the picture; depth stays."""
    (a, b, right), (c, d, below) = step.tolist()
    moved = points.copy()
    moved[:, 0] = a * points[:, 0] + b * points[:, 1] + right
    moved[:, 1] = c * points[:, 0] + d * points[:, 1] + below
    return moved


def to_face(sighting: Sighting, picture: Picture, track_id: int) -> Face:
    """Upright px -> a Face in px of the stored picture."""
    to_stored, points = picture.to_stored, sighting.points
    (a, b, right), (c, d, below) = to_stored.tolist()
    x, y, z = points.T
    stored = np.empty(points.shape, np.float32)
    stored[:, 0] = a * x + b * y + right
    stored[:, 1] = c * x + d * y + below
    stored[:, 2] = z * abs(a * d - b * c) ** 0.5
    lips = LipPatch(sighting.lips.logits, compose(to_stored, sighting.lips.to_px))
    return Face(stored, float(sighting.scores[0]), float(sighting.scores[1]), track_id, lips)


def is_tiny(frame: Affine, share: float = 1) -> bool:
    """Narrower than a share of MIN_FACE_PX."""
    return iod_of(frame) * _FACE_WIDTH < share * MIN_FACE_PX


def is_same(a: Affine, b: Affine) -> bool:
    """Two frames on one face, or one of them on a part of the other's face."""
    small, large = sorted((iod_of(a), iod_of(b)))
    apart = np.hypot(*(middle_of(a) - middle_of(b))) / large
    reach, ratio = _PART_OF_FACE
    return bool(apart < (reach if small < ratio * large else _SAME_FACE))


def _around(frame: Affine) -> list[Affine]:
    """A little smaller and larger frames about the same middle."""
    middle = middle_of(frame)
    frames = []
    for scale in (0.94, 1.06):
        linear = frame[:, :2] * scale
        shift = middle - linear @ np.linalg.solve(frame[:, :2], middle - frame[:, 2])
        frames.append(np.column_stack([linear, shift]))
    return frames


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
