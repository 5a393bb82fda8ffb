"""The landmarks of one face, located from a detection; follow.py finds them in the next frame."""

import math
from dataclasses import dataclass, field, replace

import numpy as np
from makeup_video.pipeline.faces.crop_layout import CropLayout
from makeup_video.pipeline.faces.face import MIN_FACE_PX, POINTS, Face, LipPatch
from makeup_video.pipeline.faces.nets import FaceNets, Mesh
from makeup_video.pipeline.faces.optical_flow import LumaCrop
from makeup_video.pipeline.faces.similarity import (
    STAY,
    Similarity,
    iod_of,
    middle_of,
)
from makeup_video.pipeline.frames.affine import AS_STORED, compose
from makeup_video.pipeline.frames.sampling import step_px
from makeup_video.pipeline.frames.views import Picture

DETECTOR_THRESHOLD = 0.35
MAX_DETECTIONS = 64
# Least scores of the mesh net. 99.5 % of faces score over 0.9, masked ones too; a face that is
# already followed may look doubtful for a moment.
_A_FACE, STILL_A_FACE = 0.85, 0.4
# A face that the picture's border cuts off scores less: of the faces that lose a third, half score
# under 0.85. A face counts as cut off when this share of its points (_CUT) lies beyond the border.
_A_CUT_FACE, _CUT = 0.7, 0.15
_FACE_WIDTH = 1.75  # of the mean face's oval, in IOD
# The mesh net reads a detection in several passes. A score below the least score of its pass means
# that there is no face. A detection may be off by half a face, so the first score means nothing.
_LEAST_SCORES, _LEAST_SCORES_AVERAGE = (0, 0.02, 0.5), (0, 0, 0.02, 0.5)
# How often the lip and eye nets read a newly located face, each time where they last found lips and
# eyes. After three readings the crops hardly move in the frames that follow.
_READINGS, _READINGS_AVERAGE = 3, 2
_RESIZED = 0.94, 1.06  # two more sizes of the crop for a mean of several readings, by eye
_LEAST_SEEN = 0.15  # share of the points' box, each way, that must lie in the picture; by eye
_LEAST_SPAN_PX = MIN_FACE_PX / 3  # of the longer side of that box, by eye
# Two poses are of one face when their centres lie less than this apart, in IOD of the larger one.
_SAME_FACE = 0.6
# The same for a part of a face that was taken for a face, such as the mouth. A pose may be such a
# part if its size, relative to the larger one, is below the second number.
_PART_OF_FACE = 1.15, 0.7
# Most mean distance, in IOD, between the points read from a crop and from its mirror image. 99 % of
# faces stay below 0.027, masked ones too; hardly any false detection does.
_AGREE, AGREE_STILL, _AGREE_CUT = 0.035, 0.05, 0.045


@dataclass(slots=True)
class FaceLandmarks:
    """What is known of one face, in upright px of a Picture; points are complex, x + iy.

    xy: (478,) complex128. z: (478,) float64.
    scores: the probabilities that this is a face, and that its mouth is visible.
    pose: the similarity that lays the mean face over the points.
    lips: where lipstick goes; its to_px leads to upright px.
    layout: where the crops of the nets lay.
    centres: five, see FaceNets.part_centres.
    steady_centres: the same; for a resting face, means of the last readings. The crops lie around
    them.
    steady_widening: the result of FaceNets.widening, averaged likewise.
    meshed_seconds: when the mesh net last read the face.
    step: the motion since the previous frame, px -> px.
    moved: how far the pose moved since then: IOD, log scale or radians, whichever is largest.
    luma: the face's luma, kept only when the motion to the next frame will be measured.
    painted_px: how many px would take lipstick, if the lip patch were 1 IOD wide.
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

    sides_px: longer sides of the detector's input; larger ones are cut to the picture's longer
    side. Several poses may be of one face. There are at most MAX_DETECTIONS, to bound the time of a
    frame.
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

    average: take the mean of several readings, for a single picture.
    """
    pose = detection
    for least_score in _LEAST_SCORES_AVERAGE if average else _LEAST_SCORES:
        mesh = nets.read_mesh(picture, pose)
        pose = nets.fit_pose(mesh.xy)
        if mesh.scores[0] < least_score or not is_plausible(mesh.xy, picture):
            return None
    mirrored = nets.read_mesh(picture, pose, mirrored=True)
    face, mouth = ((a + b) / 2 for a, b in zip(mesh.scores, mirrored.scores, strict=True))
    within = inside(mesh.xy, picture)
    is_cut = within.mean() < 1 - _CUT
    least, most = (_A_CUT_FACE, _AGREE_CUT) if is_cut else (_A_FACE, _AGREE)
    if face < least or disagreement(mesh, mirrored, pose, within) > most:
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
        elif further:  # as `relocate` does in the frames that follow
            layout = nets.layout_around(parts.centres, widening).rounded()
    return FaceLandmarks(
        xy, z, (face, mouth), nets.fit_pose(xy), parts.lips, layout, parts.centres, parts.centres,
        widening,
    )  # fmt: skip


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
    """True for two poses of one face, and when one pose is of a part of the other's face."""
    small, large = sorted((iod_of(a), iod_of(b)))
    apart = abs(middle_of(a) - middle_of(b)) / large
    reach, ratio = _PART_OF_FACE
    return apart < (reach if small < ratio * large else _SAME_FACE)


def hides(known: Similarity, pose: Similarity) -> bool:
    """True when a pose is that of a known face, or lies on that face.

    A face that is too small does not hide a clearly larger one beside it.
    """
    _, ratio = _PART_OF_FACE
    is_larger = iod_of(known) < ratio * iod_of(pose)
    return is_same(known, pose) and not (is_larger and is_tiny(known))


def _around(pose: Similarity) -> list[Similarity]:
    """A slightly smaller and a slightly larger pose about the same centre."""
    middle = middle_of(pose)
    return [
        Similarity(scale * pose.turn, middle - scale * (middle - pose.shift)) for scale in _RESIZED
    ]


def inside(xy: np.ndarray, picture: Picture) -> np.ndarray:
    """(478,) bool: which points lie within the picture."""
    across = (xy.real > 0) & (xy.real < picture.width_px)
    there: np.ndarray = across & (xy.imag > 0) & (xy.imag < picture.height_px)
    return there


def disagreement(mesh: Mesh, mirrored: Mesh, pose: Similarity, within: np.ndarray) -> float:
    """Mean distance between two meshes of one face, in IOD, over the points within the picture.

    Points beyond the border are guesses, and do not count.
    """
    if not within.any():
        return math.inf
    return float(np.abs(mesh.xy - mirrored.xy)[within].mean()) / iod_of(pose)


def is_plausible(xy: np.ndarray, picture: Picture) -> bool:
    """True for points that are finite, large enough, and at least partly in the picture."""
    if not np.isfinite(xy).all():
        return False
    spans = []
    for along, length in ((xy.real, picture.width_px), (xy.imag, picture.height_px)):
        low, high = float(along.min()), float(along.max())
        if min(high, length) - max(low, 0) <= _LEAST_SEEN * (high - low):
            return False
        spans.append(high - low)
    return max(spans) > _LEAST_SPAN_PX
