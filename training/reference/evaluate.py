"""Measure a reference net on people and products that it never saw.

    python -m makeup_video.training.reference.evaluate lips runs/lips-lite0.pt --shades lip_shades.csv

What counts is what it is for: the estimated look and the true one, painted on another bare person,
and compared there.
"""

import argparse
import os
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import torch
from makeup_video.pipeline.finishes import REGIONS
from makeup_video.pipeline.reference_io import from_targets
from makeup_video.training.faces.infer import from_onnx
from makeup_video.training.reference.export import load
from makeup_video.training.reference.render import Renderer, Shot, renderer
from makeup_video.training.reference.shades import (
    draw_settings,
    finish_of,
    look_of,
    settings_of,
)
from makeup_video.training.reference.train import estimates, report
from scipy.stats import spearmanr
from skimage.color import deltaE_ciede2000, rgb2lab

COUNT = 300
Estimate = Callable[[np.ndarray], np.ndarray]


def net_of(path: Path) -> Estimate:
    """(N, H, W, 3) uint8 -> (N, 7) numbers of a look, by a checkpoint or an exported net."""
    if path.suffix == ".onnx":
        run = from_onnx(path)
        return lambda rgb8: from_targets(run(rgb8)[0])
    net = load(path)[1].to(memory_format=torch.channels_last)
    return lambda rgb8: from_targets(estimates(net, torch.from_numpy(rgb8)).numpy())


def where_painted(one: Renderer, shot: Shot, zone: str) -> np.ndarray:
    """(H, W) bool: px of a cut that wear at least half of the product."""
    height, width = shot.codes.shape[:2]
    face, total = shot.scene.faces[0], np.zeros((height, width), np.float32)
    parts = face.eyes if one.region == "eyes" else (face.lips,)
    for lit in parts:
        weight = np.empty_like(total)
        lit.region.weigh(weight, (0, 0), 0.5, zone)
        np.maximum(total, weight, out=total)
    return total >= 0.5


def difference(a: np.ndarray, b: np.ndarray, where: np.ndarray) -> float:
    """Mean CIEDE2000 of two (H, W, 3) uint8 pictures over some px."""
    return float(deltaE_ciede2000(rgb2lab(a[where]), rgb2lab(b[where])).mean())


def measure(one: Renderer, net: Estimate, count: int) -> None:
    rng, people = one.rng, len(one.people)
    crops, true, settings, zones, wearers = [], [], [], [], []
    for values in one.products.draw(count, rng):
        wearer, zone = int(rng.choice(people, p=one.people.share)), one.zone()
        shot, rest = one.shoot(wearer), draw_settings(values, one.region, rng)
        painted = one.paint(shot, look_of(values, rest, one.region, zone))
        crops.append(one.see(shot, painted))
        true.append(values)
        settings.append(rest)
        zones.append(zone)
        wearers.append(wearer)
    told = net(np.stack(crops))
    print("mean errors:", report(told, np.array(true)))
    gloss = spearmanr(told[:, 4], np.array(true)[:, 4]).statistic
    print(f"gloss: rank correlation {gloss:.3f}")
    rows = []
    for values, rest, zone, wearer, guess in zip(true, settings, zones, wearers, told, strict=True):
        other = (wearer + 1 + int(rng.integers(people - 1))) % people
        shot = one.shoot(other)
        where = where_painted(one, shot, zone)
        if where.sum() < 20:  # eyes almost shut, lips of a thin line
            continue
        wanted = one.paint(shot, look_of(values, rest, one.region, zone))
        finish = settings_of(finish_of(guess, one.region), one.region)
        got = one.paint(shot, look_of(guess, finish, one.region, zone))
        bare = one.paint(shot, look_of(np.zeros(7), finish, one.region, zone))
        rows.append([difference(got, wanted, where), difference(bare, wanted, where)])
    for name, off in zip(("estimated", "left bare"), np.array(rows).T, strict=True):
        median, most = np.quantile(off, (0.5, 0.9))
        print(
            f"CIEDE2000 to the true look, {name}: median {median:.2f}, 90 % {most:.2f} ({len(off)})"
        )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("region", choices=REGIONS)
    parser.add_argument("net", type=Path, help="a checkpoint, or an .onnx of export")
    parser.add_argument("--data", type=Path, default=Path("runs/reference.npz"))
    parser.add_argument("--shades", type=Path, required=True)
    parser.add_argument("--count", type=int, default=COUNT)
    options = parser.parse_args()
    os.environ["POCL_MAX_PTHREAD_COUNT"] = "1"
    cv2.setNumThreads(1)
    one = renderer(options.data, options.shades, options.region, "test", seed=2, varied=False)
    measure(one, net_of(options.net), options.count)


if __name__ == "__main__":
    main()
