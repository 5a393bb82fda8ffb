"""Evaluates how lips are painted on photos in which lips and mouth interiors are outlined.

    python -m makeup_video.training.faces.evaluate_painted_lips --masks DIR [DIR ...]

A folder holds photos (.jpg), each with labels of the same size (.png): 1 lips, 2 the mouth's
interior. The product's own detector finds the face in the whole picture. What is measured is the
weight of lipstick that the renderer would paint. A face that is not found counts as unpainted.
"""

import argparse
from pathlib import Path
from typing import NamedTuple

import cv2
import numpy as np
from makeup_video.pipeline.faces.face import Face, iod_px
from makeup_video.pipeline.faces.find import find_faces
from makeup_video.pipeline.render.surfaces.lips_twin import lips_surface
from makeup_video.pipeline.render.surfaces.surface import Edge
from makeup_video.training.faces.evaluate import iou_of, read_rgb
from makeup_video.training.inputs import existing

LIPS, INTERIOR = 1, 2
OPEN = 0.01  # share of the lips' area; a mouth with a larger interior counts as open
BESIDE = 0.04  # IOD; lips nearer to the opening than this are beside it
CORNERS = 0.75  # share of the way from the mouth's middle to its end, where its corner begins
USUAL_IOD = 0.25  # share of the picture's width that is taken for the IOD if no face is found


class Painted(NamedTuple):
    """How one mouth is painted; nan for numbers that a shut mouth does not have.

    iou: of paint and lips.  corners: the same, at the corners of the mouth alone.
    beside: the painted share of the lips beside the opening.
    missed: unpainted lips that are nearer to the opening than to the skin, as a share of all lips.
    interior, outside: painted interior and painted skin, as shares of the lips' area.
    """

    iou: float
    corners: float
    beside: float
    missed: float
    interior: float
    outside: float


def is_open(labels: np.ndarray) -> bool:
    return bool((labels == INTERIOR).sum() > OPEN * (labels == LIPS).sum())


def painted_lips(face: Face | None, shape: tuple[int, int]) -> np.ndarray:
    """(H, W) bool: where lipstick with a hard edge covers more than half of a pixel."""
    weight = np.zeros(shape, np.float32)
    surface = lips_surface(face) if face is not None else None
    if surface is not None:
        surface.weigh(weight, (0, 0), Edge(0.0), None)
    return weight > 0.5


def score(painted: np.ndarray, labels: np.ndarray, iod: float) -> Painted:
    """painted: (H, W) bool. labels: (H, W) uint8 of LIPS, INTERIOR and 0. iod: px."""
    lips, interior = labels == LIPS, labels == INTERIOR
    area = max(int(lips.sum()), 1)
    columns = np.flatnonzero((lips | interior).any(0))
    left, right = (columns[0], columns[-1]) if columns.size else (0, 1)
    out_of_middle = np.abs(2 * np.arange(labels.shape[1]) - left - right) / max(right - left, 1)
    at_corner = np.broadcast_to(out_of_middle > CORNERS, labels.shape)
    beside = missed = np.nan
    if is_open(labels):
        to_opening, to_skin = (
            cv2.distanceTransform(there.astype(np.uint8), cv2.DIST_L2, 5)
            for there in (~interior, lips | interior)
        )
        ring = lips & (to_opening < BESIDE * iod)
        beside = painted[ring].mean() if ring.any() else np.nan
        missed = (lips & ~painted & (to_opening < to_skin)).sum() / area
    return Painted(
        iou_of(painted, lips), iou_of(painted & at_corner, lips & at_corner), beside, missed,
        (painted & interior).sum() / area, (painted & ~lips & ~interior).sum() / area,
    )  # fmt: skip


def measure(folder: Path) -> list[tuple[bool, Painted]]:
    """For each photo of the folder, whether its mouth is open, and how it is painted."""
    scores = []
    for path in sorted(folder.glob("*.png")):
        labels = cv2.imread(str(path), cv2.IMREAD_GRAYSCALE)
        rgb8 = read_rgb(path.with_suffix(".jpg"))
        face = next(iter(find_faces(rgb8)), None)
        iod = iod_px(face) if face is not None else USUAL_IOD * labels.shape[1]
        scores.append((is_open(labels), score(painted_lips(face, labels.shape), labels, iod)))
    return scores


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--masks", type=existing, nargs="+", required=True)
    folders = parser.parse_args().masks
    scores = [found for folder in folders for found in measure(folder)]
    for name, wanted in (("open", True), ("shut", False)):
        chosen = np.array([painted for opened, painted in scores if opened == wanted])
        if not len(chosen):
            print(f"{name} (0)")
            continue
        known = [column[~np.isnan(column)] for column in chosen.T]
        means = [f"{column.mean():.3f}" if len(column) else "-" for column in known]
        words = (" ".join(pair) for pair in zip(Painted._fields, means, strict=True))
        print(f"{name} ({len(chosen)}): {'  '.join(words)}")


if __name__ == "__main__":
    main()
