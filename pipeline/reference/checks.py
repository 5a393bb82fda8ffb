"""Chooses the face in a photo, and checks that a look can be read from it."""

import math
from collections.abc import Sequence
from functools import cache

import cv2
import numpy as np
from makeup_video.pipeline.errors import PhotoError, SeveralFacesError
from makeup_video.pipeline.faces.face import Face, is_sound
from makeup_video.pipeline.faces.find import find_faces
from makeup_video.pipeline.faces.lip_mask import lip_mask
from makeup_video.pipeline.faces.net import read_array
from makeup_video.pipeline.faces.topology import EYE_CORNERS, FACE_OVAL, LIPS

MIN_WIDTH_PX = 100  # least width of the face
MAX_TURN_DEGREES = 40
# A face narrower than this share of the largest face is a person in the background.
BYSTANDER = 0.4
# The least chroma of a face that does not follow from its luma (8-bit codes, see _own_chroma). Of
# 974 photos that are not grey, the 17 toned ones have up to 3.0, the others 3.7 or more.
TINT_CODES = 3.2
# The least median of a face's brightest channel. Below it, the camera's noise outweighs the signal;
# portraits in poor light have 45 or more.
DARK_CODES = 25
# A pixel with two channels at white has lost its hue. The first is the code of white, the second
# the largest share of such pixels on the lips. Ordinary lips have at most 0.04, shine included.
LOST_CODE, MOST_LOST = 254, 0.2
_SAMPLE_PX = 64  # the box around a face is reduced to this shorter side to judge its colours
_LUMA = np.array([0.299, 0.587, 0.114])  # of R'G'B', BT.601
_BLACK_CODE, _WHITE_CODE, _FEWEST_PIXELS = 2, 250, 200  # clipped channels show no tint
_MEDIUM, _SHADE = 100.0, 30.0  # luma of a medium face, and of shadow, whose chroma is mostly noise
# Least share of a region's points in the picture: at most the region's rim may be cut off.
_NEARLY_ALL = 0.9


def choose_face(faces: Sequence[Face], chosen: str = "") -> Face:
    """Choose the face to read. Raises PhotoError.

    faces: largest first.
    chosen: "largest", the number of a face, or "" for the only face, as in look_from_photo. Much
    smaller faces in the background do not count. When several faces could be meant, the error is a
    SeveralFacesError with these `faces`.
    """
    if not faces:
        raise PhotoError(
            "no face was found: give a photo that shows one upright and from the front, larger or "
            "brighter"
        )
    if chosen.isdigit():
        for face in faces:
            if face.track_id == int(chosen):
                return face
        found = "faces" if len(faces) > 1 else "face"
        raise PhotoError(
            f"there is no face {chosen} in the photo; it has {found} {face_list(faces)}: choose "
            f"{'one of them' if len(faces) > 1 else 'that one'}"
        )
    rivals = [face for face in faces if width_px(face) > BYSTANDER * width_px(faces[0])]
    if len(rivals) > 1 and chosen != "largest":
        raise SeveralFacesError(
            f"one face was expected, {len(rivals)} were found: cut the photo to the one whose "
            "makeup you want",
            rivals,
        )
    return faces[0]


def faces_within(rgb8: np.ndarray) -> tuple[Face, ...]:
    """The faces whose lips lie within the photo, largest first; all faces if no face's lips do.

    A neighbour whom the photo cuts off is not meant.  rgb8: (H, W, 3) uint8, encoded R'G'B'.
    """
    faces = find_faces(rgb8)
    return tuple(face for face in faces if is_inside(rgb8, face, LIPS)) or faces


def check_face(rgb8: np.ndarray, face: Face) -> None:
    """Raise PhotoError when makeup cannot be read from this face."""
    if not is_sound(face):
        raise PhotoError("the face has numbers that are not finite: give one of find_faces")
    if width_px(face) < MIN_WIDTH_PX:
        raise PhotoError(
            f"the face is {math.floor(width_px(face))} px wide, and at least {MIN_WIDTH_PX} px are "
            "needed: give a larger photo, or one from closer"
        )
    if (turn := turn_degrees(face)) > MAX_TURN_DEGREES:
        raise PhotoError(
            f"the face is turned by {math.ceil(turn)} degrees, and at most {MAX_TURN_DEGREES} are "
            "read: give a photo that shows it more from the front"
        )
    if face.mouth_weight < 1 or not is_inside(rgb8, face, LIPS):
        raise PhotoError(
            "the mouth is covered, cut off, or cannot be seen well: give a photo that shows "
            "the lips"
        )
    if np.median(_sample(rgb8, face).max(1)) < DARK_CODES:
        raise PhotoError("the face is too dark to tell its colours: give a brighter photo")
    if _own_chroma(rgb8, face) < TINT_CODES:
        raise PhotoError(
            "the photo is grey, or of one tint as sepia is, so its colours are lost: give a "
            "colour photo"
        )
    if _lost_share(rgb8, face) > MOST_LOST:
        raise PhotoError(
            "the lips are overexposed, and their colour is lost: give a photo with less "
            "light on them"
        )


