"""Measures how well the shimmer of eyeshadow is read in real photos.

    python -m makeup_video.training.worn.evaluate_shimmer --looks DIR...

The folders have the photos of people with makeup that shimmer_of_looks.csv names. Two people rated
how much the upper lids shimmer in each: 0 matte, 1 satin, 2 shimmer or metal, 3 glitter. The file
has the means.
"""

import argparse
from pathlib import Path

import numpy as np
from makeup_video.pipeline.reference.lid_shimmer import fine_highlights, lids_of
from makeup_video.pipeline.reference.photo_light import photo_light
from makeup_video.training.inputs import existing
from makeup_video.training.worn.real_photos import estimated
from makeup_video.training.worn.scores import agreement
from makeup_video.training.worn.table import photos_of

_LABELS = Path(__file__).with_name("shimmer_of_looks.csv")
_CLEARLY = 1.5  # from this mean on, at least one of the two people saw shimmer, a rating of 2


def evaluate(folders: list[Path]) -> str:
    labels = photos_of(_LABELS, folders)
    seen, measured, painted = [], [], []
    for path, photo, one in estimated(list(labels)):
        lids = lids_of(photo.rgb8, photo.face, photo_light(photo.rgb8, photo.face))
        if lids is not None:
            seen.append(float(labels[path]["shimmer"]))
            measured.append(fine_highlights(lids))
            shadows = one.look.of("eyeshadow")
            painted.append(any(layer.product.shimmer > 0 for layer in shadows))
    if not seen:
        raise SystemExit(f"--looks: these folders have no photo that {_LABELS.name} names")
    true, shines = np.array(seen), np.array(painted)
    clear = true >= _CLEARLY
    said = agreement(f"{len(true)} photos, fine highlights", np.array(measured), true)
    return (
        f"{said}\npainted with shimmer: {shines[clear].sum()} of {clear.sum()} that clearly "
        f"shimmer, {shines[~clear].sum()} of {(~clear).sum()} others"
    )


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--looks", type=existing, nargs="+", required=True)
    print(evaluate(parser.parse_args().looks))
