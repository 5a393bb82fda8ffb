"""Frame -> FrameFaces: finds faces and follows them; and the same for one picture.

A face is followed from where it was: the mesh net's crop lies where the last frame's points were.
The detector looks at the whole picture only when nothing is followed, when a face was lost, after
a cut, and now and then for new faces: by the seconds of the film, not by frames.
"""

from dataclasses import replace
from fractions import Fraction

import numpy as np
from makeup_video.pipeline.faces.face import Face, FrameFaces
from makeup_video.pipeline.faces.landmarks import (
    FaceLandmarks,
    detect,
    is_same,
    is_tiny,
    locate,
    to_face,
)
from makeup_video.pipeline.faces.nets import FaceNets, load_nets
from makeup_video.pipeline.frames.frame import Frame
from makeup_video.pipeline.frames.views import FramePicture, Picture, RgbPicture

# For most faces, for crowds, and for one that fills the frame.
DETECTOR_SIDES_PX = (256, 512, 128)
TILTS_DEGREES = (-40, 40)  # the picture is turned by so much when no face was found
MAX_FACES = 32  # bounds the time of a frame
_ALIKE = 0.97  # of the width of the largest


def find_faces(rgb8: np.ndarray) -> tuple[Face, ...]:
    """The faces of an upright picture, largest first, those about as large from left to right; none
    is ordinary.

    rgb8: (H, W, 3) uint8, encoded R'G'B', any size. Faces less than 40 px wide are left out, and
    so are those beyond the 32 surest. Raises ValueError for another shape or dtype.
    """
    return find_in(RgbPicture(rgb8), load_nets())[0]


def find_faces_in_frame(frame: Frame, pixel_aspect: Fraction | float = 1) -> tuple[FrameFaces, int]:
    """The same for a frame that stands alone, a picture; and how many faces were too small."""
    faces, tiny_faces = find_in(FramePicture(frame, pixel_aspect), load_nets())
    return FrameFaces(frame, faces), tiny_faces


def find_in(picture: Picture, nets: FaceNets) -> tuple[tuple[Face, ...], int]:
    """The same for any picture and with any nets."""
    found: list[FaceLandmarks] = []
    tiny: list[FaceLandmarks] = []
    for tilt_degrees in (0, *TILTS_DEGREES):
        for guess in detect(nets, picture, DETECTOR_SIDES_PX, tilt_degrees):
            if len(found) >= MAX_FACES:
                break
            if any(is_same(guess, other.frame) for other in (*found, *tiny)):
                continue
            one = locate(nets, picture, guess, carefully=True)
            if one and not any(is_same(one.frame, other.frame) for other in (*found, *tiny)):
                (tiny if is_tiny(one.frame) else found).append(one)
        if found or tiny:
            break
    faces = _in_order([to_face(one, picture, 0) for one in found])
    # numbered by size: the same numbers however sure the nets are, and wherever it is stored
    return tuple(replace(face, track_id=at) for at, face in enumerate(faces)), len(tiny)


def largest_first(faces: list[Face]) -> tuple[Face, ...]:
    if len(faces) > 1:
        faces = sorted(faces, key=lambda face: -face.area_px2)
    return tuple(faces)


def _in_order(faces: list[Face]) -> tuple[Face, ...]:
    """Largest first. Of faces about as large as each other, which one measures larger changes with a
    picture's least detail: those go from left to right, and from top to bottom."""
    rest, ordered = largest_first(faces), []
    while rest:
        alike = [face for face in rest if face.area_px2 > _ALIKE**2 * rest[0].area_px2]
        ordered += sorted(alike, key=lambda face: float(face.points_px[:, :2].mean(0) @ (3, 1)))
        rest = rest[len(alike) :]
    return tuple(ordered)
