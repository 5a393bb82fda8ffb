"""The stages of one segment: the run-up settles them; only the segment's frames leave the last."""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

from makeup_video.pipeline.engine.runner import Stage
from makeup_video.pipeline.faces.face import FrameFaces
from makeup_video.pipeline.faces.tracker import FindFaces
from makeup_video.pipeline.frames.frame import Frame
from makeup_video.pipeline.media.segments import Segment
from makeup_video.pipeline.offline.face_numbers import KnownFaces, Sighting, sightings_in
from makeup_video.pipeline.render.composite import Composite
from makeup_video.pipeline.render.scene import FaceScene, FrameScene

_SETTLE_SECONDS = 0.2  # longer than painting keeps a surface: see regions' `kept`


class SegmentFaces:
    """Frame -> FrameFaces. Counts the faces of the segment's own frames.

    seen_again_from: time, in ticks of the source, from which the next segment sees the frames, too;
    None: it never does.
    before, after: what was seen in the run-up, and from `seen_again_from` on.
    numbers: of all faces in the segment's own frames, in order of appearance.
    """

    def __init__(self, find: FindFaces, segment: Segment, seen_again_from: int | None) -> None:
        self._find, self._segment = find, segment
        self._seen_again_from = seen_again_from
        self.before: dict[int, tuple[Sighting, ...]] = {}
        self.after: dict[int, tuple[Sighting, ...]] = {}
        self.numbers: list[int] = []
        self.frames_with_face = self.tiny_faces = 0

    def __call__(self, frame: Frame) -> FrameFaces:
        tiny_before = self._find.tiny_faces
        item = self._find(frame)
        if self._segment.is_before(frame.pts):
            self.before[frame.pts] = sightings_in(item)
        elif self._segment.holds(frame.pts):
            self.frames_with_face += bool(item.faces)
            self.tiny_faces += self._find.tiny_faces - tiny_before
            found = sorted(face.track_id for face in item.faces)
            self.numbers += [number for number in found if number not in self.numbers]
            in_source = frame.pts + self._segment.shift
            if self._seen_again_from is not None and in_source >= self._seen_again_from:
                self.after[frame.pts] = sightings_in(item)
        return item


class UntilEnd:
    """Passes on frames up to the end of the segment; frames after it only served the smoothing."""

    def __init__(self, segment: Segment, stage: Stage) -> None:
        self._segment, self._stage = segment, stage

    def __call__(self, item: FrameFaces) -> Any:
        return None if self._segment.is_after(item.frame.pts) else self._stage(item)


class FromBeginning:
    """Passes on the segment's own frames. Frames of the run-up are not painted; they only settle
    what painting keeps from frame to frame.

    composite: the stage that paints.  paint: the same, or a stage that shows each frame before and
    after painting.
    known: what is known of the faces; None: the segment uses its own numbers.
    largest_first: the face that was the largest when the segment began, if any.
    """

    def __init__(
        self,
        segment: Segment,
        composite: Composite,
        paint: Stage,
        known: KnownFaces | None = None,
    ) -> None:
        self._segment, self._composite, self._paint = segment, composite, paint
        self._known = known
        self._has_begun = False
        self.largest_first: int | None = None

    def __call__(self, item: FrameScene) -> Frame | None:
        if self._known is not None:
            item = _numbered(item, self._known.numbers)
        is_before = self._segment.is_before(item.frame.pts)
        if not self._has_begun:
            if self._known is not None:
                self._composite.largest_id = self._known.largest_id
            if not is_before:
                self._has_begun, self.largest_first = True, self._composite.largest_id
        if not is_before:
            painted: Frame = self._paint(item)
            return painted
        ticks_left = self._segment.first - self._segment.shift - item.frame.pts
        self._composite.settle(item, read=ticks_left * item.frame.time_base < _SETTLE_SECONDS)
        return None


def _numbered(item: FrameScene, numbers: Mapping[int, int]) -> FrameScene:
    """The same scene with the video's numbers of its faces."""
    return replace(
        item,
        faces=tuple(
            replace(scene, face=replace(scene.face, track_id=_in_video(scene, numbers)))
            for scene in item.faces
        ),
    )


def _in_video(scene: FaceScene, numbers: Mapping[int, int]) -> int:
    """The video's number of a face; a negative number for a face seen only in the run-up."""
    own = scene.face.track_id
    return numbers.get(own, -1 - own)
