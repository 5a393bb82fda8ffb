"""Numbers the faces of a film alike in all its segments.

Each segment numbers its own faces from 0. Two neighbours see the same frames before the seam, so a
face of one is the face of the other that is at its place in most of these frames.
"""

from collections import Counter
from collections.abc import Iterable, Mapping
from typing import NamedTuple

from makeup_video.pipeline.faces.face import FrameFaces

_SAME_PLACE = 0.25  # of the face's width: both runs read the same pixels


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


class FaceNumbers:
    """The numbers in the film of one segment's faces.

    known: what the segment before saw at the end, with the film's numbers.
    next_number: of the film's next new face.
    """

    def __init__(self, known: Sightings | None = None, next_number: int = 0) -> None:
        self.next_number = next_number
        self._known = known or {}
        self._numbers: dict[int, int] = {}

    def match(self, before: Sightings) -> None:
        """Recognise faces by the frames that the segment before saw, too.

        before: what this segment saw in its run-up, with its own numbers.
        """
        votes: Counter[tuple[int, int]] = Counter()
        for pts, faces in before.items():
            for face in faces:
                near = min(
                    self._known.get(pts, ()), key=lambda other: _apart(face, other), default=None
                )
                if near is not None and _apart(face, near) < _SAME_PLACE:
                    votes[face.number, near.number] += 1
        for (own, number), _ in votes.most_common():
            if own not in self._numbers and number not in self._numbers.values():
                self._numbers[own] = number

    def __getitem__(self, own: int) -> int:
        """The number in the film; a face that was not seen before gets the next one."""
        if own not in self._numbers:
            self._numbers[own] = self.next_number
            self.next_number += 1
        return self._numbers[own]

    def of(self, sightings: Sightings) -> Sightings:
        """The same sightings with the film's numbers."""
        return {
            pts: tuple(face._replace(number=self[face.number]) for face in faces)
            for pts, faces in sightings.items()
        }

    def take(self, own: Iterable[int]) -> None:
        """Number these faces in order."""
        for number in own:
            _ = self[number]


def _apart(one: Sighting, other: Sighting) -> float:
    """How far apart two faces are, in widths of the wider one."""
    shift = abs(complex(one.x_px - other.x_px, one.y_px - other.y_px))
    return shift / max(one.width_px, other.width_px, 1.0)
