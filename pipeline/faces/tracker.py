"""Frame -> FrameFaces: finds faces and follows them; and the same for one picture.

A face is followed from where it was: the mesh net's crop lies where the last frame's points were.
The detector looks at the whole picture only when nothing is followed, when a face was lost, after
a cut, and now and then for new faces: by the seconds of the film, not by frames.
"""

import math
from dataclasses import dataclass, field, replace
from fractions import Fraction
from functools import cache

import cv2
import numpy as np
from makeup_video.pipeline.crop import FramePicture, Picture, RgbPicture, check_rgb8
from makeup_video.pipeline.cut import CutDetector
from makeup_video.pipeline.face import Face, FrameFaces
from makeup_video.pipeline.face_nets import FaceNets
from makeup_video.pipeline.frame import Frame
from makeup_video.pipeline.motion import MeasureMotion
from makeup_video.pipeline.sighting import (
    Sighting,
    carry,
    detect,
    expected_frame,
    is_same,
    is_tiny,
    sight,
    sight_again,
    to_face,
)
from makeup_video.pipeline.similarity import Similarity, distance, iod_of, middle_of

# For most faces, for crowds, and for one that fills the frame.
DETECTOR_SIDES_PX = (256, 512, 128)
BESIDE_SIDES_PX = (320,)  # for others beside a face that is followed: smaller ones than that
TILTS_DEGREES = (-40, 40)  # the picture is turned by so much when no face was found
STILL_WIDE_ENOUGH = 0.85  # of the least width: a followed face may be a little narrower
MAX_FACES = 32  # bounds the time of a frame
LOOK_SECONDS = 0.24  # between two looks for new faces
SEARCH_SECONDS = 0.08  # the same while there is none at all, or one was lost a moment ago
# The same two on a machine that is too slow: see FindFaces.level.
SLOW_LOOK_SECONDS, SLOW_SEARCH_SECONDS = 1.0, 0.32
# A face that returns near its place within this keeps its number; so does whoever comes instead.
REMEMBER_SECONDS = 2.0
SETTLED_SECONDS = 0.5
RETURN_REACH = 1.5  # IOD
_ALIKE = 0.97  # of the width of the largest
_INVISIBLE = 1 / 512  # half a code value of 8 bits


@dataclass(slots=True)
class _Track:
    """A face that is followed, or was a moment ago."""

    track_id: int
    sighting: Sighting
    last_seen_seconds: float
    is_followed: bool = True
    # Where it would be looked for after a loss. Who walks in front makes a face seem to shrink
    # before it is lost, so a new size must last for a while before it counts.
    place: Similarity = field(init=False)
    place_seconds: float = field(init=False)
    speed: complex = 0j  # px a second

    def __post_init__(self) -> None:
        self.place, self.place_seconds = self.sighting.frame, self.last_seen_seconds

    def see(self, sighting: Sighting, seconds: float) -> None:
        """Take what was found now."""
        self.sighting, self.last_seen_seconds, self.is_followed = sighting, seconds, True
        ratio = iod_of(sighting.frame) / iod_of(self.place)
        since = seconds - self.place_seconds
        if 0.87 < ratio < 1.15 or not 0 <= since < SETTLED_SECONDS:
            moved = middle_of(sighting.frame) - middle_of(self.place)
            speed = moved / since if 0 < since < SETTLED_SECONDS else 0j
            self.speed += 0.5 * (speed - self.speed)
            self.place, self.place_seconds = sighting.frame, seconds

    def off(self, frame: Similarity, seconds: float) -> float:
        """How far a face is from where this one was, or would be by now: see `distance`."""
        gone = self.speed * (seconds - self.place_seconds)
        there = Similarity(self.place.turn, self.place.shift + gone)
        return min(distance(frame, self.place), distance(frame, there))


