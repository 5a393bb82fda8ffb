"""Frame -> FrameFaces: finds faces and follows them from frame to frame."""

import math
from dataclasses import dataclass, field
from fractions import Fraction

from makeup_video.pipeline.engine.quality import QualityLevel
from makeup_video.pipeline.faces.face import FrameFaces
from makeup_video.pipeline.faces.find import (
    DETECTOR_SIDES_PX,
    MAX_FACES,
    TILTS_DEGREES,
    largest_first,
)
from makeup_video.pipeline.faces.landmarks import (
    FaceLandmarks,
    carry,
    detect,
    expected_frame,
    is_same,
    is_tiny,
    locate,
    relocate,
    to_face,
)
from makeup_video.pipeline.faces.nets import FaceNets, load_nets
from makeup_video.pipeline.faces.optical_flow import MeasureMotion
from makeup_video.pipeline.faces.similarity import Similarity, distance, iod_of, middle_of
from makeup_video.pipeline.frames.frame import Frame
from makeup_video.pipeline.frames.scene_cut import CutDetector
from makeup_video.pipeline.frames.views import FramePicture, Picture

BESIDE_SIDES_PX = (320,)  # for others beside a face that is followed: smaller ones than that
STILL_WIDE_ENOUGH = 0.85  # of the least width: a followed face may be a little narrower
LOOK_SECONDS = 0.24  # between two looks for new faces
SEARCH_SECONDS = 0.08  # the same while there is none at all, or one was lost a moment ago
# The same two on a machine that is too slow: see FindFaces.level.
SLOW_LOOK_SECONDS, SLOW_SEARCH_SECONDS = 1.0, 0.32
# A face that returns near its place within this keeps its number; so does whoever comes instead.
REMEMBER_SECONDS = 2.0
SETTLED_SECONDS = 0.5
RETURN_REACH = 1.5  # IOD


@dataclass(slots=True)
class _Track:
    """A face that is followed, or was a moment ago."""

    track_id: int
    sighting: FaceLandmarks
    last_seen_seconds: float
    is_followed: bool = True
    # Where it would be looked for after a loss. Who walks in front makes a face seem to shrink
    # before it is lost, so a new size must last for a while before it counts.
    place: Similarity = field(init=False)
    place_seconds: float = field(init=False)
    speed: complex = 0j  # px a second

    def __post_init__(self) -> None:
        self.place, self.place_seconds = self.sighting.frame, self.last_seen_seconds

    def see(self, sighting: FaceLandmarks, seconds: float) -> None:
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
    level: may be set between two frames. At SIMPLER_TRACKING the nets read each face in every second
    frame, and in between it is carried along by its measured motion, where that is sure.
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
        found = FrameFaces(frame, largest_first(faces), cut)
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
                found = relocate(self.nets, picture, track.sighting, seconds, doubtfully)
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

    def _carried(self, picture: FramePicture, track: _Track) -> FaceLandmarks | None:
        """A face by its measured motion; None when it is the nets' turn, or that is not sure."""
        before = track.sighting
        if before.still is None or not self._is_between(track, self._frames):
            return None
        motion = self._motion(before.still, self._motion.still(picture, expected_frame(before)))
        return None if motion is None else carry(self.nets, before, motion)

    def _remember(self, picture: FramePicture, track: _Track, found: FaceLandmarks | None) -> None:
        """Keep what is seen, when the next frame's motion is measured against it."""
        if found is not None and self._is_between(track, self._frames + 1):
            found.still = self._motion.still(picture, found.frame)

    def _is_between(self, track: _Track, frame: int) -> bool:
        """Of two faces one is read in even frames, the other in odd ones."""
        return self.level >= QualityLevel.SIMPLER_TRACKING and (frame + track.track_id) % 2 == 1

    def _is_time_to_look(self, seconds: float) -> bool:
        missing = any(
            not t.is_followed and seconds - t.last_seen_seconds < SETTLED_SECONDS
            for t in self._tracks
        )
        look, search = LOOK_SECONDS, SEARCH_SECONDS
        if self.level >= QualityLevel.FEWER_DETECTIONS:
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
            found = locate(self.nets, picture, guess)
            if found is None or any(is_same(found.frame, t.sighting.frame) for t in known):
                continue
            if is_tiny(found.frame):
                self.tiny_faces += 1
                continue
            self._start(found, seconds)

    def _start(self, found: FaceLandmarks, seconds: float) -> None:
        """Follow a face: one that was lost a moment ago, or a new one."""
        size = iod_of(found.frame)
        lost = [t for t in self._tracks if not t.is_followed and 0.5 < size / iod_of(t.place) < 2]
        nearest = min(lost, key=lambda track: track.off(found.frame, seconds), default=None)
        if nearest is not None and nearest.off(found.frame, seconds) < RETURN_REACH:
            nearest.see(found, seconds)
        else:
            self._tracks.append(_Track(self._next_id, found, seconds))
            self._next_id += 1


def _is_fresh(track: _Track, seconds: float) -> bool:
    return 0 <= seconds - track.last_seen_seconds < REMEMBER_SECONDS
