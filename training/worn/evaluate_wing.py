"""How well the wings of eyeliners in real photos are read.

    python -m makeup_video.training.worn.evaluate_wing --looks DIR

DIR has photos and worn.csv with the columns liner (2 clear) and liner_where, in which w says that
there is a wing. Only photos with a clear liner count.
"""

import argparse
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from makeup_video.pipeline.errors import PhotoError
from makeup_video.pipeline.images.photo_file import read_photo
from makeup_video.pipeline.reference.checks import check_face, choose_face, faces_within
from makeup_video.pipeline.reference.wing import WING_FROM, wing_numbers
from makeup_video.training.inputs import existing
from makeup_video.training.worn.scores import area_under_curve
from makeup_video.training.worn.table import labelled_rows


def labelled(folder: Path) -> Iterator[tuple[Path, bool]]:
    """Photos with a clear liner, and whether it has a wing."""
    for row in labelled_rows(folder):
        if row["liner"] == "2":
            yield folder / row["name"], "w" in row["liner_where"]


def evaluate(folder: Path) -> str:
    scores, labels = [], []
    for path, has_wing in labelled(folder):
        rgb8 = read_photo(path)
        try:
            face = choose_face(faces_within(rgb8), "largest")
            check_face(rgb8, face)
        except PhotoError:
            continue
        scores.append(wing_numbers(rgb8, face)[0])
        labels.append(has_wing)
    found, there = np.array(scores) >= WING_FROM, np.array(labels)
    return (
        f"area under curve {area_under_curve(np.array(scores), there):.3f}; a wing is read in "
        f"{found[there].sum()} of {there.sum()} with one, {found[~there].sum()} of "
        f"{(~there).sum()} without"
    )


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--looks", type=existing, required=True)
    print(evaluate(parser.parse_args().looks))
