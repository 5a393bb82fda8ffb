"""One face of one picture: from a guess to its points, scores and lips; and which is which."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from makeup_video.pipeline.faces.face import MIN_FACE_PX, POINTS, Face, LipPatch
from makeup_video.pipeline.faces.nets import FaceNets, Mesh, View, lips_to_px
from makeup_video.pipeline.faces.optical_flow import Motion, Still
from makeup_video.pipeline.faces.similarity import STAY, Similarity, distance, iod_of, middle_of
from makeup_video.pipeline.frames.affine import compose
from makeup_video.pipeline.frames.views import Picture

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
_JERK = 0.05  # the same: more than a face that was at rest begins with
_FAST = 0.08  # the same: the mesh net had better look at every frame
MESH_SECONDS = (
    0.09  # between two looks of the mesh net; at more the smoothed lips of a still face shake
)
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
class FaceLandmarks:
    """What the nets tell of one face, in upright px of a Picture; places are complex, x + iy."""

    xy: np.ndarray  # (478,) complex128
    z: np.ndarray  # (478,)
    scores: tuple[float, float]  # probabilities: a face, a visible mouth
    frame: Similarity  # the face frame of the points
    lips: LipPatch
    view: View  # where the nets looked
    middles: list[complex]  # five, see FaceNets.middles
    meshed_seconds: float = -math.inf  # when the mesh net last looked at it
    # Its motion since the frame before, px -> px; and in IOD, log scale or radians, the most.
    step: Similarity = STAY
    moved: float = 0.0
    still: Still | None = None  # what was seen of it; only where its motion will be measured
    painted: int = field(init=False)  # px of the lip patch

    def __post_init__(self) -> None:
        self.painted = int(np.count_nonzero(self.lips.logits > 0))


def detect(
    nets: FaceNets, picture: Picture, sides_px: tuple[int, ...], tilt_degrees: float = 0
) -> list[Similarity]:
    """The detector's guesses at all these sizes (at most the picture's own), surest first.

    Several may be of one face. They bound the time of a frame: no more than MAX_GUESSES.
    """
    longer_px = math.ceil(max(picture.width_px, picture.height_px))
    found: list[tuple[float, Similarity]] = []
    for side_px in dict.fromkeys(min(side_px, longer_px) for side_px in sides_px):
        found += nets.detect(picture, side_px, DETECTOR_THRESHOLD, tilt_degrees)
    found.sort(key=lambda guess: -guess[0])
    return [frame for _, frame in found[:MAX_GUESSES]]


def locate(
    nets: FaceNets, picture: Picture, guess: Similarity, carefully: bool = False
) -> FaceLandmarks | None:
    """The face at a detector's guess; None when there is none after all.

    carefully: the mean of several looks, for a picture that stands alone.
    """
    frame = guess
    for hopeless in _HOPELESS_CAREFULLY if carefully else _HOPELESS:
        mesh = nets.read_mesh(picture, frame)
        frame = nets.face_frame(mesh.xy)
        if mesh.scores[0] < hopeless or not _is_plausible(mesh.xy, picture):
            return None
    mirrored = nets.read_mesh(picture, frame, mirrored=True)
    face, mouth = ((a + b) / 2 for a, b in zip(mesh.scores, mirrored.scores, strict=True))
    if face < _A_FACE or _disagreement(mesh, mirrored, frame) > _AGREE:
        return None
    xy, z = mesh.xy, mesh.z
    if carefully:
        looks = [nets.read_mesh(picture, f, m) for f in _around(frame) for m in (False, True)]
        looks += [mesh, mirrored]
        xy, z = np.mean([look.xy for look in looks], 0), np.mean([look.z for look in looks], 0)
    for _ in range(2):
        view = nets.view(xy)
        close = nets.look_closer(picture, view, both_ways=carefully)
        xy[nets.close_points] = close.xy
    return FaceLandmarks(xy, z, (face, mouth), nets.face_frame(xy), close.lips, view, close.middles)


def relocate(
    nets: FaceNets,
    picture: Picture,
    before: FaceLandmarks,
    seconds: float,
    doubtfully: bool = False,
) -> FaceLandmarks | None:
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
    before: FaceLandmarks,
    mesh_seconds: float | None,
    doubtfully: bool,
) -> FaceLandmarks | None:
    """mesh_seconds: the time, when the mesh net is to look; None: the rest is carried along."""
    view = _expected(before)
    if mesh_seconds is None:
        close = nets.look_closer(picture, view)
        step = _step_of(before.middles, close.middles)
        xy, z, scores, frame = step.of(before.xy), before.z, before.scores, step.after(before.frame)
        meshed_seconds = before.meshed_seconds
    else:
        seen = _mesh_again(nets, picture, view, doubtfully)
        if seen is None:
            return None
        mesh, is_where_expected = seen
        xy, z, scores, meshed_seconds = before.xy, before.z.copy(), mesh.scores, mesh_seconds
        xy = before.step.of(xy) if before.moved > _AT_REST else xy.copy()
        strayed_px = _STRAYED * iod_of(view.frame) if is_where_expected else 0
        if nets.take_rest(xy, z, mesh, strayed_px):
            view = nets.view(xy)
        close = nets.look_closer(picture, view)
        step = _step_of(before.middles, close.middles)
    xy[nets.close_points] = close.xy
    if mesh_seconds is not None:
        frame = step.after(before.frame).towards(nets.face_frame(xy), _CORRECTION)
    moved = distance(before.frame, frame)
    return FaceLandmarks(
        xy, z, scores, frame, close.lips, view, close.middles, meshed_seconds, step, moved
    )


def carry(nets: FaceNets, before: FaceLandmarks, motion: Motion) -> FaceLandmarks | None:
    """The same face a frame later, by its measured motion alone; None when the nets had better look."""
    close = motion.of(before.xy[nets.close_points])
    middles = nets.middles(close)
    step = _step_of(before.middles, middles)
    frame = step.after(before.frame)
    moved = distance(before.frame, frame)
    if moved > _FAST:
        return None
    xy = step.of(before.xy)
    xy[nets.close_points] = close
    lips, left, right = middles[:3]
    view = View(frame, (lips, left, right))
    view = before.view if before.view.strayed(view) < _AT_REST else view
    to_px = lips_to_px(view)
    logits = motion.carried(before.lips.logits, before.lips.to_px, to_px)
    found = FaceLandmarks(
        xy, before.z, before.scores, frame, LipPatch(logits, to_px), view, middles,
        before.meshed_seconds, step, moved,
    )  # fmt: skip
    return None if _is_odd(before, found) else found


def _step_of(before: Sequence[complex], now: Sequence[complex]) -> Similarity:
    """The similarity that takes both rims of `middles` before to those now."""
    left, right, new_left, new_right = (*before[3:], *now[3:])
    across = right - left
    turn = (new_right - new_left) / across if across else 1 + 0j
    return Similarity(turn, new_left - turn * left)


def _is_odd(before: FaceLandmarks, found: FaceLandmarks) -> bool:
    """Lips that jump about the face, or vanish: something is in front of them, it may be. And a face at
    rest that is somewhere else at once, in a film that jerks: lips and eyes were looked for in vain."""
    jump = abs(found.middles[0] - found.step.of(before.middles[0]))
    if jump > _LIPS_JUMP * iod_of(found.frame) or found.painted < before.painted / 2:
        return True
    return before.moved < _AT_REST and found.moved > _JERK


def expected_frame(before: FaceLandmarks) -> Similarity:
    """The face frame in the next picture, as far as can be foretold."""
    return before.step.after(before.frame) if before.moved > _AT_REST else before.frame


def _expected(before: FaceLandmarks) -> View:
    """Where to look for a face in the next frame."""
    step = before.step if before.moved > _AT_REST else STAY  # what moves moves on
    lips, left, right = (step.of(middle) for middle in before.middles[:3])
    view = View(step.after(before.frame), (lips, left, right))
    # the crops of a still face stay where they are: after their own noise they would wander
    return before.view if before.view.strayed(view) < _AT_REST else view


def _mesh_again(
    nets: FaceNets, picture: Picture, view: View, doubtfully: bool
) -> tuple[Mesh, bool] | None:
    """What the mesh net sees, and whether the face is where it was expected."""
    mesh = nets.read_mesh(picture, view.frame)
    frame = nets.face_frame(mesh.xy)
    is_where_expected = distance(view.frame, frame) < _MOVED_FAR
    if not is_where_expected:
        mesh = nets.read_mesh(picture, frame)
        frame = nets.face_frame(mesh.xy)
    resized = abs(math.log(max(iod_of(frame), 1e-6) / iod_of(view.frame)))
    if mesh.scores[0] < _STILL_A_FACE or resized > _SHRUNK or not _is_plausible(mesh.xy, picture):
        return None
    if doubtfully:
        mirrored = nets.read_mesh(picture, frame, mirrored=True)
        if _disagreement(mesh, mirrored, frame) > _AGREE_STILL:
            return None
    return mesh, is_where_expected


def to_face(sighting: FaceLandmarks, picture: Picture, track_id: int) -> Face:
    """Upright px -> a Face in px of the stored picture."""
    to_stored = picture.to_stored
    (a, b, _), (c, d, _) = to_stored.tolist()
    points = np.empty((POINTS, 3), np.float32)
    upright = sighting.xy.view(np.float64).reshape(POINTS, 2)
    points[:, :2] = upright @ to_stored[:, :2].T + to_stored[:, 2]
    points[:, 2] = sighting.z * abs(a * d - b * c) ** 0.5
    lips = LipPatch(sighting.lips.logits, compose(to_stored, sighting.lips.to_px))
    return Face(points, *sighting.scores, track_id, lips)


def is_tiny(frame: Similarity, share: float = 1) -> bool:
    """Narrower than a share of MIN_FACE_PX."""
    return iod_of(frame) * _FACE_WIDTH < share * MIN_FACE_PX


def is_same(a: Similarity, b: Similarity) -> bool:
    """Two frames on one face, or one of them on a part of the other's face."""
    small, large = sorted((iod_of(a), iod_of(b)))
    apart = abs(middle_of(a) - middle_of(b)) / large
    reach, ratio = _PART_OF_FACE
    return apart < (reach if small < ratio * large else _SAME_FACE)


def _around(frame: Similarity) -> list[Similarity]:
    """A little smaller and larger frames about the same middle."""
    middle = middle_of(frame)
    return [
        Similarity(scale * frame.turn, middle - scale * (middle - frame.shift))
        for scale in (0.94, 1.06)
    ]


def _disagreement(mesh: Mesh, mirrored: Mesh, frame: Similarity) -> float:
    """Mean distance of two readings of one face, in IOD."""
    return float(np.abs(mesh.xy - mirrored.xy).mean()) / iod_of(frame)


def _is_plausible(xy: np.ndarray, picture: Picture) -> bool:
    """Finite, of a size, and at least partly in the picture."""
    if not np.isfinite(xy).all():
        return False
    spans = []
    for along, length in ((xy.real, picture.width_px), (xy.imag, picture.height_px)):
        low, high = float(along.min()), float(along.max())
        if min(high, length) - max(low, 0) <= 0.15 * (high - low):
            return False
        spans.append(high - low)
    return max(spans) > MIN_FACE_PX / 3
