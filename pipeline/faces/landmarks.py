"""The landmarks of one face: located from a detection, and followed into the next frame."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from makeup_video.pipeline.faces.crop_layout import CropLayout, lip_patch_to_px
from makeup_video.pipeline.faces.face import MIN_FACE_PX, POINTS, Face, LipPatch
from makeup_video.pipeline.faces.nets import FaceNets, Mesh, Parts
from makeup_video.pipeline.faces.optical_flow import LumaCrop, Motion
from makeup_video.pipeline.faces.similarity import (
    STAY,
    Similarity,
    distance,
    iod_of,
    middle_of,
)
from makeup_video.pipeline.frames.affine import AS_STORED, compose
from makeup_video.pipeline.frames.clock import slot
from makeup_video.pipeline.frames.sampling import step_px
from makeup_video.pipeline.frames.views import Picture

DETECTOR_THRESHOLD = 0.35
MAX_DETECTIONS = 64
# Least scores of the mesh net. 99.5 % of faces score over 0.9, masked ones too; a face that is
# already followed may look doubtful for a moment.
_A_FACE, _STILL_A_FACE = 0.85, 0.4
# A face that the picture's border cuts scores less: half of those cut by a third score under 0.85.
_A_CUT_FACE, _CUT = 0.7, 0.15  # least score, and the share of points beyond the border
_FACE_WIDTH = 1.75  # of the mean face's oval, in IOD
# Least scores after each pass of the mesh net from a detection, below which there is no further
# pass. A detection may be off by half a face, so the score means nothing before the second pass.
_LEAST_SCORES, _LEAST_SCORES_AVERAGE = (0, 0.02, 0.5), (0, 0, 0.02, 0.5)
# How often the nets of lips and eyes read a face that was located anew, each time at the place that
# they found before. After three readings its crops hardly move in the frames that follow.
_READINGS, _READINGS_AVERAGE = 3, 2
# How far a face moves between two frames: IOD, log scale or radians, whichever is largest.
_MOVED_FAR = 0.12  # more: the mesh net reads the face once more, at its new pose
_AT_REST = 0.015  # less: no more than noise
_JERK = 0.05  # more than a resting face moves in its first frame of motion
_FAST = 0.08  # more: the mesh net reads every frame
# The mesh net runs once in a slot of this length; at more the smoothed lips of a still face shake.
MESH_SECONDS = 0.1
# IOD between the lips or eyes of the mesh net and those of their own nets: farther, the crops of
# the lip and eye nets lie in the wrong place.
_STRAYED = 0.2
# Shares of the way to their crop's border: lips beyond it are read again, where it is so much less.
_NEAR_BORDER, _CLEARLY_LESS = 0.97, 0.05
_LIPS_JUMP = 0.05  # IOD in one frame, relative to the eyes
_SHRUNK = 0.3  # log scale in MESH_SECONDS: more than any face changes
_CORRECTION = 0.3  # share of the way to the mesh net's pose; a full step would jolt the crops
# Of each new reading in the steady centres: the least share, and the distance in IOD at which it
# alone counts.
_STEADY_SHARE, _STEADY_IOD = 0.1, 0.02
_SAME_FACE = 0.6  # IOD between the centres of two poses of one face
_PART_OF_FACE = 1.15, 0.7  # IOD of the larger face, and ratio of sizes: a mouth taken for a face
# Mean distance, in IOD, between the points of a crop and of the same crop mirrored. 99 % of faces
# stay below 0.027, masked ones too; hardly any false detection does.
_AGREE, _AGREE_STILL, _AGREE_CUT = 0.035, 0.05, 0.045


@dataclass(slots=True)
class FaceLandmarks:
    """What is known of one face, in upright px of a Picture; points are complex, x + iy.

    xy: (478,) complex128. z: (478,) float64.
    scores: two probabilities: this is a face, and its mouth is visible.
    pose: the similarity that lays the mean face over the points.
    lips: where lipstick goes; its to_px leads to upright px.
    layout: where the crops of the nets lay.
    centres: five, as of FaceNets.part_centres.
    steady_centres: the same, but of a resting face means of the last readings; crops lie around
    them.
    steady_widening: what FaceNets.widening gives, likewise the mean of the last readings.
    meshed_seconds: when the mesh net last read the face.
    step: the motion since the previous frame, px -> px.
    moved: how far the pose moved in it: IOD, log scale or radians, whichever is largest.
    luma: the face's luma, kept only when the motion to the next frame will be measured.
    painted_px: how many px of a lip patch that is 1 IOD wide take lipstick.
    """

    xy: np.ndarray
    z: np.ndarray
    scores: tuple[float, float]
    pose: Similarity
    lips: LipPatch
    layout: CropLayout
    centres: list[complex]
    steady_centres: list[complex]
    steady_widening: float
    meshed_seconds: float = -math.inf
    step: Similarity = STAY
    moved: float = 0.0
    luma: LumaCrop | None = None
    painted_px: float = field(init=False)

    def __post_init__(self) -> None:
        self.painted_px = int(np.count_nonzero(self.lips.logits > 0)) * self.lips.span**2


def detect(
    nets: FaceNets, picture: Picture, sides_px: tuple[int, ...], tilt_degrees: float = 0
) -> list[Similarity]:
    """Poses of faces that the detector finds at any of these input sizes, surest first.

    sides_px: longer sides of the detector's input; none is larger than the picture. Several poses
    may be of one face. There are at most MAX_DETECTIONS, to bound the time of a frame.
    """
    longer_px = math.ceil(max(picture.width_px, picture.height_px))
    detections: list[tuple[float, Similarity]] = []
    for side_px in dict.fromkeys(min(side_px, longer_px) for side_px in sides_px):
        detections += nets.detect(picture, side_px, DETECTOR_THRESHOLD, tilt_degrees)
    detections.sort(key=lambda detection: -detection[0])
    return [pose for _, pose in detections[:MAX_DETECTIONS]]


def locate(
    nets: FaceNets, picture: Picture, detection: Similarity, average: bool = False
) -> FaceLandmarks | None:
    """The face at a detection; None when there is no face after all.

    average: take the mean of several readings, for a picture that stands alone.
    """
    pose = detection
    for least_score in _LEAST_SCORES_AVERAGE if average else _LEAST_SCORES:
        mesh = nets.read_mesh(picture, pose)
        pose = nets.fit_pose(mesh.xy)
        if mesh.scores[0] < least_score or not _is_plausible(mesh.xy, picture):
            return None
    mirrored = nets.read_mesh(picture, pose, mirrored=True)
    face, mouth = ((a + b) / 2 for a, b in zip(mesh.scores, mirrored.scores, strict=True))
    inside = _inside(mesh.xy, picture)
    is_cut = inside.mean() < 1 - _CUT
    least, most = (_A_CUT_FACE, _AGREE_CUT) if is_cut else (_A_FACE, _AGREE)
    if face < least or _disagreement(mesh, mirrored, pose, inside) > most:
        return None
    xy, z = mesh.xy, mesh.z
    if average:
        meshes = [nets.read_mesh(picture, p, m) for p in _around(pose) for m in (False, True)]
        meshes += [mesh, mirrored]
        xy, z = np.mean([m.xy for m in meshes], 0), np.mean([m.z for m in meshes], 0)
    layout = nets.crop_layout(xy)
    for further in reversed(range(_READINGS_AVERAGE if average else _READINGS)):
        parts = nets.read_parts(picture, layout, with_mirrored=average)
        widening = nets.widening(parts.xy, layout.pose)
        xy[nets.part_points] = parts.xy
        if further and average:
            layout = nets.crop_layout(xy)
        elif further:  # as in the frames that follow
            layout = nets.layout_around(parts.centres, widening).rounded()
    return FaceLandmarks(
        xy, z, (face, mouth), nets.fit_pose(xy), parts.lips, layout, parts.centres, parts.centres,
        widening,
    )  # fmt: skip


def relocate(
    nets: FaceNets,
    picture: Picture,
    before: FaceLandmarks,
    seconds: float,
    verify: bool = False,
) -> FaceLandmarks | None:
    """The same face a frame later, at `seconds` of the video; None when it is gone.

    The lip and eye nets read every frame, at the place that the face's motion leads to. The mesh
    net runs now and then: it reads the other points, and checks that this still is a face. In
    between, the other points move along. verify: check the mirrored crop, too.
    """
    is_due = verify or before.moved > _FAST or _slot(seconds) != _slot(before.meshed_seconds)
    found = _follow(nets, picture, before, seconds if is_due else None, verify)
    if found is not None and not is_due and _is_odd(before, found):
        found = _follow(nets, picture, before, seconds, verify)
    return found


def _slot(seconds: float) -> float:
    return slot(seconds, MESH_SECONDS) if math.isfinite(seconds) else seconds


def carry(nets: FaceNets, before: FaceLandmarks, motion: Motion) -> FaceLandmarks | None:
    """The same face a frame later, moved by its measured motion.

    None when the nets must read it.
    """
    part_xy = motion.move(before.xy[nets.part_points])
    centres = nets.part_centres(part_xy)
    step = _step_between(before.centres, centres)
    pose = step.after(before.pose)
    moved = distance(before.pose, pose)
    if moved > _FAST:
        return None
    xy = step.apply(before.xy)
    xy[nets.part_points] = part_xy
    steady = _steady(before, centres)
    layout = nets.layout_around(steady, before.steady_widening).rounded(before.layout)
    to_px = lip_patch_to_px(layout)
    logits = motion.move_patch(before.lips.logits, before.lips.to_px, to_px)
    found = FaceLandmarks(
        xy, before.z, before.scores, pose, LipPatch(logits, to_px, layout.lip_span), layout,
        centres, steady, before.steady_widening, before.meshed_seconds, step, moved,
    )  # fmt: skip
    return None if _is_odd(before, found) else found


def expected_pose(before: FaceLandmarks) -> Similarity:
    """The pose in the next frame, if the face moves on as it does."""
    return _going_on(before).after(before.pose)


def _going_on(before: FaceLandmarks) -> Similarity:
    """The motion to the next frame, if the face moves on as it does; none at rest."""
    return STAY.towards(before.step, min(max(before.moved / _AT_REST - 0.5, 0), 1))


def _follow(
    nets: FaceNets,
    picture: Picture,
    before: FaceLandmarks,
    mesh_seconds: float | None,
    verify: bool,
) -> FaceLandmarks | None:
    """mesh_seconds: the time, when the mesh net is to run; None: the other points move along."""
    layout = _expected_layout(nets, before)
    if mesh_seconds is None:
        layout, parts, widening = _read_parts(nets, picture, layout)
        step = _step_between(before.centres, parts.centres)
        xy, z, scores = step.apply(before.xy), before.z, before.scores
        pose, meshed_seconds = step.after(before.pose), before.meshed_seconds
    else:
        checked = _read_mesh_again(nets, picture, layout.pose, verify)
        if checked is None:
            return None
        mesh, is_where_expected = checked
        xy, z, scores, meshed_seconds = before.xy, before.z.copy(), mesh.scores, mesh_seconds
        xy = _going_on(before).apply(xy)
        strayed_px = _STRAYED * iod_of(layout.pose) if is_where_expected else 0
        if nets.merge_mesh(xy, z, mesh, strayed_px):
            layout = nets.crop_layout(xy).rounded()
        layout, parts, widening = _read_parts(nets, picture, layout)
        step = _step_between(before.centres, parts.centres)
    xy[nets.part_points] = parts.xy
    if mesh_seconds is not None:
        pose = step.after(before.pose).towards(nets.fit_pose(xy), _CORRECTION)
    moved = distance(before.pose, pose)
    return FaceLandmarks(
        xy, z, scores, pose, parts.lips, layout, parts.centres, _steady(before, parts.centres),
        _steady_number(before.steady_widening, widening), meshed_seconds, step, moved,
    )  # fmt: skip


def _read_parts(
    nets: FaceNets, picture: Picture, layout: CropLayout
) -> tuple[CropLayout, Parts, float]:
    """Where the crops lay, what was read in them, and how much wider that of the lips should be.

    Lips that moved or opened at once, beyond their crop, are read again in a crop around them.
    """
    parts = nets.read_parts(picture, layout)
    widening = nets.widening(parts.xy, layout.pose)
    reach = nets.lips_reach(parts.xy, layout)
    if reach > _NEAR_BORDER:
        better = nets.layout_that_holds(parts, widening, _NEAR_BORDER)
        if nets.lips_reach(parts.xy, better) < reach - _CLEARLY_LESS:
            layout, parts = better, nets.read_parts(picture, better)
            widening = nets.widening(parts.xy, layout.pose)
    return layout, parts, widening


def _step_between(before: Sequence[complex], now: Sequence[complex]) -> Similarity:
    """The similarity that leads both eyes' rims of `part_centres` before to those now."""
    left, right, new_left, new_right = (*before[3:], *now[3:])
    across = right - left
    turn = (new_right - new_left) / across if across else 1 + 0j
    return Similarity(turn, new_left - turn * left)


