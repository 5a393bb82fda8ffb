"""Fits the logistic model that reads from the colours of a face which kinds of makeup it wears.

    python -m makeup_video.training.worn.fit_colours --faces DIR --out pipeline/weights

DIR has folders `portraits` and `wild` with worn.csv, as of worn/prepare.py. Writes
bare_colours.npy, what areas of bare faces look like, and worn_colours.npy: by kind a weight for
each number, and a constant.
"""

import argparse
from pathlib import Path

import numpy as np
from makeup_video.pipeline.reference.colours import Colours, areas, with_distances
from makeup_video.pipeline.reference.neutral_face import neutral_face
from makeup_video.pipeline.reference.photo_light import photo_light
from makeup_video.training.worn.prepare import LABELS, labelled_faces
from makeup_video.training.worn.scores import UNKNOWN, logistic

SETS = ("wild", "portraits")
RIDGE = 300.0  # of weights for numbers of variance 1: tried on photos between 30 and 1000
# By area: the kinds without which it is bare.
_BARE_WITHOUT = (("lips",), ("blush",), *(("shadow", "liner"),) * 4)
_LEAST_SPREAD = 1e-3  # of logarithms


def read(folder: Path) -> tuple[np.ndarray, np.ndarray]:
    """Logarithms (N, 226) and labels (N, 4) of the largest face of each picture."""
    numbers, labels = [], []
    for name in SETS:
        for rgb8, face, known in labelled_faces(folder / name):
            neutral = neutral_face(rgb8, face, photo_light(rgb8, face))
            numbers.append(Colours.of(neutral).logarithms())
            labels.append(known)
        print(f"{name}: {len(numbers)} faces so far", flush=True)
    return np.array(numbers), np.array(labels)


def bare_areas(logarithms: np.ndarray, labels: np.ndarray) -> np.ndarray:
    """(6, 12) of with_distances, each area from the faces that wear nothing there."""
    columns = list(LABELS)
    rows12 = []
    for number, names in enumerate(_BARE_WITHOUT):
        is_bare = (labels[:, [columns.index(name) for name in names]] == 0).all(1)
        seen = areas(logarithms[is_bare])[:, number]
        inverse = np.linalg.inv(np.cov(seen.T) + _LEAST_SPREAD * np.eye(3))
        rows12.append(np.concatenate([np.median(seen, axis=0), inverse.ravel()]))
    return np.array(rows12, np.float32)


def fit(numbers: np.ndarray, is_worn: np.ndarray, ridge: float = RIDGE) -> np.ndarray:
    """(N + 1,) weights and constant: logistic regression with a ridge.

    Bare and made-up faces count the same in all, however many there are of each.
    """
    mean, spread = numbers.mean(0), numbers.std(0) + 1e-6
    rows1 = np.column_stack([(numbers - mean) / spread, np.ones(len(numbers))])
    share = max(float(is_worn.mean()), 1e-3)
    counts = np.where(is_worn, 0.5 / share, 0.5 / max(1 - share, 1e-3))
    weights = logistic(rows1, is_worn, counts, ridge)
    scaled = weights[:-1] / spread
    return np.append(scaled, weights[-1] - scaled @ mean)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--faces", type=Path, required=True)
    parser.add_argument("--out", type=Path, required=True)
    options = parser.parse_args()
    logarithms, labels = read(options.faces)
    bare, fitted = bare_areas(logarithms, labels), []
    np.save(options.out / "bare_colours.npy", bare)
    numbers = with_distances(logarithms, bare)
    for column in range(len(LABELS)):
        known = labels[:, column] != UNKNOWN
        fitted.append(fit(numbers[known], labels[known, column] == 1))
    np.save(options.out / "worn_colours.npy", np.array(fitted, np.float32))


if __name__ == "__main__":
    main()
