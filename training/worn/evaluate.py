"""Measures the net that tells what is worn on real faces, and fits its calibration.

    python -m makeup_video.training.worn.evaluate runs/worn.onnx runs/check.npz runs/looks.npz

Prints for each label the area under the ROC curve, the share of bare faces that are called worn
where nine of ten clear ones are found, and the scale and shift that turn log-odds into
probabilities: a logistic model of one number (Platt 1999).
"""

import argparse
from pathlib import Path

import numpy as np
import onnxruntime
from makeup_video.training.worn.crops import mirrored
from makeup_video.training.worn.prepare import LABELS
from makeup_video.training.worn.scores import UNKNOWN, area_under_curve

FOUND = 0.9
_STEPS, _RATE = 4000, 0.05  # of the calibration's descent


def log_odds(net: Path, inputs: np.ndarray) -> np.ndarray:
    """(N, labels): the mean over each picture and its mirror image, as the product takes it."""
    session = onnxruntime.InferenceSession(str(net), providers=["CPUExecutionProvider"])
    runs = [
        session.run(None, {"rgb8": both[at : at + 64]})[0]
        for both in (inputs, mirrored(inputs))
        for at in range(0, len(inputs), 64)
    ]
    one, other = np.concatenate(runs).reshape(2, len(inputs), -1)
    mean: np.ndarray = (one + other) / 2
    return mean


def calibrated(scores: np.ndarray, is_worn: np.ndarray) -> tuple[float, float]:
    """Scale and shift of log-odds by which the labels are most probable."""
    scale, shift = 1.0, 0.0
    for _ in range(_STEPS):
        off = 1 / (1 + np.exp(-(scale * scores + shift))) - is_worn
        scale -= _RATE * float((off * scores).mean())
        shift -= _RATE * float(off.mean())
    return scale, shift


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("net", type=Path)
    parser.add_argument("sets", type=Path, nargs="+")
    options = parser.parse_args()
    packed = [np.load(path) for path in options.sets]
    inputs = np.concatenate([data["inputs"] for data in packed])
    labels = np.concatenate([data["labels"] for data in packed])
    scores = log_odds(options.net, inputs)
    for column, name in enumerate(LABELS):
        known = labels[:, column] != UNKNOWN
        worn, score = labels[known, column] == 1, scores[known, column]
        if not worn.any() or worn.all():
            continue
        threshold = np.quantile(score[worn], 1 - FOUND)
        alarms = float((score[~worn] >= threshold).mean())
        scale, shift = calibrated(score, worn)
        print(
            f"{name:7s} {worn.sum():4d} worn, {(~worn).sum():4d} bare: area "
            f"{area_under_curve(score, worn):.3f}, {alarms:.0%} false alarms at {threshold:.2f} "
            f"(p {1 / (1 + np.exp(-scale * threshold - shift)):.2f}); "
            f"scale {scale:.3f}, shift {shift:.3f}"
        )


if __name__ == "__main__":
    main()
