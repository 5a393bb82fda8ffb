"""Draws products: with numbers like those of real products, and with random numbers.

    python -m makeup_video.training.reference.draw_products lips \\
        --shades lip_shades.csv --plot shades.png

A shade table is a CSV with the columns brand, product, shade, hex and finish. Its colours are web
swatches and its finishes words, so the fit describes how products vary, not single products.
"""

import argparse
import csv
import zlib
from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from makeup_video.pipeline.look.finishes import FINISHES, nearest_finish
from makeup_video.pipeline.look.look import ZONES, Look
from makeup_video.pipeline.look.params import GraphicsParams
from makeup_video.pipeline.reference.crops import CROPPED, NUMBERS
from makeup_video.training.inputs import existing

COLOUR = slice(NUMBERS.index("red"), NUMBERS.index("blue") + 1)
COLOUR_SEEN = 0.4  # least opacity at which the colour of a product can be read
# Largest values of NUMBERS; all begin at 0.
MOST = np.array([1, 255, 255, 255, 4, 1, 1], np.float64)
_WORDS = {"glitter": "shimmer", "retro matte": "matte", "lustre": "satin"}
# True: bounded on both sides, and about normal as log-odds. False: often 0, and about normal as
# square roots.
_ODDS = np.array([True, True, True, True, False, True, False])
_EDGE = 0.5 / 256  # a share that is closer to 0 or 1 counts as this close
# How much products of one finish differ, one sigma, in that space; for colours, the error of
# swatches.
_SPREAD = np.array([0.5, 0.15, 0.15, 0.15, 0.2, 0.5, 0.12])
# Shares of the mixture: products with random numbers, and unworn ones. The rest is like real
# products.
UNIFORM, BARE = 0.4, 0.08
_EXTREME = 0.2  # share of products with random numbers among those never trained on
_SETTING_SPREAD = 0.1  # one sigma, of the other settings around those of a finish
_OTHER_FINISH = 0.15  # share of draws with the settings of a random finish
SPLITS = ("train", "validation", "test")
_EIGHTHS = (6, 1, 1)  # of the shades, in each split


@dataclass(frozen=True)
class Products:
    """Products of a shade table.

    values: (N, 7), the NUMBERS of each product's colour and finish. split: (N,) index into SPLITS.
    """

    values: np.ndarray
    split: np.ndarray


def read_products(path: Path, region: str) -> Products:
    """Reads a shade table. A product without a finish gets one, drawn as often as it occurs."""
    with path.open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    words = [_WORDS.get(row["finish"], row["finish"]) for row in rows]
    said = Counter(word for word in words if word in FINISHES)
    rng = np.random.default_rng(0)
    guesses = rng.choice(list(said), len(rows), p=np.array(list(said.values())) / said.total())
    values, split = [], []
    for row, word, guess in zip(rows, words, guesses, strict=True):
        finish = FINISHES[word if word in FINISHES else str(guess)][region]
        rgb = bytes.fromhex(row["hex"].lstrip("#"))
        given = dict(zip(("red", "green", "blue"), rgb, strict=True))
        values.append([{**finish, **given}[name] for name in NUMBERS])
        key = zlib.crc32("/".join(row[part] for part in ("brand", "product", "shade")).encode())
        split.append(int(np.searchsorted(np.cumsum(_EIGHTHS), key % 8, side="right")))
    return Products(np.array(values, np.float64), np.array(split))


def to_normal(values: np.ndarray) -> np.ndarray:
    """Numbers (N, 7) -> (N, 7) values that are about normally distributed."""
    part = values / MOST
    inside = part.clip(_EDGE, 1 - _EDGE)
    return np.where(_ODDS, np.log(inside / (1 - inside)), np.sqrt(values))


def from_normal(normal: np.ndarray) -> np.ndarray:
    """The inverse of to_normal; always in range, with 0 for what would be negative."""
    part = (1 / (1 + np.exp(-normal)) - _EDGE) / (1 - 2 * _EDGE)
    values = np.where(_ODDS, part * MOST, np.maximum(normal, 0) ** 2)
    return values.clip(0, MOST)


class Mixture:
    """Draws products like real ones, products with random numbers, and a few that are not worn."""

    def __init__(self, values: np.ndarray) -> None:
        """values: (N, 7) to fit the normal distribution to."""
        normal = to_normal(values)
        self.mean = normal.mean(0)
        covariance = np.cov(normal.T) + np.diag(_SPREAD**2)
        self._root = np.linalg.cholesky(covariance)

    def real(self, n: int, rng: np.random.Generator) -> np.ndarray:
        """(n, 7) numbers like those of real products."""
        return from_normal(self.mean + rng.normal(size=(n, len(NUMBERS))) @ self._root.T)

    def any(self, n: int, rng: np.random.Generator) -> np.ndarray:
        """(n, 7) numbers, uniform over the whole range."""
        return rng.random((n, len(NUMBERS))) * MOST

    def draw(self, n: int, rng: np.random.Generator) -> np.ndarray:
        """(n, 7) numbers of the mixture."""
        kind = rng.random((n, 1))
        values = np.where(kind < UNIFORM, self.any(n, rng), self.real(n, rng))
        unworn = np.isin(NUMBERS, ("opacity", "gloss", "reflection"))
        return np.where((kind > 1 - BARE) & unworn, 0, values)


