"""Fits two constants of pipeline/render/skin_light.py: mean and covariance of skin in white light.

    python -m makeup_video.training.skin_light shades.csv --faces portraits

shades.csv: foundation shades with a column `hex`, sRGB. The shades show how skin varies.
portraits: a folder of pictures of people of every skin tone in soft, white light, and labels.npz
with the pictures' names and points. The pictures show the average skin, which is darker and paler
in a picture than in a swatch. Every lightness has the same weight: otherwise dark skin would hardly
count.
"""

import argparse
import csv
from pathlib import Path

import cv2
import numpy as np
from makeup_video.kernels.colour import SRGB, to_linear, to_xyz
from makeup_video.pipeline.frames.frame import coding_of
from makeup_video.pipeline.frames.rgb import to_frame
from makeup_video.pipeline.render.skin_light import optics_of, read_skin
from makeup_video.training.inputs import existing

LIGHTNESSES = 30, 85  # CIE L*; swatches outside this range are not of skin
BINS = 11  # of lightness, 5 L* each
KEPT = 0.9  # share of the shades; the others are errors in shops' pictures
FEWEST = 10  # a lightness with fewer faces does not count
FACES = 800  # read at most


def shades(path: Path) -> np.ndarray:
    """Log linear light (N, 3) of the shades in a CSV file."""
    with path.open() as file:
        codes = [row["hex"].lstrip("#") for row in csv.DictReader(file)]
    encoded = np.array([list(bytes.fromhex(code)) for code in codes]) / 255
    return np.log(np.maximum(to_linear(encoded, SRGB), 1e-3))


def lightness(log_linear: np.ndarray) -> np.ndarray:
    """CIE L* (N,) of log linear light (N, 3)."""
    luminance: np.ndarray = np.exp(log_linear) @ to_xyz(1)[1]
    return 116 * np.cbrt(luminance) - 16


def fit_covariance(log_linear: np.ndarray) -> np.ndarray:
    """Covariance (3, 3) of shades, without the tenth that is furthest from the mean.

    Every lightness has the same weight.
    """
    low, high = LIGHTNESSES
    light = lightness(log_linear)
    within = (light >= low) & (light < high)
    log_linear = log_linear[within]
    bins = ((light[within] - low) / (high - low) * BINS).astype(int)
    kept = np.ones(len(bins), bool)
    for _ in range(8):
        weight = kept / np.maximum(np.bincount(bins[kept], minlength=BINS), 1)[bins]
        off = log_linear - np.average(log_linear, axis=0, weights=weight)
        covariance = np.cov(log_linear.T, aweights=weight)
        distance = np.einsum("ni,ij,nj->n", off, np.linalg.inv(covariance), off)
        kept = distance <= np.quantile(distance, KEPT)
    return covariance


def faces(folder: Path) -> np.ndarray:
    """Log linear light (N, 3) of the skin in pictures with reliable labels."""
    labels = np.load(folder / "labels.npz")
    sure = np.flatnonzero(labels["spread"] < 1.5)
    chosen = np.random.default_rng(0).permutation(sure)[:FACES]
    found = []
    for name, points in zip(labels["name"][chosen], labels["points"][chosen], strict=True):
        frame = to_frame(cv2.imread(str(folder / name)))
        found.append(read_skin(points.astype(np.float32), frame, optics_of(coding_of(frame))))
    return np.array([skin.log for skin in found if skin is not None])


def fit_mean(log_linear: np.ndarray) -> np.ndarray:
    """Mean (3,) of faces, taken over the means of all lightnesses, in steps of 5 L*."""
    bins = (lightness(log_linear) // 5).astype(int)
    means = [log_linear[bins == b].mean(0) for b in np.unique(bins) if (bins == b).sum() >= FEWEST]
    return np.mean(means, 0)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("shades", type=existing, help="CSV with a column `hex`")
    parser.add_argument("--faces", type=existing, required=True, help="folder with labels.npz")
    options = parser.parse_args()
    print("SKIN_MEAN =", repr(fit_mean(faces(options.faces)).round(3)))
    print("SKIN_COVARIANCE =", repr(fit_covariance(shades(options.shades)).round(4)))


if __name__ == "__main__":
    main()
