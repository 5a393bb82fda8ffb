"""Mouths outlined by hand.

lip_contours.json holds for each mouth its folder, its index among the folder's packed faces, and
closed curves: the outer border of the lips, the opening between them, whatever covers them, and for
most mouths the teeth. The curves are in IOD from the centre of MediaPipe's lips, along the axes of
the face's pose. Most mouths were outlined twice, the second time without sight of the first.
"""

import json
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from makeup_video.pipeline.faces.topology import LIPS
from makeup_video.training.faces.contour import fill

_CONTOURS = Path(__file__).with_name("lip_contours.json")
_STEPS = 12  # points of a curve from each corner to the next
FINER = 4  # outlines are drawn this many times larger, then averaged


@dataclass
class Mouth:
    """One outlined mouth on the grid given to read_mouths."""

    folder: str
    index: int  # among the packed faces of that folder
    lips: np.ndarray  # (H, W) float32, share of each px that is lip
    interior: np.ndarray  # (H, W) float32, share that shows between the lips
    covered: np.ndarray  # (H, W) float32, share covered by a hand, hair, a microphone
    # (H, W) float32, the teeth's share of what shows between the lips; 0.5 where unknown
    teeth: np.ndarray

    @property
    def shares(self) -> np.ndarray:
        """(H, W, 3) float32: the shares of the whole mouth and of what shows between the lips, and
        the teeth's share of the latter."""
        return np.dstack([np.minimum(self.lips + self.interior, 1), self.interior, self.teeth])


def spline(corners: list[list[float]]) -> np.ndarray:
    """A closed Catmull-Rom curve through points (K, 2); a repeated point makes a sharp corner."""
    points = np.asarray(corners, float)
    t = np.linspace(0, 1, _STEPS, endpoint=False)[:, None]
    parts = []
    for i, b in enumerate(points):
        a, c, d = points[i - 1], points[(i + 1) % len(points)], points[(i + 2) % len(points)]
        if not np.allclose(b, c):
            bend = (2 * a - 5 * b + 4 * c - d) * t**2 + (3 * b - a - 3 * c + d) * t**3
            parts.append(b + ((c - a) * t + bend) / 2)
    return np.concatenate(parts)


def filled(curves: list, size_wh: tuple[int, int], span: float) -> np.ndarray:
    """Closed curves in IOD -> coverage (H, W) float32 of a grid `span` IOD wide."""
    w, h = size_wh
    picture = np.zeros((h * FINER, w * FINER), np.uint8)
    middle = (np.array([w, h]) * FINER - 1) / 2
    for curve in curves:
        fill(picture, spline(curve) * (w * FINER / span) + middle, 255)
    return cv2.resize(picture, size_wh, interpolation=cv2.INTER_AREA).astype(np.float32) / 255


def read_mouths(size_wh: tuple[int, int], span: float) -> list[Mouth]:
    """The outlined mouths on a grid of size_wh px, `span` IOD wide."""
    mouths = []
    for entry in json.loads(_CONTOURS.read_text()):
        outer, inner, covered = (
            filled(entry[key], size_wh, span) for key in ("outer", "inner", "covered")
        )
        interior = np.minimum(inner, 1 - covered)
        lips = np.minimum(np.minimum(outer, 1 - inner), 1 - covered)
        known = entry.get("teeth")
        teeth = np.full_like(lips, 0.5) if known is None else filled(known, size_wh, span)
        mouths.append(Mouth(entry["folder"], entry["index"], lips, interior, covered, teeth))
    return mouths


def mouth_to_px(points: np.ndarray, pose: np.ndarray) -> np.ndarray:
    """The map (2, 3) from IOD about the centre of the lips of `points` (478, 3) to picture px."""
    return np.column_stack([pose[:, :2], points[LIPS, :2].mean(0)])
