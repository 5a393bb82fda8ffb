"""Face, its lip patch, and the faces of one frame."""

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
from makeup_video.pipeline.faces.topology import EYE_CORNERS
from makeup_video.pipeline.frames.affine import AffineArray, compose
from makeup_video.pipeline.frames.frame import Frame

POINTS = 478  # MediaPipe's Face Mesh order, irises included
PATCH_SPAN = 0.88  # least width of a lip patch in IOD; the lip net's training ended at 0.96
MIN_FACE_PX = 40  # width; smaller faces are not painted
_FURTHEST_PX = 1e6  # from the picture's corner: no picture reaches this far
# Up to the first mouth_visible no lipstick is painted, from the second on all of it. Medical masks
# score under 0.1 (549 of 571 under 0.2), mouths over 0.9 (727 of 735). Hands and microphones in
# front of the mouth score in between.
_MOUTH_SEEN = 0.4, 0.8
_FIND = "find_faces(picture) returns the faces of a picture"


@dataclass(frozen=True, slots=True, eq=False)
class LipPatch:
    """Where lipstick goes, on a small crop around the lips that is turned with the face.

    logits: (80, 112) float32, log-odds of lipstick at each pixel of the crop.
    to_px: (2, 3) float64, crop px (x, y, 1) -> picture px.
    span: the width of the crop in IOD, which is more for a wide or open mouth.
    """

    logits: np.ndarray
    to_px: np.ndarray
    span: float = PATCH_SPAN

    def __post_init__(self) -> None:
        if self.logits.ndim != 2 or self.to_px.shape != (2, 3):
            raise ValueError(
                "a lip patch has (H, W) logits and a (2, 3) matrix, got "
                f"{self.logits.shape} and {self.to_px.shape}"
            )


@dataclass(frozen=True, slots=True, eq=False)
class Face:
    """One face of a picture.

    points_px: (478, 3) float32: x, y in pixels of the stored picture (pixel centres at whole
    numbers), z in the same unit, smaller is nearer; MediaPipe's Face Mesh order.
    score: the probability that this is a face. mouth_visible: the probability that its mouth is
    visible.
    track_id: the number of the face, the same in all frames; in a single picture 0, 1, ... by size,
    the largest first, equally large ones from left to right.
    lips: where lipstick goes in this very picture.
    """

    points_px: np.ndarray
    score: float
    mouth_visible: float
    track_id: int
    lips: LipPatch

    def __post_init__(self) -> None:
        points = self.points_px
        is_array = isinstance(points, np.ndarray)
        if not is_array or points.shape != (POINTS, 3) or points.dtype != np.float32:
            got = f"{points.shape} {points.dtype}" if is_array else type(points).__name__
            raise ValueError(f"points_px must be an array, ({POINTS}, 3) float32, got {got}")

    @property
    def mouth_weight(self) -> float:
        """The share of lipstick to paint: 0 for a hidden mouth, 1 for a visible one."""
        hidden, seen = _MOUTH_SEEN
        return min(max((self.mouth_visible - hidden) / (seen - hidden), 0.0), 1.0)

    @property
    def area_px2(self) -> float:
        """The area of the box around the points."""
        x, y, _ = self.points_px.T
        return float(x.max() - x.min()) * float(y.max() - y.min())

    def __repr__(self) -> str:
        x, y = self.points_px[:, :2].mean(0)
        return (
            f"Face({self.track_id} at ({x:.0f}, {y:.0f}), score={self.score:.2f}, "
            f"mouth_visible={self.mouth_visible:.2f})"
        )


@dataclass(frozen=True, slots=True, eq=False)
class FrameFaces:
    """A frame and the faces in it, largest first; a frame may have no face.

    cut: the scene changes at this frame, so nothing known of earlier faces still holds.
    """

    frame: Frame
    faces: tuple[Face, ...] = ()
    cut: bool = False


def with_faces(item: FrameFaces, faces: tuple[Face, ...]) -> FrameFaces:
    """The same frame with other faces."""
    return FrameFaces(item.frame, faces, item.cut)


def moved(face: Face, to_new: AffineArray) -> Face:
    """The face in a picture that was scaled and cropped.

    to_new: (2, 3), px (x, y, 1) of the old picture -> px of the new one.
    """
    scale = abs(np.linalg.det(to_new[:, :2])) ** 0.5
    points = np.empty_like(face.points_px)
    points[:, :2] = face.points_px[:, :2] @ to_new[:, :2].T + to_new[:, 2]
    points[:, 2] = face.points_px[:, 2] * scale
    lips = replace(face.lips, to_px=compose(to_new, face.lips.to_px))
    return replace(face, points_px=points, lips=lips)


def resized(face: Face, across: float, down: float) -> Face:
    """The face in a picture whose width and height were scaled by `across` and `down`.

    Pixel centres lie at whole numbers.
    """
    to_new = [[across, 0, 0.5 * across - 0.5], [0, down, 0.5 * down - 0.5]]
    return moved(face, np.array(to_new))


def iod_px(face: Face) -> float:
    """The distance of the outer eye corners in px, at least 1."""
    (x0, y0, _), (x1, y1, _) = face.points_px.take(EYE_CORNERS, 0).tolist()
    return max(math.dist((x0, y0), (x1, y1)), 1.0)


def check_faces(faces: Iterable[Face]) -> tuple[Face, ...]:
    """The faces as a tuple, each only once: a repeated face would be painted twice.

    Raises TypeError for anything but faces, and for a single Face that is not in a list.
    """
    if isinstance(faces, Face):
        raise TypeError("faces must be a list of faces, got one Face: give [face]")
    if not isinstance(faces, Iterable):
        raise TypeError(f"faces must be a list of faces, got {type(faces).__name__}: {_FIND}")
    found = tuple(faces)
    for face in found:
        check_face_type(face)
    return tuple({id(face): face for face in found}.values())


def check_face_type(face: object) -> None:
    """Raises TypeError for anything but one face."""
    if not isinstance(face, Face):
        is_list = isinstance(face, tuple | list)
        how = "give one of them, such as faces[0]" if is_list else _FIND
        raise TypeError(f"a face must be a Face, got {type(face).__name__}: {how}")


def sound_faces(item: FrameFaces) -> tuple[Face, ...]:
    """The faces that can be painted.

    A face is left out when a number is not finite, since one NaN would spread through the
    smoothing, or is larger than any picture.
    """
    return tuple(face for face in item.faces if is_sound(face))


def is_sound(face: Face) -> bool:
    """True for a face whose numbers are finite and not larger than any picture."""
    across, down = face.lips.to_px.tolist()
    numbers = face.score, face.mouth_visible, *across, *down
    is_near = max(map(abs, numbers)) < _FURTHEST_PX and math.isfinite(sum(numbers))
    is_finite = is_near and math.isfinite(float(face.lips.logits.sum()))
    return is_finite and float(np.abs(face.points_px).max()) < _FURTHEST_PX  # False for NaN
