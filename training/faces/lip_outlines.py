"""Mouths outlined by hand: held-out faces, judged by eye.

lip_contours.json holds, per mouth, the folder and the place among its packed faces, and closed
curves in IOD from the middle of the teacher's lips, axes those of the face's frame: the outer
border of the lips, what shows between them, and what hides them.
"""

import json
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from makeup_video.pipeline.faces.topology import LIPS

CONTOURS = Path(__file__).with_name("lip_contours.json")
FINER = 4  # outlines are drawn this much larger, then averaged


@dataclass
class Mouth:
    """One outlined mouth on a grid that its reader chose."""

    folder: str
    index: int  # among the packed faces of that folder
    lips: np.ndarray  # (H, W) float32, share of the px that is lip
    interior: np.ndarray  # (H, W) likewise: whatever shows between the lips
    covered: np.ndarray  # (H, W) likewise: by a hand, hair, a microphone


def spline(corners: list[list[float]], steps: int = 12) -> np.ndarray:
    """Closed Catmull-Rom curve through (K, 2); a point given twice makes a sharp corner."""
    points = np.asarray(corners, float)
    t = np.linspace(0, 1, steps, endpoint=False)[:, None]
    parts = []
    for i, b in enumerate(points):
        a, c, d = points[i - 1], points[(i + 1) % len(points)], points[(i + 2) % len(points)]
        if not np.allclose(b, c):
            bend = (2 * a - 5 * b + 4 * c - d) * t**2 + (3 * b - a - 3 * c + d) * t**3
            parts.append(b + ((c - a) * t + bend) / 2)
    return np.concatenate(parts)


def filled(curves: list, size_wh: tuple[int, int], span: float) -> np.ndarray:
    """Closed curves in IOD -> (H, W) float32 coverage of a grid `span` IOD wide."""
    w, h = size_wh
    picture = np.zeros((h * FINER, w * FINER), np.uint8)
    middle = (np.array([w, h]) * FINER - 1) / 2
    for curve in curves:
        corners = spline(curve) * (w * FINER / span) + middle
        cv2.fillPoly(picture, [np.rint(corners * 16).astype(np.int32)], 255, shift=4)
    return cv2.resize(picture, size_wh, interpolation=cv2.INTER_AREA).astype(np.float32) / 255


def read_mouths(size_wh: tuple[int, int], span: float, path: Path = CONTOURS) -> list[Mouth]:
    mouths = []
    for entry in json.loads(path.read_text()):
        outer, inner, covered = (
            filled(entry[key], size_wh, span) for key in ("outer", "inner", "covered")
        )
        interior = np.minimum(inner, 1 - covered)
        lips = np.minimum(np.minimum(outer, 1 - inner), 1 - covered)
        mouths.append(Mouth(entry["folder"], entry["index"], lips, interior, covered))
    return mouths


def mouth_window(points: np.ndarray, frame: np.ndarray) -> np.ndarray:
    """(2, 3): IOD about the middle of the teacher's lips (478, 3) -> px of the picture."""
    return np.column_stack([frame[:, :2], points[LIPS, :2].mean(0)])
