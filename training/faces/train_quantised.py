"""Trains a net further with rounded weights and activations, so that int8 loses nothing.

    python -m makeup_video.training.faces.train_quantised lips --checkpoints runs --samples 1e5

The teacher is the float net: on a crop with camera noise, the rounded net must output what the
teacher outputs on the clean crop. So rounding adds no jitter. The command writes NET_int8.pt.

`--samples 0 --fit 2` trains nothing, but searches twice for the ranges that differ least from the
teacher.
"""

import argparse
import copy
import itertools
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import torch
from makeup_video.training.faces.crops import SPECS, Cropper, Faces
from makeup_video.training.faces.detector_pictures import Scenes
from makeup_video.training.faces.export import load
from makeup_video.training.faces.fake_quantise import KEPT, STEPS, rounded, roundings
from makeup_video.training.faces.model import normalise
from makeup_video.training.inputs import existing, made_by
from torch import Tensor, nn
from torch.utils.data import DataLoader, IterableDataset

BATCH, SCENE_BATCH = 48, 12
WATCHED, FITTED = 12, 3  # batches that set the ranges, and batches to fit them on
NOISE_SIGMA = 4.0  # code values, the largest sigma
CUTS = (1, 0.85, 0.7, 0.55, 0.4, 0.3, 0.2)  # shares of a range to try
SURE = 9.0  # log-odds; beyond them a difference cannot be seen
Outputs = Tensor | tuple[Tensor, ...]


class Stream(IterableDataset):
    def __init__(self, data: Path, name: str, seed: int) -> None:
        self.data, self.name, self.seed = data, name, seed

    def __iter__(self) -> Iterator[tuple[Tensor, Tensor]]:
        """Endless crops (N, H, W, 3) uint8, clean and noisy."""
        torch.set_num_threads(1)
        rng = np.random.default_rng(self.seed)
        for rgb8 in self._crops(Faces(self.data, False)):
            yield torch.from_numpy(rgb8), torch.from_numpy(noisy(rgb8, rng))

    def _crops(self, faces: Faces) -> Iterator[np.ndarray]:
        if self.name != "detector":
            cropper = Cropper(faces, SPECS[self.name], seed=self.seed)
            yield from (batch.rgb8 for batch in cropper.stream(BATCH))
        scenes = Scenes(faces, seed=self.seed)
        while True:
            yield np.stack([scenes.draw()[0] for _ in range(SCENE_BATCH)])