def width_px(face: Face) -> float:
    """The width of the face's oval along the line through the eyes, in px."""
    across = face.points_px[EYE_CORNERS[1], :2] - face.points_px[EYE_CORNERS[0], :2]
    along = face.points_px[FACE_OVAL, :2] @ across / max(math.hypot(*across.tolist()), 1e-9)
    return float(np.ptp(along))


def turn_degrees(face: Face) -> float:
    """The angle between the direction in which the face looks and the direction of the viewer.

    Tilting the head to the side does not change it. The angle comes from the rotation that brings
    the mean face closest to the points (Kabsch 1976).
    """
    mean = _mean_face()
    points = face.points_px.astype(np.float64)
    u, _, vt = np.linalg.svd((mean - mean.mean(0)).T @ (points - points.mean(0)))
    sign = np.sign(np.linalg.det(u @ vt))
    forward = u[2] @ np.diag([1, 1, sign]) @ vt
    return math.degrees(math.acos(min(max(float(forward[2]), -1.0), 1.0)))


def is_inside(rgb8: np.ndarray, face: Face, points: Sequence[int] | np.ndarray) -> bool:
    """True when nearly all of these points of the face lie in the picture."""
    xy = face.points_px[np.asarray(points), :2]
    inside = ((xy > -0.5) & (xy < np.array(rgb8.shape[1::-1]) - 0.5)).all(1)
    return bool(inside.mean() > _NEARLY_ALL)


@cache
def _mean_face() -> np.ndarray:
    return read_array("mean_face.npy").astype(np.float64)


def _sample(rgb8: np.ndarray, face: Face) -> np.ndarray:
    """(N, 3) uint8: the box around a face, reduced to a few thousand pixels."""
    size = np.array(rgb8.shape[1::-1])
    low = np.clip(face.points_px[:, :2].min(0), 0, size - 1).astype(int)
    high = np.clip(face.points_px[:, :2].max(0), low + 1, size).astype(int)
    part = rgb8[low[1] : high[1], low[0] : high[0]]
    scale = min(1.0, _SAMPLE_PX / min(part.shape[:2]))
    size_wh = [max(1, round(scale * side)) for side in part.shape[1::-1]]
    return cv2.resize(part, size_wh, interpolation=cv2.INTER_AREA).reshape(-1, 3)


def _own_chroma(rgb8: np.ndarray, face: Face) -> float:
    """How far the chroma of a face's pixels lies from a curve over their luma.

    In grey and toned pictures (sepia, duotone) the chroma follows from the luma. The unit is a code
    at medium brightness.
    """
    pixels = _sample(rgb8, face).astype(np.float64)
    unclipped = pixels[(pixels.max(1) < _WHITE_CODE) & (pixels.min(1) > _BLACK_CODE)]
    if len(unclipped) < _FEWEST_PIXELS:
        return math.inf  # too little is left to judge by
    luma = unclipped @ _LUMA
    chroma = unclipped[:, [0, 2]] - luma[:, None]
    curve = np.vander(luma / 255, 4)  # cubic
    residual = chroma - curve @ np.linalg.lstsq(curve, chroma, rcond=None)[0]
    medium = (luma.mean() + _SHADE) / (_MEDIUM + _SHADE)
    return float(np.sqrt((residual**2).sum(1).mean()) / medium)


def _lost_share(rgb8: np.ndarray, face: Face) -> float:
    """The share of the lips' pixels whose hue is lost: two or three channels are at white."""
    lips = rgb8[lip_mask(rgb8, face) > 0.5]
    return float(((lips >= LOST_CODE).sum(1) >= 2).mean()) if len(lips) else 0.0


def face_list(faces: Sequence[Face]) -> str:
    """List faces for a message, such as '0 at (120, 300), 210 px wide; ...'."""
    entries = []
    for face in faces:
        x, y = face.points_px[:, :2].mean(0)
        entries.append(f"{face.track_id} at ({x:.0f}, {y:.0f}), {width_px(face):.0f} px wide")
    return "; ".join(entries)