class RealProducts:
    """Draws products of a shade table, each slightly off its finish, for looks never trained on."""

    def __init__(self, values: np.ndarray) -> None:
        self._normal = to_normal(values)

    def draw(self, n: int, rng: np.random.Generator) -> np.ndarray:
        """(n, 7) numbers."""
        chosen = self._normal[rng.integers(len(self._normal), size=n)]
        real = from_normal(chosen + rng.normal(size=chosen.shape) * _SPREAD)
        extreme = rng.random((n, len(NUMBERS))) * MOST
        return np.where(rng.random((n, 1)) < _EXTREME, extreme, real)


def finish_of(values: np.ndarray, region: str) -> str:
    """The finish closest to (7,) numbers."""
    named = dict(zip(NUMBERS, values.tolist(), strict=True))
    words = ("opacity", "gloss", "gloss_roughness", "reflection")
    return nearest_finish(*(named[word] for word in words), region)


def settings_of(finish: str, region: str) -> dict[str, float]:
    """The ten other settings of a finish."""
    return {key: value for key, value in FINISHES[finish][region].items() if key not in NUMBERS}


def draw_settings(values: np.ndarray, region: str, rng: np.random.Generator) -> dict[str, float]:
    """Ten settings that fit (7,) numbers: mostly around those of the nearest finish."""
    finish = finish_of(values, region)
    if rng.random() < _OTHER_FINISH:
        finish = list(FINISHES)[rng.integers(len(FINISHES))]
    settings = settings_of(finish, region)
    kept = {"light_adaptation"}  # otherwise the photo would not show the product's colour
    if not settings["shimmer"]:
        kept |= {"shimmer"}
    for name, value in settings.items():  # not a set: its order would differ from run to run
        if name not in kept:
            settings[name] = float(np.clip(value + rng.normal() * _SETTING_SPREAD, 0, 1))
    return settings


def look_of(
    values: np.ndarray, settings: dict[str, float], region: str, zone: str = ZONES[0]
) -> Look:
    """A look of one product, (7,) numbers and ten settings, on one region."""
    numbers = dict(zip(NUMBERS, np.asarray(values, np.float64).tolist(), strict=True))
    params = GraphicsParams(**numbers, **settings)
    products: dict[str, Any] = {region: params}
    return Look(**products, zone=zone)


def number_errors(true: np.ndarray, estimated: np.ndarray) -> np.ndarray:
    """(7,) mean absolute errors; those of colours only where the colours show."""
    off, shows = np.abs(estimated - true), true[:, 0] >= COLOUR_SEEN
    errors = off.mean(0)
    errors[COLOUR] = off[shows, COLOUR].mean(0) if shows.any() else np.nan
    return errors


def errors_in_words(true: np.ndarray, estimated: np.ndarray) -> str:
    """The mean absolute errors on one line."""
    errors = zip(NUMBERS, number_errors(true, estimated), strict=True)
    return ", ".join(f"{name} {error:.3g}" for name, error in errors)


def plot(mixture: Mixture, path: Path, n: int = 4000) -> None:
    """Plots the distribution of each number in both parts of the mixture, and the drawn colours."""
    import matplotlib.pyplot as plt

    rng = np.random.default_rng(0)
    real, uniform = mixture.real(n, rng), mixture.any(n, rng)
    figure, axes = plt.subplots(3, 3, figsize=(11, 8), layout="constrained")
    for axis, name, a, b, most in zip(axes.flat, NUMBERS, real.T, uniform.T, MOST, strict=False):
        bins = np.linspace(0, most, 41)
        axis.hist(a, bins, density=True, alpha=0.6, label="as real products")
        axis.hist(b, bins, density=True, alpha=0.4, label="uniform")
        axis.set_title(name)
        axis.set_yticks([])
    axes.flat[0].legend()
    for axis, values, title in zip(axes.flat[7:], (real, uniform), ("real", "any"), strict=True):
        axis.imshow(values[:384, 1:4].reshape(16, 24, 3) / 255)
        axis.set_title(f"colours, {title}")
        axis.axis("off")
    figure.savefig(path, dpi=110)
    plt.close(figure)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("region", choices=CROPPED)
    parser.add_argument("--shades", type=existing, required=True)
    parser.add_argument("--plot", type=Path, default=Path("runs/shades.png"))
    options = parser.parse_args()
    products = read_products(options.shades, options.region)
    counts = np.bincount(products.split, minlength=3)
    print(", ".join(f"{count} {name}" for count, name in zip(counts, SPLITS, strict=True)))
    options.plot.parent.mkdir(parents=True, exist_ok=True)
    plot(Mixture(products.values[products.split == 0]), options.plot)


if __name__ == "__main__":
    main()