def noisy(rgb8: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Crops (N, H, W, 3) uint8 with a camera's noise: grey and coloured."""
    n, h, w, _ = rgb8.shape
    sigma = rng.uniform(0, NOISE_SIGMA, (n, 1, 1, 1)).astype(np.float32)
    grain = rng.standard_normal((n, h, w, 3), np.float32)
    grain += rng.standard_normal((n, h, w, 1), np.float32)
    return np.clip(np.rint(rgb8 + 0.7 * sigma * grain), 0, 255).astype(np.uint8)


def codes(rgb8: Tensor) -> Tensor:
    """Crops (N, H, W, 3) uint8 -> the input (N, 3, H, W) of a rounded net."""
    return (rgb8.permute(0, 3, 1, 2).float() - 128) / 127.5


def difference(name: str, ours: Outputs, wanted: Outputs) -> Tensor:
    """The difference between the outputs of a rounded net and of its teacher."""
    if name == "detector":
        near, off = wanted[:, :1].sigmoid(), (ours - wanted).abs()
        score = (ours[:, :1].sigmoid() - near).abs().mean() + 0.02 * off[:, :1].mean()
        return score + (off[:, 1:] * near).sum() / near.sum().clamp(min=1)
    off = (ours[0] - wanted[0]).square()
    loss = (off[..., :2].sum(-1) + 0.1 * off[..., 2] + 1e-8).sqrt().mean()
    if name == "mesh":
        chances = wanted[1].sigmoid()
        loss = loss + 0.02 * nn.functional.binary_cross_entropy_with_logits(ours[1], chances)
    if name == "lips":
        mask, target = (x[2].clamp(-SURE, SURE) for x in (ours, wanted))
        weight_off = (mask.sigmoid() - target.sigmoid()).square().mean().sqrt()
        loss = loss + 0.05 * weight_off + 0.002 * (mask - target).abs().mean()
    return loss


@torch.no_grad()
def fit_ranges(name: str, teacher: nn.Module, net: nn.Module, rgb8: Tensor) -> None:
    """Narrows each range if that brings the outputs for rgb8 (N, H, W, 3) closer to the teacher's.

    Few values lie far out, and values that a ReLU cuts off after a sum need not be exact.
    """
    wanted, x = teacher(normalise(rgb8)), codes(rgb8).contiguous(memory_format=torch.channels_last)
    least = difference(name, net(x), wanted)
    for rounding in reversed(roundings(net)):
        low, high = -rounding.zero * rounding.scale, (STEPS - rounding.zero) * rounding.scale
        best = low, high
        for share, other in itertools.product(CUTS if rounding.signed else (1,), CUTS):
            rounding.set_range(low * share, high * other)
            off = difference(name, net(x), wanted)
            if off < least:
                least, best = off, (rounding.lowest.clone(), rounding.highest.clone())
        rounding.set_range(*best)
    print(f"ranges fitted: {float(least):.5f} off", flush=True)


def prepare(net: nn.Module) -> None:
    """Sets a net to learn on its final outputs: without dropout, and with the log-odds of lipstick
    instead of mouth, opening and teeth."""
    net.train()
    net.training = False
    for part in net.modules():
        if isinstance(part, nn.Dropout):
            part.p = 0.0
        if isinstance(part, nn.BatchNorm2d):  # in a part that stays float
            part.eval()


def learn(name: str, teacher: nn.Module, net: nn.Module, crops: Iterator, options) -> None:
    steps_of = [rounding.scale for rounding in roundings(net)]
    rest = [value for key, value in net.named_parameters() if not key.endswith(".scale")]
    optimizer = torch.optim.Adam([{"params": rest}, {"params": steps_of}])
    began, losses, seen, step = time.time(), [], 0, 0
    while seen < options.samples:
        rate = options.rate * min(1, (step + 1) / 50, 1.6 * (1 - seen / options.samples) + 1e-3)
        for group, share in zip(optimizer.param_groups, (1, 0.2), strict=True):
            group["lr"] = rate * share
        clean, worse = next(crops)
        with torch.no_grad():
            wanted = teacher(normalise(clean).contiguous(memory_format=torch.channels_last))
        ours = net(codes(worse).contiguous(memory_format=torch.channels_last))
        loss = difference(name, ours, wanted)
        optimizer.zero_grad(set_to_none=True)
        loss.backward()
        nn.utils.clip_grad_norm_(rest, 1.0)
        optimizer.step()
        losses.append(loss.item())
        seen, step = seen + len(clean), step + 1
        if step % 100 == 0:
            speed = seen / (time.time() - began)
            print(f"step {step} loss {np.mean(losses):.5f} {speed:.0f}/s", flush=True)
            losses.clear()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("net", choices=[*SPECS, "detector"])
    parser.add_argument("--checkpoints", type=existing, default="runs")
    parser.add_argument("--data", type=made_by("faces.prepare"), default="runs/faces.npz")
    parser.add_argument("--samples", type=float, default=1e5, help="0: only set the ranges")
    parser.add_argument("--fit", type=int, default=0, help="how often to fit the ranges")
    parser.add_argument("--rate", type=float, default=3e-5)
    parser.add_argument(
        "--beyond", type=float, default=1e-4, help="share of values beyond the ranges"
    )
    options = parser.parse_args()
    torch.set_num_threads(1)  # the other core draws crops
    name, teacher = load(options.checkpoints / f"{options.net}.pt")
    net = rounded(copy.deepcopy(teacher), KEPT.get(name, ()))
    net.to(memory_format=torch.channels_last)
    stream = Stream(options.data, name, seed=99)
    crops = iter(DataLoader(stream, None, num_workers=1, prefetch_factor=8))
    for rounding in roundings(net):
        rounding.beyond = options.beyond
    with torch.no_grad():
        for _ in range(WATCHED):
            net(codes(next(crops)[0]))
    for rounding in roundings(net):
        rounding.settle()
    fitted_on = torch.cat([next(crops)[0] for _ in range(FITTED)]) if options.fit else None
    for _ in range(options.fit):
        fit_ranges(name, teacher, net, fitted_on)
    prepare(net)
    learn(name, teacher.to(memory_format=torch.channels_last), net, crops, options)
    torch.save(net.state_dict(), options.checkpoints / f"{name}_int8.pt")


if __name__ == "__main__":
    main()