def _steady(before: FaceLandmarks, centres: Sequence[complex]) -> list[complex]:
    """The steady centres with one more reading: noise fades, and motion is followed.

    A layout around single readings would swing between two grid points that lie about as near.
    """
    far = _STEADY_IOD * iod_of(before.pose)
    steady = []
    for mean, new in zip(before.steady_centres, centres, strict=True):
        off = new - mean
        steady.append(mean + min(max(abs(off) / far, _STEADY_SHARE), 1) * off)
    return steady


def _steady_number(mean: float, new: float) -> float:
    """The same for the widening of the lips' crop; a whole step counts at once."""
    return mean + max(_STEADY_SHARE, min(abs(new - mean), 1)) * (new - mean)


def _is_odd(before: FaceLandmarks, found: FaceLandmarks) -> bool:
    """Whether the lips jumped or vanished, or a resting face moved at once.

    Something may be in front of the lips. Or the video skipped a frame, and lips and eyes were read
    in the wrong place.
    """
    jump = abs(found.centres[0] - found.step.apply(before.centres[0]))
    if jump > _LIPS_JUMP * iod_of(found.pose) or found.painted_px < before.painted_px / 2:
        return True
    return before.moved < _AT_REST and found.moved > _JERK


def _expected_layout(nets: FaceNets, before: FaceLandmarks) -> CropLayout:
    """Where the crops of a face lie in the next frame, if the face moves on as it does."""
    step = _going_on(before)
    centres = [step.apply(centre) for centre in before.steady_centres]
    return nets.layout_around(centres, before.steady_widening).rounded(before.layout)


