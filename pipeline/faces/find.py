"""Finds the faces of a single picture; tracker.py follows faces through a video."""

from collections.abc import Iterable, Iterator

import numpy as np
from makeup_video.pipeline.faces.face import Face, FrameFaces
from makeup_video.pipeline.faces.landmarks import (
    FaceLandmarks,
    detect,
    hides,
    is_tiny,
    locate,
    to_face,
)
from makeup_video.pipeline.faces.nets import FaceNets, load_nets
from makeup_video.pipeline.faces.right_way_up import right_way_up
from makeup_video.pipeline.faces.similarity import Similarity
from makeup_video.pipeline.frames.frame import Frame
from makeup_video.pipeline.frames.views import FramePicture, Picture, RgbPicture

# Longer sides of the detector's input: for most faces, for crowds, for a face that fills the frame.
DETECTOR_SIDES_PX = (256, 512, 128)
# By how much the picture is turned, in this order, when no upright face was found: for heads
# that tilt, for a phone laid flat, for a phone on its side.
TILTS_DEGREES = (-40, 40, 180, 90, -90)
# The longer side of the detector's input at which it finds a face of 60 px in 4K, and the longer
# side of a picture from which on this input is used, too.
_FINE_SIDE_PX, _FINE_FROM_PX = 1024, 1600
MAX_FACES = 32  # bounds the time of a frame
_SAME_WIDTH = 0.97  # share of the largest face's width: faces this wide count as equally large
_ACROSS = 3  # how much more left to right counts for the order than top to bottom, by eye


def find_faces(rgb8: np.ndarray) -> tuple[Face, ...]:
    """The faces of an upright picture, largest first, equally large ones from left to right.

    rgb8: (H, W, 3) uint8, encoded R'G'B', any size. Faces less than 40 px wide are left out, and
    so are all but the 32 surest. A picture may have no face. Raises ValueError for another shape or
    dtype.
    """
    return find_in(RgbPicture(rgb8), load_nets())[0]


def find_faces_in_frame(frame: Frame) -> tuple[FrameFaces, int]:
    """The faces of a single frame, and how many faces were too small."""
    faces, tiny_faces = find_in(FramePicture(frame), load_nets())
    return FrameFaces(frame, faces), tiny_faces


def find_in(picture: Picture, nets: FaceNets) -> tuple[tuple[Face, ...], int]:
    """The faces of any picture with any nets, and how many faces were too small."""
    found: list[FaceLandmarks] = []
    tiny: list[FaceLandmarks] = []
    for tilt_degrees in (0, *TILTS_DEGREES):
        sides_px = DETECTOR_SIDES_PX if tilt_degrees else (*DETECTOR_SIDES_PX, *fine_sides(picture))
        detections = detect(nets, picture, sides_px, tilt_degrees)
        for landmarks in new_faces(nets, picture, detections, [], average=True):
            (tiny if is_tiny(landmarks.pose) else found).append(landmarks)
            if len(found) >= MAX_FACES:
                break
        if found or tiny:
            break
    # Faces are numbered by size, so that neither scores nor the stored orientation matter.
    ordered = enumerate(in_order(found))
    return tuple(to_face(landmarks, picture, index) for index, landmarks in ordered), len(tiny)


def new_faces(
    nets: FaceNets,
    picture: Picture,
    detections: Iterable[Similarity],
    known: Iterable[Similarity],
    average: bool = False,
) -> Iterator[FaceLandmarks]:
    """The faces at these detections, each once, without the faces whose poses are known.

    Faces that are too small are included, so that they are not located again at their next
    detection. average: see `locate`.
    """
    poses = list(known)
    for detection in detections:
        if any(hides(pose, detection) for pose in poses):
            continue
        found = locate(nets, picture, detection, average)
        if found is None:
            continue
        found = right_way_up(nets, picture, found, average)
        if not any(hides(pose, found.pose) for pose in poses):
            poses.append(found.pose)
            yield found


def fine_sides(picture: Picture) -> tuple[int, ...]:
    """The extra side of the detector's input for small faces in a large picture, if it is large."""
    large = max(picture.width_px, picture.height_px) >= _FINE_FROM_PX
    return (_FINE_SIDE_PX,) if large else ()


def largest_first(faces: list[Face]) -> tuple[Face, ...]:
    """Faces sorted by the area of the box around their points."""
    if len(faces) > 1:
        faces = sorted(faces, key=lambda face: -face.area_px2)
    return tuple(faces)


def in_order(faces: list[FaceLandmarks]) -> list[FaceLandmarks]:
    """Faces sorted by size, equally large ones from left to right and from top to bottom.

    Which of two equally large faces measures larger would change with the slightest detail.
    """
    rest, ordered = sorted(faces, key=lambda face: -_area_px2(face)), []
    while rest:
        equal = [face for face in rest if _area_px2(face) > _SAME_WIDTH**2 * _area_px2(rest[0])]
        ordered += sorted(
            equal, key=lambda face: _ACROSS * face.xy.mean().real + face.xy.mean().imag
        )
        rest = rest[len(equal) :]
    return ordered


def _area_px2(face: FaceLandmarks) -> float:
    """The area of the box around the points."""
    return float(np.ptp(face.xy.real)) * float(np.ptp(face.xy.imag))
