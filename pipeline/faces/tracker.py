"""Frame -> FrameFaces: finds faces and follows them from frame to frame.

A face is followed from where it was: the nets' crops lie where its points were in the last frame.
The detector searches the whole picture only when no face is followed, when a face was lost, after a
cut, and now and then for new faces. It seldom searches for faces that are small in a large picture.
The searches are timed by the video's seconds, not by a count of frames.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from fractions import Fraction

from makeup_video.pipeline.engine.quality import QualityLevel
from makeup_video.pipeline.faces.face import FrameFaces
from makeup_video.pipeline.faces.find import (
    DETECTOR_SIDES_PX,
    MAX_FACES,
    TILTS_DEGREES,
    fine_sides,
    in_order,
    largest_first,
    new_faces,
)
from makeup_video.pipeline.faces.follow import carry, expected_pose, relocate
from makeup_video.pipeline.faces.landmarks import (
    FaceLandmarks,
    detect,
    is_same,
    is_tiny,
    to_face,
)
from makeup_video.pipeline.faces.matching import match
from makeup_video.pipeline.faces.nets import FaceNets, load_nets
from makeup_video.pipeline.faces.optical_flow import MeasureMotion
from makeup_video.pipeline.faces.similarity import Similarity, distance, iod_of, middle_of
from makeup_video.pipeline.frames.clock import is_new_slot, slot
from makeup_video.pipeline.frames.frame import Frame
from makeup_video.pipeline.frames.scene_cut import CutDetector
from makeup_video.pipeline.frames.views import FramePicture, Picture

# The longer side of the detector's input while a face is followed: other faces are smaller.
BESIDE_SIDES_PX = (320,)
STILL_WIDE_ENOUGH = 0.85  # share of the least width: a followed face may be a little narrower
DETECT_SECONDS = 0.24  # length of the slots of time: each has one search for new faces
SEARCH_SECONDS = 0.08  # the same while no face is followed, or one was lost a moment ago
FINE_SECONDS = 4.0  # the same for small faces in a large picture: such a search takes 20 ms
# DETECT_SECONDS and SEARCH_SECONDS on a machine that is too slow: see FindFaces.level.
SLOW_DETECT_SECONDS, SLOW_SEARCH_SECONDS = 1.0, 0.32
# A face that reappears near its place within this time keeps its number, even if it is another
# person.
REMEMBER_SECONDS = 2.0
SETTLED_SECONDS = 0.5  # how long a face must keep a new size before the track takes it over
RETURN_REACH = 1.5  # how far off a lost face may reappear: see `distance`
# Ratios of a face's size to its settled size, chosen by eye. Within the first range, the size is
# the same; outside the second, it is another face.
_KEPT_SIZE, _OTHER_SIZE = (0.87, 1.15), (0.5, 2)
_SPEED_SHARE = 0.5  # weight of the newest speed in a track's speed
# While no face is followed, every second round of the input sizes searches the picture upright.
_SEARCHED_DEGREES = tuple(degrees for tilt in TILTS_DEGREES for degrees in (0, tilt))


@dataclass(slots=True)
class _Track:
    """A face that is followed, or was lost a moment ago.

    settled_pose: where the face is expected to reappear after a loss. A person who walks in front
    makes a face seem to shrink before it is lost, so a new size must last before it counts.
    """

    track_id: int
    landmarks: FaceLandmarks
    last_seconds: float
    is_followed: bool = True
    settled_pose: Similarity = field(init=False)
    settled_seconds: float = field(init=False)
    speed: complex = 0j  # px a second

    def __post_init__(self) -> None:
        self.settled_pose, self.settled_seconds = self.landmarks.pose, self.last_seconds

    def update(self, landmarks: FaceLandmarks, seconds: float) -> None:
        """Take over the landmarks found now."""
        self.landmarks, self.last_seconds, self.is_followed = landmarks, seconds, True
        ratio = iod_of(landmarks.pose) / iod_of(self.settled_pose)
        since = seconds - self.settled_seconds
        low, high = _KEPT_SIZE
        if low < ratio < high or not 0 <= since < SETTLED_SECONDS:
            moved = middle_of(landmarks.pose) - middle_of(self.settled_pose)
            speed = moved / since if 0 < since < SETTLED_SECONDS else 0j
            self.speed += _SPEED_SHARE * (speed - self.speed)
            self.settled_pose, self.settled_seconds = landmarks.pose, seconds

    def distance_to(self, pose: Similarity, seconds: float) -> float:
        """How far a pose is from where this face was, or would be by now: see `distance`.

        Infinite for a face of another size.
        """
        low, high = _OTHER_SIZE
        if not low < iod_of(pose) / iod_of(self.settled_pose) < high:
            return math.inf
        turn, shift = self.settled_pose
        moved = Similarity(turn, shift + self.speed * (seconds - self.settled_seconds))
        return min(distance(pose, self.settled_pose), distance(pose, moved))


class FindFaces:
    """Frame -> FrameFaces; follows faces from frame to frame.

    pixel_aspect: the stream's sample aspect ratio.
    level: a QualityLevel, which may be set between two frames. From FEWER_DETECTIONS on the
    detector runs less often. From SIMPLER_TRACKING on the nets read each face in every second
    frame; in between, the face moves by its measured motion, where that is reliable.
    tiny_faces: how often a face was left out as too small; the same face counts in every search.
    frames_with_face: how many frames had a face. faces: how many tracks there were.
    """

    def __init__(self, pixel_aspect: Fraction | float = 1, nets: FaceNets | None = None) -> None:
        self.pixel_aspect = pixel_aspect
        self.nets = nets or load_nets()
        self.level = QualityLevel.FULL
        self.tiny_faces = 0
        self.frames_with_face = 0
        self._is_cut = CutDetector()
        self._tracks: list[_Track] = []
        self._next_id = 0
        self._last_detection_seconds = -math.inf
        self._last_fine_seconds = -math.inf
        self._last_begin_seconds = -math.inf
        self._detections = -1
        self._frames = 0
        self._motion = MeasureMotion()

    def __call__(self, frame: Frame) -> FrameFaces:
        """The faces of the next frame. Raises TypeError for anything but a Frame."""
        if not isinstance(frame, Frame):
            got = type(frame).__name__
            raise TypeError(f"frame must be a Frame, got {got}: a Painter finds faces in arrays")
        picture = FramePicture(frame, self.pixel_aspect)
        seconds = frame.seconds
        self._frames += 1
        cut = self._is_cut(frame.planes[0], frame.bit_depth)
        if cut:
            self._tracks.clear()
        is_due = self._detection_is_due(seconds)
        lost = self._follow(
            picture, seconds, verify=is_due and slot(seconds, DETECT_SECONDS) % 2 == 0
        )
        begins = self._frames == 1 or self._scene_begins(seconds)
        is_new = cut or (begins and not self._followed())
        if is_new and self.level < QualityLevel.FEWER_DETECTIONS:
            self._search_everywhere(picture, seconds, TILTS_DEGREES if begins else ())
        elif cut or lost:
            self._detect(picture, seconds, DETECTOR_SIDES_PX)
        elif is_due and self._fine_is_due(picture, seconds):
            self._last_fine_seconds = seconds
            self._detect(picture, seconds, fine_sides(picture))
        elif is_due:
            self._search(picture, seconds)
        self._tracks = [t for t in self._tracks if t.is_followed or _is_fresh(t, seconds)]
        faces = [to_face(t.landmarks, picture, t.track_id) for t in self._tracks if t.is_followed]
        found = FrameFaces(frame, largest_first(faces), cut)
        self.frames_with_face += bool(found.faces)
        return found

    @property
    def faces(self) -> int:
        """How many tracks there were so far."""
        return self._next_id

    def _followed(self) -> list[_Track]:
        return [track for track in self._tracks if track.is_followed]

    def _follow(self, picture: FramePicture, seconds: float, verify: bool) -> bool:
        """Relocate every followed face; True when one was lost."""
        followed = self._followed()
        for track in followed:
            found = None if verify else self._carried(picture, track)
            if found is None:
                found = relocate(self.nets, picture, track.landmarks, seconds, verify)
                self._keep_luma(picture, track, found)
            if found is None:
                track.is_followed = False
            else:
                track.update(found, seconds)
            if found and is_tiny(found.pose, STILL_WIDE_ENOUGH):
                track.is_followed = False
                self.tiny_faces += 1
        kept: list[_Track] = []
        for track in sorted(self._followed(), key=lambda t: t.track_id):
            if any(is_same(track.landmarks.pose, other.landmarks.pose) for other in kept):
                track.is_followed = False  # it drifted onto the face of an older track
            else:
                kept.append(track)
        return len(kept) < len(followed)

    def _carried(self, picture: FramePicture, track: _Track) -> FaceLandmarks | None:
        """The face, moved by its measured motion; None when the nets must read the face."""
        before = track.landmarks
        if before.luma is None or not self._is_between(track, self._frames):
            return None
        motion = self._motion(before.luma, self._motion.crop(picture, expected_pose(before)))
        return None if motion is None else carry(self.nets, before, motion)

    def _keep_luma(self, picture: FramePicture, track: _Track, found: FaceLandmarks | None) -> None:
        """Keep the luma of the face, if the motion to the next frame will be measured."""
        if found is not None and self._is_between(track, self._frames + 1):
            found.luma = self._motion.crop(picture, found.pose)

    def _is_between(self, track: _Track, index: int) -> bool:
        """True when a track is not read in the frame of this index.

        Even tracks are read in even frames, odd tracks in odd ones: this spreads the work evenly.
        """
        return self.level >= QualityLevel.SIMPLER_TRACKING and (index + track.track_id) % 2 == 1

    def _detection_is_due(self, seconds: float) -> bool:
        missing = any(
            not t.is_followed and seconds - t.last_seconds < SETTLED_SECONDS for t in self._tracks
        )
        wait, search = DETECT_SECONDS, SEARCH_SECONDS
        if self.level >= QualityLevel.FEWER_DETECTIONS:
            wait, search = SLOW_DETECT_SECONDS, SLOW_SEARCH_SECONDS
        if missing or not self._followed():
            wait = search
        return is_new_slot(seconds, self._last_detection_seconds, wait)

    def _scene_begins(self, seconds: float) -> bool:
        """True in the first frame that is not flat, but not at each flash of a stroboscope."""
        if not self._is_cut.begins or not is_new_slot(
            seconds, self._last_begin_seconds, DETECT_SECONDS
        ):
            return False
        self._last_begin_seconds = seconds
        return True

    def _search_everywhere(
        self, picture: Picture, seconds: float, tilts_degrees: tuple[float, ...]
    ) -> None:
        """Search a new scene at every input size; also turned, if no upright face was found."""
        self._last_fine_seconds = seconds
        tiny = self._detect(picture, seconds, (*DETECTOR_SIDES_PX, *fine_sides(picture)))
        for tilt_degrees in tilts_degrees:
            if not self._followed():
                tiny += self._detect(picture, seconds, DETECTOR_SIDES_PX, tilt_degrees, tiny)

    def _fine_is_due(self, picture: Picture, seconds: float) -> bool:
        is_new = is_new_slot(seconds, self._last_fine_seconds, FINE_SECONDS)
        return is_new and self.level < QualityLevel.FEWER_DETECTIONS and bool(fine_sides(picture))

    def _search(self, picture: Picture, seconds: float) -> None:
        """Search beside followed faces, or without any, with the next input size and tilt."""
        self._detections += 1
        if self._followed():
            self._detect(picture, seconds, BESIDE_SIDES_PX)
            return
        side_px = DETECTOR_SIDES_PX[self._detections % len(DETECTOR_SIDES_PX)]
        turn = self._detections // len(DETECTOR_SIDES_PX)
        tilt_degrees = _SEARCHED_DEGREES[turn % len(_SEARCHED_DEGREES)]
        self._detect(picture, seconds, (side_px,), tilt_degrees)

    def _detect(
        self,
        picture: Picture,
        seconds: float,
        sides_px: tuple[int, ...],
        tilt_degrees: float = 0,
        known_tiny: Sequence[Similarity] = (),
    ) -> list[Similarity]:
        """Start to follow the faces that the detector finds and that no track follows yet.

        Returns the poses of the faces that are too small. known_tiny: such poses that this search
        has already found.
        """
        self._last_detection_seconds = seconds
        poses = [track.landmarks.pose for track in self._followed()]
        started: list[FaceLandmarks] = []
        tiny: list[Similarity] = []
        if len(poses) >= MAX_FACES:
            return tiny
        detections = detect(self.nets, picture, sides_px, tilt_degrees)
        for found in new_faces(self.nets, picture, detections, (*poses, *known_tiny)):
            if is_tiny(found.pose):
                tiny.append(found.pose)
                continue
            started.append(found)
            if len(poses) + len(started) >= MAX_FACES:
                break
        self.tiny_faces += len(tiny)
        self._start(in_order(started), seconds)
        return tiny

    def _start(self, faces: list[FaceLandmarks], seconds: float) -> None:
        """Follow faces on tracks that were lost a moment ago, or on new tracks in the order given.

        The tracks are chosen for all faces of a detection at once. One by one, a face could take
        the track of a neighbour that comes later.
        """
        lost = [track for track in self._tracks if not track.is_followed]
        distances = [[track.distance_to(face.pose, seconds) for track in lost] for face in faces]
        for face, index in zip(faces, match(distances, RETURN_REACH), strict=True):
            if index is not None:
                lost[index].update(face, seconds)
            else:
                self._tracks.append(_Track(self._next_id, face, seconds))
                self._next_id += 1


def _is_fresh(track: _Track, seconds: float) -> bool:
    return 0 <= seconds - track.last_seconds < REMEMBER_SECONDS
