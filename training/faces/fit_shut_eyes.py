"""Fits the model that distinguishes shut eyes from narrow ones (pipeline/faces/shut_eyes.py).

    python -m makeup_video.training.faces.fit_shut_eyes --faces DIR --out pipeline/weights

DIR has folders of pictures. Each row of shut_eyes.csv names a folder, a picture and an eye of its
largest face (0 the left one in the picture, 1 the right one). People labelled whether that eye is
shut (1) or open at least by a slit (0).
"""

import argparse
import csv
from collections.abc import Iterator
from itertools import groupby
from pathlib import Path

import numpy as np
from makeup_video.pipeline.faces.crop_layout import EYE_CROP, eye_crops
from makeup_video.pipeline.faces.find import find_faces
from makeup_video.pipeline.faces.nets import FaceNets
from makeup_video.pipeline.faces.shut_eyes import numbers_of
from makeup_video.pipeline.frames.views import RgbPicture
from makeup_video.training.faces.evaluate import read_rgb
from makeup_video.training.inputs import existing
from makeup_video.training.list_hashes import list_hashes
from makeup_video.training.worn.fit_colours import fit
from makeup_video.training.worn.scores import area_under_curve

LABELS = Path(__file__).with_name("shut_eyes.csv")
RIDGE = 10.0
FOLDS = 5


def eyes_of(nets: FaceNets, rgb8: np.ndarray) -> np.ndarray | None:
    """(2, N) the numbers of both eyes of the largest face; None without a face."""
    faces = find_faces(rgb8)
    if not faces:
        return None
    x, y = faces[0].points_px[nets.part_points, :2].T.astype(np.float64)
    picture = RgbPicture(rgb8)
    layout = nets.layout_around(nets.part_centres(x + 1j * y)).rounded()
    (crops,) = picture.crops((eye_crops(layout),))
    points = nets.eye(crops)["points"]
    return np.stack([numbers_of(*eye, EYE_CROP.span) for eye in zip(points, crops, strict=True)])


def labelled(folder: Path) -> Iterator[tuple[np.ndarray, bool]]:
    """The numbers of each labelled eye, and whether it is shut."""
    nets = FaceNets()
    with LABELS.open(newline="", encoding="utf-8") as table:
        rows = list(csv.reader(table))[1:]
    for (source, name), of_picture in groupby(rows, key=lambda row: row[:2]):
        eyes = eyes_of(nets, read_rgb(folder / source / name))
        if eyes is not None:
            yield from ((eyes[int(side)], shut == "1") for _, _, side, shut in of_picture)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--faces", type=existing, required=True)
    parser.add_argument("--out", type=Path, required=True)
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    numbers, shut = map(np.array, zip(*labelled(options.faces), strict=True))
    scores = np.zeros(len(shut))
    for held in np.array_split(np.arange(len(shut)), FOLDS):  # neighbours are of one person
        rest = np.setdiff1d(np.arange(len(shut)), held)
        weights = fit(numbers[rest], shut[rest], RIDGE)
        scores[held] = numbers[held] @ weights[:-1] + weights[-1]
    right, area = ((scores > 0) == shut).mean(), area_under_curve(scores, shut)
    print(f"{len(shut)} eyes, {shut.sum()} shut; area under the ROC curve {area:.3f}")
    print(f"right: {right:.0%}; both held out")
    np.save(options.out / "shut_eyes.npy", fit(numbers, shut, RIDGE).astype(np.float32))
    list_hashes(options.out)


if __name__ == "__main__":
    main()
