"""How well the form of eyeliners in real photos is read.

    python -m makeup_video.training.worn.evaluate_liner --looks DIR...

The folders have the photos that liners_of_looks.csv names: people with makeup on whom eyeliner is
read. Two people labelled each: wing and lower line (0 no, 1 not sure or not agreed, 2 yes), and of
the line the thickness, of a wing the length and the angle (means).
"""

import argparse
import csv
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from makeup_video.pipeline.faces.face import Face
from makeup_video.pipeline.reference.checks import faces_within
from makeup_video.pipeline.reference.flat_eyes import flat_eyes
from makeup_video.pipeline.reference.lower_line import lower_line
from makeup_video.pipeline.reference.neutral_face import neutral_face
from makeup_video.pipeline.reference.photo_light import photo_light
from makeup_video.pipeline.reference.read_liner import ANGLE_UNIT, WING_FROM, liner_numbers
from makeup_video.training.inputs import existing
from makeup_video.training.worn.real_photos import read
from makeup_video.training.worn.scores import area_under_curve

_LABELS = Path(__file__).with_name("liners_of_looks.csv")


def labelled(folders: list[Path]) -> Iterator[tuple[dict[str, str], np.ndarray, Face]]:
    """Rows of the labels, with the photo and its largest face."""
    with _LABELS.open(newline="", encoding="utf-8") as table:
        rows = list(csv.DictReader(table))
    for row in rows:
        for path in (folder / row["name"] for folder in folders):
            if path.exists() and (faces := faces_within(rgb8 := read(path))):
                yield row, rgb8, faces[0]


def evaluate(folders: list[Path]) -> str:
    rows, found, lower = [], [], []
    for row, rgb8, face in labelled(folders):
        rows.append(row)
        found.append(liner_numbers(rgb8, face))
        lower.append(lower_line(flat_eyes(neutral_face(rgb8, face, photo_light(rgb8, face)))) > 0)
    scores, lengths, angles, thickness = np.array(found).T
    wing, below = (np.array([int(row[name]) for row in rows]) for name in ("wing", "lower"))
    surely = wing != 1
    area = area_under_curve(scores[surely], wing[surely] == 2)
    seen = {name: _numbers(rows, name) for name in ("length", "angle", "thickness")}
    lines = [
        f"{len(rows)} photos; wings: area under curve {area:.3f}",
        _found("wings", scores >= WING_FROM, wing),
        _found("lower lines", np.array(lower), below),
        _agreement("length of wings", lengths, seen["length"]),
        _agreement("angle of wings", ANGLE_UNIT * angles, seen["angle"]),
        _agreement("thickness", thickness, seen["thickness"]),
    ]
    return "\n".join(lines)


def _numbers(rows: list[dict[str, str]], name: str) -> np.ndarray:
    return np.array([float(row[name] or "nan") for row in rows])


def _found(name: str, read_as: np.ndarray, label: np.ndarray) -> str:
    """In how many photos something is read, by their labels."""
    counts = [f"{read_as[label == one].sum()} of {(label == one).sum()}" for one in (2, 1, 0)]
    return f"{name}: read in {counts[0]} with one, {counts[1]} unsure, {counts[2]} without"


def _agreement(name: str, found: np.ndarray, true: np.ndarray) -> str:
    known = np.isfinite(true)
    found, true = found[known], true[known]
    correlation = np.corrcoef(found, true)[0, 1]
    return f"{name}: correlation {correlation:.2f}, mean {found.mean():.3f}, true {true.mean():.3f}"


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--looks", type=existing, nargs="+", required=True)
    print(evaluate(parser.parse_args().looks))
