"""Measures on real faces how well the product detects which makeup is worn; fits the calibration.

    python -m makeup_video.training.worn.evaluate runs/makeup.onnx runs/check.npz runs/looks.npz

For each label the command measures the net, the colours, and both together. It prints the area
under the ROC curve, the share of bare faces read as made up when nine of ten clearly made-up faces
are found, and the share of clearly made-up faces found when 15 % of bare faces are read as made up.
The scales and the shift turn log-odds into probabilities (Platt 1999).
"""

import argparse
from pathlib import Path

import numpy as np
from makeup_video.pipeline.reference.makeup_input import mirrored
from makeup_video.training.faces.infer import from_onnx
from makeup_video.training.inputs import existing
from makeup_video.training.worn.prepare import LABELS
from makeup_video.training.worn.scores import UNKNOWN, area_under_curve, logistic

FOUND, ALARMS = 0.9, 0.15
_RIDGE = 1e-3


def log_odds(net: Path, inputs: np.ndarray) -> np.ndarray:
    """(N, labels): the mean over each picture and its mirror image, as in the product."""
    run = from_onnx(net)  # -> log_odds, numbers
    runs = [
        run(both[at : at + 64])[0]
        for both in (inputs, mirrored(inputs))
        for at in range(0, len(inputs), 64)
    ]
    one, other = np.concatenate(runs).reshape(2, len(inputs), -1)
    mean: np.ndarray = (one + other) / 2
    return mean


def calibrated(scores: np.ndarray, is_worn: np.ndarray) -> np.ndarray:
    """(N + 1,): the scales of scores (M, N) and the shift that make the labels most probable.

    No scale is negative: a score whose scale would be negative is left out, with a scale of 0.
    """
    columns = list(range(scores.shape[1]))
    while True:
        rows = np.column_stack([scores[:, columns], np.ones(len(scores))])
        found = logistic(rows, is_worn, ridge=_RIDGE)
        if (found[:-1] >= 0).all():
            break
        columns.pop(int(np.argmin(found[:-1])))
    whole = np.zeros(scores.shape[1] + 1)
    whole[[*columns, -1]] = found
    return whole


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("net", type=existing)
    parser.add_argument("sets", type=existing, nargs="+")
    parser.add_argument("--ratio", nargs=2, action="append", default=[], metavar=("LABEL", "RATIO"),
                        help="of the net's scale to the colours', if not to be fitted")  # fmt: skip
    options = parser.parse_args()
    try:
        ratios = {name: float(ratio) for name, ratio in options.ratio}
    except ValueError as error:
        parser.error(f"--ratio takes a label and a number: {error}")
    if unknown := sorted(ratios.keys() - set(LABELS)):
        parser.error(f"--ratio is for {', '.join(LABELS)}, got {unknown[0]}")
    packed = [np.load(path) for path in options.sets]
    labels = np.concatenate([data["labels"] for data in packed])
    by_net = log_odds(options.net, np.concatenate([data["inputs"] for data in packed]))
    by_colours = np.concatenate([data["colours"] for data in packed])
    for column, name in enumerate(LABELS):
        known = labels[:, column] != UNKNOWN
        worn = labels[known, column] == 1
        if not worn.any() or worn.all():
            continue
        scores = np.stack([by_net[known, column], by_colours[known, column]], 1)
        if name in ratios:
            scale, shift = calibrated(scores @ [[ratios[name]], [1.0]], worn)
            scales = [scale * ratios[name], scale]
        else:
            *scales, shift = calibrated(scores, worn)
        both = scores @ scales + shift
        print(f"{name:7s} {worn.sum():4d} worn, {(~worn).sum():4d} bare; scales "
              f"{scales[0]:.3f} (net), {scales[1]:.3f} (colours), shift {shift:.3f}")  # fmt: skip
        for title, score in (("net", scores[:, 0]), ("colours", scores[:, 1]), ("both", both)):
            print(f"  {title:8s}{_measures(score, worn)}")


def _measures(score: np.ndarray, worn: np.ndarray) -> str:
    area, threshold = area_under_curve(score, worn), np.quantile(score[worn], 1 - FOUND)
    alarms = float((score[~worn] >= threshold).mean())
    at = np.quantile(score[~worn], 1 - ALARMS)
    return (
        f"area {area:.3f}; {alarms:.0%} false alarms where {FOUND:.0%} are found; "
        f"{float((score[worn] >= at).mean()):.0%} found at {ALARMS:.0%} false alarms "
        f"(probability {1 / (1 + np.exp(-at)):.2f})"
    )


if __name__ == "__main__":
    main()