def _read_mesh_again(
    nets: FaceNets, picture: Picture, expected: Similarity, verify: bool
) -> tuple[Mesh, bool] | None:
    """The mesh, and whether the face is where it was expected; None when it no longer looks
    like a face."""
    mesh = nets.read_mesh(picture, expected)
    pose = nets.fit_pose(mesh.xy)
    is_where_expected = distance(expected, pose) < _MOVED_FAR
    if not is_where_expected:
        mesh = nets.read_mesh(picture, pose)
        pose = nets.fit_pose(mesh.xy)
    resized = abs(math.log(max(iod_of(pose), 1e-6) / iod_of(expected)))
    if mesh.scores[0] < _STILL_A_FACE or resized > _SHRUNK or not _is_plausible(mesh.xy, picture):
        return None
    if verify:
        mirrored = nets.read_mesh(picture, pose, mirrored=True)
        if _disagreement(mesh, mirrored, pose, _inside(mesh.xy, picture)) > _AGREE_STILL:
            return None
    return mesh, is_where_expected


def to_face(landmarks: FaceLandmarks, picture: Picture, track_id: int) -> Face:
    """Landmarks in upright px -> a Face in px of the stored picture."""
    to_stored = picture.to_stored
    points = np.empty((POINTS, 3), np.float32)
    upright = landmarks.xy.view(np.float64).reshape(POINTS, 2)
    if to_stored is AS_STORED:
        points[:, :2], points[:, 2] = upright, landmarks.z
        return Face(points, *landmarks.scores, track_id, landmarks.lips)
    points[:, :2] = upright @ to_stored[:, :2].T + to_stored[:, 2]
    points[:, 2] = landmarks.z * step_px(to_stored)
    lips = replace(landmarks.lips, to_px=compose(to_stored, landmarks.lips.to_px))
    return Face(points, *landmarks.scores, track_id, lips)


