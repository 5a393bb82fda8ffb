"""The stages of one segment: its run-up settles them, and only its own frames leave the last."""

from dataclasses import replace
from typing import Any

from makeup_video.pipeline.engine.runner import Stage
from makeup_video.pipeline.faces.face import FrameFaces
from makeup_video.pipeline.faces.tracker import FindFaces
from makeup_video.pipeline.frames.frame import Frame
from makeup_video.pipeline.media.segments import Segment
from makeup_video.pipeline.offline.face_numbers import FaceNumbers, Sighting, sightings_in
from makeup_video.pipeline.render.scene import FrameScene


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
    """Passes on the frames up to the end of the segment; those behind it only served smoothing."""

    def __init__(self, segment: Segment, stage: Stage) -> None:
        self._segment, self._stage = segment, stage

    def __call__(self, item: FrameFaces) -> Any:
        return None if self._segment.is_after(item.frame.pts) else self._stage(item)


class FromBeginning:
    """Passes on the segment's own frames; those of the run-up are not painted.

    numbers: of the faces in the film; None where the numbers do not matter.
    """

    def __init__(
        self,
        segment: Segment,
        stage: Stage,
        faces: SegmentFaces,
        numbers: FaceNumbers | None = None,
    ) -> None:
        self._segment, self._stage = segment, stage
        self._faces, self._numbers = faces, numbers
        self._has_begun = False

    def __call__(self, item: FrameScene) -> Frame | None:
        if self._segment.is_before(item.frame.pts):
            return None
        if self._numbers is not None:
            if not self._has_begun:
                self._numbers.match(self._faces.before)
            item = _numbered(item, self._numbers)
        self._has_begun = True
        painted: Frame = self._stage(item)
        return painted


def _numbered(item: FrameScene, numbers: FaceNumbers) -> FrameScene:
    """The same scene with the film's numbers of its faces."""
    numbers.take(sorted(scene.face.track_id for scene in item.faces))
    return replace(
        item,
        faces=tuple(
            replace(scene, face=replace(scene.face, track_id=numbers[scene.face.track_id]))
            for scene in item.faces
        ),
    )