class FindFaces:
    """Frame -> FrameFaces; keeps what it follows from frame to frame.

    pixel_aspect: the stream's sample aspect ratio. tiny_faces: how many faces were left alone
    because they are too small, counted once a look. frames_with_face, faces: how many so far.
    level: as Budget has it, set between two frames. From 1 on new faces are looked for less often;
    from 2 on the nets read each face in every second frame, and in between it is carried along by
    its measured motion, where that is sure.
    """

    def __init__(self, pixel_aspect: Fraction | float = 1, nets: FaceNets | None = None) -> None:
        self.pixel_aspect = pixel_aspect
        self.nets = nets or load_nets()
        self.level = 0
        self.tiny_faces = 0
        self.frames_with_face = 0
        self._is_cut = CutDetector()
        self._tracks: list[_Track] = []
        self._next_id = 0
        self._last_look_seconds = -math.inf
        self._looks = -1
        self._frames = 0
        self._motion = MeasureMotion()

    def __call__(self, frame: Frame) -> FrameFaces:
        picture = FramePicture(frame, self.pixel_aspect)
        seconds = frame.seconds
        self._frames += 1
        cut = self._is_cut(frame.planes[0], frame.bit_depth)
        if cut:
            self._tracks.clear()
        is_time = self._is_time_to_look(seconds)
        lost = self._follow(picture, seconds, doubtfully=is_time and self._looks % 2 == 0)
        if cut or lost:
            self._look(picture, seconds, DETECTOR_SIDES_PX)
        elif is_time:
            self._looks += 1
            if self._followed():
                self._look(picture, seconds, BESIDE_SIDES_PX)
            else:
                side_px = DETECTOR_SIDES_PX[self._looks % len(DETECTOR_SIDES_PX)]
                tilts = (0, 0, *TILTS_DEGREES)
                tilt_degrees = tilts[self._looks // len(DETECTOR_SIDES_PX) % len(tilts)]
                self._look(picture, seconds, (side_px,), tilt_degrees)
        self._tracks = [t for t in self._tracks if t.is_followed or _is_fresh(t, seconds)]
        faces = [to_face(t.sighting, picture, t.track_id) for t in self._tracks if t.is_followed]
        found = FrameFaces(frame, _largest_first(faces), cut)
        self.frames_with_face += bool(found.faces)
        return found

    @property
    def faces(self) -> int:
        return self._next_id

    def _followed(self) -> list[_Track]:
        return [track for track in self._tracks if track.is_followed]

    def _follow(self, picture: FramePicture, seconds: float, doubtfully: bool) -> bool:
        """Find every followed face again; True when one was lost."""
        followed = self._followed()
        for track in followed:
            found = None if doubtfully else self._carried(picture, track)
            if found is None:
                found = sight_again(self.nets, picture, track.sighting, seconds, doubtfully)
                self._remember(picture, track, found)
            if found is None:
                track.is_followed = False
            else:
                track.see(found, seconds)
            if found and is_tiny(found.frame, STILL_WIDE_ENOUGH):
                track.is_followed = False
                self.tiny_faces += 1
        kept: list[_Track] = []
        for track in sorted(self._followed(), key=lambda t: t.track_id):
            if any(is_same(track.sighting.frame, other.sighting.frame) for other in kept):
                track.is_followed = False  # it slid onto a face that an older track follows
            else:
                kept.append(track)
        return len(kept) < len(followed)

    def _carried(self, picture: FramePicture, track: _Track) -> Sighting | None:
        """A face by its measured motion; None when it is the nets' turn, or that is not sure."""
        before = track.sighting
        if before.still is None or not self._is_between(track, self._frames):
            return None
        motion = self._motion(before.still, self._motion.still(picture, expected_frame(before)))
        return None if motion is None else carry(self.nets, before, motion)

    def _remember(self, picture: FramePicture, track: _Track, found: Sighting | None) -> None:
        """Keep what is seen, when the next frame's motion is measured against it."""
        if found is not None and self._is_between(track, self._frames + 1):
            found.still = self._motion.still(picture, found.frame)

    def _is_between(self, track: _Track, frame: int) -> bool:
        """Of two faces one is read in even frames, the other in odd ones."""
        return self.level >= 2 and (frame + track.track_id) % 2 == 1

    def _is_time_to_look(self, seconds: float) -> bool:
        missing = any(
            not t.is_followed and seconds - t.last_seen_seconds < SETTLED_SECONDS
            for t in self._tracks
        )
        look, search = LOOK_SECONDS, SEARCH_SECONDS
        if self.level >= 1:
            look, search = SLOW_LOOK_SECONDS, SLOW_SEARCH_SECONDS
        wait = look if self._followed() and not missing else search
        # a clock that jumps back (a stream that starts again) must not blind us
        return not 0 <= seconds - self._last_look_seconds < wait - 1e-6

    def _look(
        self, picture: Picture, seconds: float, sides_px: tuple[int, ...], tilt_degrees: float = 0
    ) -> None:
        """Start to follow what the detector finds and nobody follows yet."""
        self._last_look_seconds = seconds
        for guess in detect(self.nets, picture, sides_px, tilt_degrees):
            known = self._followed()
            if len(known) >= MAX_FACES:
                break
            if any(is_same(guess, track.sighting.frame) for track in known):
                continue
            found = sight(self.nets, picture, guess)
            if found is None or any(is_same(found.frame, t.sighting.frame) for t in known):
                continue
            if is_tiny(found.frame):
                self.tiny_faces += 1
                continue
            self._start(found, seconds)

    def _start(self, found: Sighting, seconds: float) -> None:
        """Follow a face: one that was lost a moment ago, or a new one."""
        size = iod_of(found.frame)
        lost = [t for t in self._tracks if not t.is_followed and 0.5 < size / iod_of(t.place) < 2]
        nearest = min(lost, key=lambda track: track.off(found.frame, seconds), default=None)
        if nearest is not None and nearest.off(found.frame, seconds) < RETURN_REACH:
            nearest.see(found, seconds)
        else:
            self._tracks.append(_Track(self._next_id, found, seconds))
            self._next_id += 1


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
    found: list[Sighting] = []
    tiny: list[Sighting] = []
    for tilt_degrees in (0, *TILTS_DEGREES):
        for guess in detect(nets, picture, DETECTOR_SIDES_PX, tilt_degrees):
            if len(found) >= MAX_FACES:
                break
            if any(is_same(guess, other.frame) for other in (*found, *tiny)):
                continue
            one = sight(nets, picture, guess, carefully=True)
            if one and not any(is_same(one.frame, other.frame) for other in (*found, *tiny)):
                (tiny if is_tiny(one.frame) else found).append(one)
        if found or tiny:
            break
    faces = _in_order([to_face(one, picture, 0) for one in found])
    # numbered by size: the same numbers however sure the nets are, and wherever it is stored
    return tuple(replace(face, track_id=at) for at, face in enumerate(faces)), len(tiny)


def lip_mask(rgb8: np.ndarray, face: Face) -> np.ndarray:
    """Weight of lipstick at every pixel: 1 on the lips, 0 beyond the feather.

    rgb8 is (H, W, 3) uint8, encoded: the picture that `face` was found in. Returns (H, W) float32
    in [0, 1]. The mouth opening is 0, so teeth keep their colour; so is a hand in front of the
    lips. All zeros when the mouth is hidden (`mouth_visible`), and when the lips lie outside the
    picture. Raises ValueError for another shape.
    """
    check_rgb8(rgb8)
    size = np.array(rgb8.shape[1::-1])
    mask = np.zeros(rgb8.shape[:2], np.float32)
    h, w = face.lips.logits.shape
    corners = face.lips.to_px @ np.array([[0, w, 0, w], [0, 0, h, h], [1, 1, 1, 1]])
    x0, y0 = np.clip(np.floor(corners.min(1)) - 2, 0, size).astype(int)
    x1, y1 = np.clip(np.ceil(corners.max(1)) + 2, 0, size).astype(int)
    if x1 > x0 and y1 > y0:
        mask[y0:y1, x0:x1] = lip_mask_window(face, (x0, y0), (int(x1 - x0), int(y1 - y0)))
    return mask


def lip_mask_window(face: Face, origin_xy: tuple[int, int], size_wh: tuple[int, int]) -> np.ndarray:
    """The same in a window of the picture that begins at origin_xy: (H, W) float32 in [0, 1]."""
    to_window = face.lips.to_px.copy()
    to_window[:, 2] -= origin_xy
    # logits are spread rather than weights: where they cross zero is the border at any scale
    logits = cv2.warpAffine(
        face.lips.logits, to_window, size_wh, flags=cv2.INTER_CUBIC,
        borderMode=cv2.BORDER_CONSTANT, borderValue=-30,
    )  # fmt: skip
    weight: np.ndarray = 1 / (1 + np.exp(-logits.clip(-30, 30)))
    weight *= face.mouth_weight
    weight[weight < _INVISIBLE] = 0
    return weight.astype(np.float32, copy=False)


@cache
def load_nets() -> FaceNets:
    """The nets of this process, loaded at first use. Raises InstallError."""
    return FaceNets()


def _largest_first(faces: list[Face]) -> tuple[Face, ...]:
    if len(faces) > 1:
        faces = sorted(faces, key=lambda face: -face.area_px2)
    return tuple(faces)


def _in_order(faces: list[Face]) -> tuple[Face, ...]:
    """Largest first. Of faces about as large as each other, which one measures larger changes with a
    picture's least detail: those go from left to right, and from top to bottom."""
    rest, ordered = _largest_first(faces), []
    while rest:
        alike = [face for face in rest if face.area_px2 > _ALIKE**2 * rest[0].area_px2]
        ordered += sorted(alike, key=lambda face: float(face.points_px[:, :2].mean(0) @ (3, 1)))
        rest = rest[len(alike) :]
    return tuple(ordered)


def _is_fresh(track: _Track, seconds: float) -> bool:
    return 0 <= seconds - track.last_seen_seconds < REMEMBER_SECONDS
