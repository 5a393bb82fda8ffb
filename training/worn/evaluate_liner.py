"""Measures how well the form of eyeliner is read in real photos.

    python -m makeup_video.training.worn.evaluate_liner --looks DIR...

The folders have the photos that liners_of_looks.csv names: people with makeup on whom eyeliner is
read. Two people labelled in each photo whether there is a wing and a lower line (0 no, 1 not sure
or not agreed, 2 yes), the thickness of the line, and the length and the angle of a wing. The file
has the means of their numbers.
"""

import argparse
from pathlib import Path

import numpy as np
from makeup_video.pipeline.reference.read_liner import ANGLE_UNIT, liner_numbers
from makeup_video.training.inputs import existing
from makeup_video.training.worn.real_photos import labelled_layers
from makeup_video.training.worn.scores import agreement, area_under_curve

_LABELS = Path(__file__).with_name("liners_of_looks.csv")


def evaluate(folders: list[Path]) -> str:
    rows, found, shapes = [], [], []
    for row, photo, layer in labelled_layers(_LABELS, folders, "eyeliner"):
        rows.append(row)
        found.append(liner_numbers(photo.rgb8, photo.face))
        shapes.append(layer.whole_shape)
    scores, lengths, angles, _ = np.array(found).T
    read_as = {dial: np.array([shape[dial] for shape in shapes]) for dial in shapes[0]}
    wing, below = (np.array([int(row[name]) for row in rows]) for name in ("wing", "lower"))
    surely = wing != 1
    area = area_under_curve(scores[surely], wing[surely] == 2)
    seen = {name: _numbers(rows, name) for name in ("length", "angle", "thickness")}
    lines = [
        f"{len(rows)} photos on which liner is read; wings: area under curve {area:.3f}",
        _found("wings", read_as["wing"] > 0, wing),
        _found("lower lines", read_as["lower"] > 0, below),
        agreement("length of wings, as the net returns it", lengths, seen["length"]),
        agreement("angle of wings, as the net returns it", ANGLE_UNIT * angles, seen["angle"]),
        agreement("thickness", read_as["thickness"], seen["thickness"]),
    ]
    return "\n".join(lines)


def _numbers(rows: list[dict[str, str]], name: str) -> np.ndarray:
    return np.array([float(row[name] or "nan") for row in rows])


def _found(name: str, read_as: np.ndarray, label: np.ndarray) -> str:
    """In how many photos a wing or a lower line is read, for each of their labels."""
    counts = [f"{read_as[label == one].sum()} of {(label == one).sum()}" for one in (2, 1, 0)]
    return f"{name}: read in {counts[0]} with one, {counts[1]} unsure, {counts[2]} without"


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--looks", type=existing, nargs="+", required=True)
    print(evaluate(parser.parse_args().looks))
