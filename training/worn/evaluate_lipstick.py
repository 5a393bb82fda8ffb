"""Measures how well the gloss and the fade of lipstick are read in real photos.

    python -m makeup_video.training.worn.evaluate_lipstick --looks DIR...

The folders have the photos of people with makeup that lipsticks_of_looks.csv names. Two people
labelled the gloss and the fade in each photo, on the scales of read_lipstick.py. The file has the
means.
"""

import argparse
from pathlib import Path

import numpy as np
from makeup_video.pipeline.reference.read_lipstick import lipstick_numbers
from makeup_video.training.inputs import existing
from makeup_video.training.worn.mouth import NUMBERS
from makeup_video.training.worn.real_photos import labelled_layers
from makeup_video.training.worn.scores import agreement

_LABELS = Path(__file__).with_name("lipsticks_of_looks.csv")


def evaluate(folders: list[Path]) -> str:
    seen, returned, painted = [], [], []
    for row, photo, layer in labelled_layers(_LABELS, folders, "lipstick"):
        seen.append([float(row[name]) for name in NUMBERS])
        returned.append(lipstick_numbers(photo.rgb8, photo.face))
        painted.append((layer.product.gloss, layer.whole_shape["gradient"]))
    lines = [f"{len(seen)} photos on which lipstick is read"]
    by_number = zip(NUMBERS, *(np.array(each).T for each in (seen, returned, painted)), strict=True)
    for name, true, by_net, as_painted in by_number:
        lines.append(agreement(f"{name}, as the net returns it", by_net, true))
        painted_as_seen = np.corrcoef(as_painted, true)[0, 1]
        lines.append(f"{name}, as it is painted: correlation {painted_as_seen:.2f}")
    return "\n".join(lines)


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--looks", type=existing, nargs="+", required=True)
    print(evaluate(parser.parse_args().looks))
