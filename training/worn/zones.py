"""How much of a photo's makeup comes across to other faces: the zone measure.

d is the median CIELAB of a zone minus that of plain skin. P is a photo, B a bare face, and M is B
painted with the look of P: moved = |d(P) - d(B)|, left = |d(P) - d(M)|. The measure is
1 - sum(left) / sum(moved): 0 means that nothing comes across, 1 everything, and a negative number
that the painted face is further from the photo than the bare one. A photo counts in the zones where
it is clearly made up: further from the mean bare face than nine of ten bare faces.
"""

from collections import defaultdict
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
from makeup_video.pipeline.faces.face import Face
from makeup_video.pipeline.faces.topology import LIPS_INNER, LIPS_OUTER
from makeup_video.pipeline.look.ciede2000 import lab_of
from makeup_video.pipeline.look.look import Look
from makeup_video.pipeline.reference.neutral_face import PLAIN_SKIN, filled

# Closed contours of the face's points; all but the lips have a mirror image.
ZONES = {
    "lips": tuple(LIPS_OUTER.tolist()),
    "lid": (33, 246, 161, 160, 159, 158, 157, 173, 190, 56, 28, 27, 29, 30, 247, 130),
    "crease": (247, 30, 29, 27, 28, 56, 190, 189, 221, 222, 223, 224, 225, 113),
    "brow bone": (113, 225, 224, 223, 222, 221, 55, 65, 52, 53, 46),
    "outer corner": (33, 130, 113, 124, 35, 31),
    "under the eye": (33, 7, 163, 144, 145, 153, 154, 155, 26, 22, 23, 24, 110, 25),
    "cheek": (116, 117, 118, 101, 36, 205, 187, 123),
}  # fmt: skip
EYES = tuple(zone for zone in ZONES if zone not in ("lips", "cheek"))
_LEAST_PX = 20  # a zone with no more px is hardly seen
_CLEARLY = 90  # percentile of the distances of bare faces from their mean
CANVASES = 5  # bare faces on which looks are painted

Zones = dict[str, np.ndarray]  # (3,) by zone; nan where the zone is hardly seen


@dataclass(frozen=True, slots=True, eq=False)
class Seen:
    """A photo, its face, and how its zones differ from its skin."""

    rgb8: np.ndarray
    face: Face
    zones: Zones


def see(rgb8: np.ndarray, face: Face) -> Seen:
    return Seen(rgb8, face, zones_of(rgb8, face))


def zones_of(rgb8: np.ndarray, face: Face) -> Zones:
    """The median of each zone minus that of plain skin, CIELAB."""
    lab, hw = lab_of(rgb8), rgb8.shape
    skin = np.median(lab[filled(face, PLAIN_SKIN, hw, mirrored=True)], axis=0)
    found = {}
    for zone, contour in ZONES.items():
        mask = filled(face, [contour], hw, mirrored=zone != "lips")
        if zone == "lips":
            mask &= ~filled(face, [LIPS_INNER], hw, mirrored=False)
        enough = mask.sum() > _LEAST_PX
        found[zone] = np.median(lab[mask], axis=0) - skin if enough else np.full(3, np.nan)
    return found


class Transfer:
    """Adds up how much makeup comes across from photos to bare faces."""

    def __init__(self, bare: Sequence[Seen]) -> None:
        self.mean = {zone: np.nanmean([one.zones[zone] for one in bare], axis=0) for zone in ZONES}
        self.own = {
            zone: [float(np.linalg.norm(one.zones[zone] - self.mean[zone])) for one in bare]
            for zone in ZONES
        }
        self.canvases = bare[2 :: max(1, len(bare) // CANVASES)][:CANVASES]
        self.moved: dict[str, list[float]] = defaultdict(list)
        self.left: dict[str, list[float]] = defaultdict(list)
        self.photos: dict[str, int] = defaultdict(int)

    def add(self, photo: Seen, look: Look, paint: Callable[[Seen, Look], np.ndarray]) -> None:
        """Paint the look of a photo on every canvas, and compare."""
        made_up = [zone for zone in ZONES if self._is_made_up(photo, zone)]
        for zone in made_up:
            self.photos[zone] += 1
        for canvas in self.canvases:
            after = zones_of(paint(canvas, look), canvas.face)
            for zone in made_up:
                moved = float(np.linalg.norm(photo.zones[zone] - canvas.zones[zone]))
                left = float(np.linalg.norm(photo.zones[zone] - after[zone]))
                if np.isfinite(moved + left):
                    self.moved[zone].append(moved)
                    self.left[zone].append(left)

    def score(self, *zones: str) -> float:
        """How much comes across in these zones together."""
        moved = sum(sum(self.moved[zone]) for zone in zones)
        return 1 - sum(sum(self.left[zone]) for zone in zones) / moved if moved else float("nan")

    def best(self, *zones: str) -> float:
        """The score of a perfect transfer: below 1, because bare faces differ from one another."""
        own = sum(float(np.nanmean(self.own[zone])) * len(self.moved[zone]) for zone in zones)
        moved = sum(sum(self.moved[zone]) for zone in zones)
        return 1 - own / moved if moved else float("nan")

    def _is_made_up(self, photo: Seen, zone: str) -> bool:
        off = float(np.linalg.norm(photo.zones[zone] - self.mean[zone]))
        return off > float(np.nanpercentile(self.own[zone], _CLEARLY))