def is_tiny(pose: Similarity, share: float = 1) -> bool:
    """True for a face narrower than a share of MIN_FACE_PX."""
    return iod_of(pose) * _FACE_WIDTH < share * MIN_FACE_PX


def is_same(a: Similarity, b: Similarity) -> bool:
    """True for two poses of one face, and when one pose lies on a part of the other's face."""
    small, large = sorted((iod_of(a), iod_of(b)))
    apart = abs(middle_of(a) - middle_of(b)) / large
    reach, ratio = _PART_OF_FACE
    return apart < (reach if small < ratio * large else _SAME_FACE)


def _around(pose: Similarity) -> list[Similarity]:
    """A slightly smaller and a slightly larger pose about the same centre."""
    middle = middle_of(pose)
    return [
        Similarity(scale * pose.turn, middle - scale * (middle - pose.shift))
        for scale in (0.94, 1.06)
    ]


def _inside(xy: np.ndarray, picture: Picture) -> np.ndarray:
    """(478,) bool: which points lie within the picture."""
    across = (xy.real > 0) & (xy.real < picture.width_px)
    within: np.ndarray = across & (xy.imag > 0) & (xy.imag < picture.height_px)
    return within


def _disagreement(mesh: Mesh, mirrored: Mesh, pose: Similarity, inside: np.ndarray) -> float:
    """Mean distance between two meshes of one face, in IOD, over the points within the picture.

    Points beyond the border are guesses.
    """
    if not inside.any():
        return math.inf
    return float(np.abs(mesh.xy - mirrored.xy)[inside].mean()) / iod_of(pose)


def _is_plausible(xy: np.ndarray, picture: Picture) -> bool:
    """True for points that are finite, large enough, and at least partly in the picture."""
    if not np.isfinite(xy).all():
        return False
    spans = []
    for along, length in ((xy.real, picture.width_px), (xy.imag, picture.height_px)):
        low, high = float(along.min()), float(along.max())
        if min(high, length) - max(low, 0) <= 0.15 * (high - low):
            return False
        spans.append(high - low)
    return max(spans) > MIN_FACE_PX / 3
