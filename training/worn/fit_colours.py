"""Fits the logistic models that read from the colours of a face which kinds of makeup it wears.

    python -m makeup_video.training.worn.fit_colours --faces DIR --out pipeline/weights

DIR has the folders `portraits` and `wild` with worn.csv, as worn/prepare.py describes them. The
command writes bare_colours.npy and bare_lips.npy, which describe areas of bare faces and lips. It
also writes the models, which have a weight for each number and a constant: worn_lips.npy for
lipstick, and worn_colours.npy for each other kind. The shipped files were fitted while hair over
the forehead still counted as skin, and hair beside the eyes as eyeshadow
(docs/decisions/reference.md).
"""

import argparse
from pathlib import Path

import numpy as np
from makeup_video.pipeline.reference.colours import Colours, areas, with_distances
from makeup_video.pipeline.reference.flat_lips import middles
from makeup_video.pipeline.reference.neutral_face import neutral_face
from makeup_video.pipeline.reference.photo_light import photo_light
from makeup_video.training.inputs import existing
from makeup_video.training.list_hashes import list_hashes
from makeup_video.training.worn.prepare import LABELS, labelled_faces
from makeup_video.training.worn.scores import UNKNOWN, logistic

SETS = ("wild", "portraits")
# For weights of numbers scaled to variance 1. Ridges from 30 to 1000 were tried on photos.
RIDGE, LIPS_RIDGE = 300.0, 100.0
# For each area, the labels that must be 0 for the area to be bare.
_BARE_WITHOUT = (("lips",), ("blush",), *(("shadow", "liner"),) * 4)
_LEAST_SPREAD = 1e-3  # added to variances, so that the covariance can be inverted


def read(folder: Path) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Logarithms (N, 226), numbers of the lips (N, 102) and labels (N, 4) of the largest face in
    each picture."""
    numbers, lips, labels = [], [], []
    for name in SETS:
        for rgb8, face, known in labelled_faces(folder / name):
            neutral = neutral_face(rgb8, face, photo_light(rgb8, face))
            colours = Colours.of(neutral)
            numbers.append(colours.logarithms())
            lips.append(colours.flat_lips.numbers())
            labels.append(known)
        print(f"{name}: {len(numbers)} faces so far", flush=True)
    return np.array(numbers), np.array(lips), np.array(labels)


def bare_areas(logarithms: np.ndarray, labels: np.ndarray) -> np.ndarray:
    """The (6, 12) that with_distances takes, each area measured on faces that are bare there."""
    columns = list(LABELS)
    rows12 = []
    for number, names in enumerate(_BARE_WITHOUT):
        is_bare = (labels[:, [columns.index(name) for name in names]] == 0).all(1)
        rows12.append(_spread(areas(logarithms[is_bare])[:, number]))
    return np.array(rows12, np.float32)


def bare_lips(lips: np.ndarray, labels: np.ndarray) -> np.ndarray:
    """The (4, 12) that away_from_bare takes, measured on faces without lipstick."""
    seen = middles(lips[labels[:, 0] == 0])
    return np.array([_spread(block) for block in np.moveaxis(seen, 1, 0)], np.float32)


def _spread(colours: np.ndarray) -> np.ndarray:
    """(12,): the median of colours (N, 3), and the inverse of their covariance."""
    inverse = np.linalg.inv(np.cov(colours.T) + _LEAST_SPREAD * np.eye(3))
    return np.concatenate([np.median(colours, axis=0), inverse.ravel()])


def fit(numbers: np.ndarray, is_worn: np.ndarray, ridge: float = RIDGE) -> np.ndarray:
    """(N + 1,) weights and constant: logistic regression with a ridge.

    All bare faces together weigh as much as all made-up faces, however many there are of each.
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
    parser.add_argument("--faces", type=existing, required=True)
    parser.add_argument("--out", type=Path, required=True)
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    logarithms, lips, labels = read(options.faces)
    bare = bare_areas(logarithms, labels)
    np.save(options.out / "bare_colours.npy", bare)
    np.save(options.out / "bare_lips.npy", bare_lips(lips, labels))
    known, worn = labels != UNKNOWN, labels == 1
    lipstick = fit(lips[known[:, 0]], worn[known[:, 0], 0], LIPS_RIDGE)
    np.save(options.out / "worn_lips.npy", lipstick.astype(np.float32))
    numbers = with_distances(logarithms, bare)
    fitted = [
        fit(numbers[here], is_worn[here])
        for here, is_worn in list(zip(known.T, worn.T, strict=True))[1:]
    ]
    np.save(options.out / "worn_colours.npy", np.array(fitted, np.float32))
    list_hashes(options.out)


if __name__ == "__main__":
    main()
