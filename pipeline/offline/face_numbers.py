"""Gives each face of a video the same number in all segments.

Each segment numbers its own faces from 0. Two neighbouring segments both see the frames just before
their seam. In most of these frames the same face is at the same place in both segments.
"""

from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from typing import NamedTuple

from makeup_video.pipeline.faces.face import FrameFaces

_SAME_PLACE = 0.25  # of the face's width; little, since both segments read the same pixels


class Sighting(NamedTuple):
    """One face in one frame: its number, and the box around its points."""

    number: int
    x_px: float
    y_px: float
    width_px: float


Sightings = Mapping[int, tuple[Sighting, ...]]  # by the time of the frame, in ticks


def sightings_in(item: FrameFaces) -> tuple[Sighting, ...]:
    """The faces of a frame."""
    found = []
    for face in item.faces:
        x, y, _ = face.points_px.T
        width = float(x.max() - x.min())
        found.append(Sighting(face.track_id, float(x.mean()), float(y.mean()), width))
    return tuple(found)


class KnownFaces(NamedTuple):
    """What is known of a segment's faces once the segments before it are painted.

    numbers: the video's number of each face, by the segment's own number.
    largest_id: the video's number of the face that was last painted as the largest, if any.
    """

    numbers: Mapping[int, int]
    largest_id: int | None


class VideoNumbers:
    """Numbers the faces of one segment after the other. count: how many faces there are so far."""

    def __init__(self) -> None:
        self.count = 0
        self._known: Sightings = {}

    def next(self, before: Sightings, after: Sightings, own: Iterable[int]) -> dict[int, int]:
        """The video's numbers of the next segment's faces, by the segment's own numbers.

        before: what the segment saw in its run-up.  after: what it saw in frames that the next
        segment sees as well.  own: its faces in order of appearance.
        """
        numbers = self._recognised(before)
        for number in own:
            if number not in numbers:
                numbers[number] = self.count
                self.count += 1
        seen = {
            pts: tuple(
                face._replace(number=numbers[face.number])
                for face in faces
                if face.number in numbers
            )
            for pts, faces in after.items()
        }
        self._known = {**self._known, **seen}
        return numbers

    def forget_before(self, is_unseen: Callable[[int], bool]) -> None:
        """Forget frames that no further segment sees; is_unseen(pts): True for such a frame."""
        self._known = {pts: faces for pts, faces in self._known.items() if not is_unseen(pts)}

    def _recognised(self, before: Sightings) -> dict[int, int]:
        """The video's numbers of faces that earlier segments saw in the same frames."""
        votes: Counter[tuple[int, int]] = Counter()
        for pts, faces in before.items():
            for face in faces:
                near = min(
                    self._known.get(pts, ()), key=lambda other: _apart(face, other), default=None
                )
                if near is not None and _apart(face, near) < _SAME_PLACE:
                    votes[face.number, near.number] += 1
        numbers: dict[int, int] = {}
        for (own, number), _ in votes.most_common():
            if own not in numbers and number not in numbers.values():
                numbers[own] = number
        return numbers


def _apart(one: Sighting, other: Sighting) -> float:
    """How far apart two faces are, in widths of the wider one."""
    shift = abs(complex(one.x_px - other.x_px, one.y_px - other.y_px))
    return shift / max(one.width_px, other.width_px, 1.0)
