"""Trains the net that reads the form of an eyeliner, and exports it.

    python -m makeup_video.training.worn.train_liner --data runs/liners.npz \
        --out runs/reference_liner.onnx

The last tenth of the painted corners is held out. The crops of one face stay together.
"""

import argparse
from pathlib import Path

import numpy as np
import torch
from makeup_video.pipeline.reference.read_liner import CORNER_WH
from makeup_video.training.worn import form_net
from makeup_video.training.worn.corner import NUMBERS, Corner
from makeup_video.training.worn.form_net import Examples, FormNet, learn, numbers_of, parser_of
from makeup_video.training.worn.scores import area_under_curve
from makeup_video.training.worn.vary_corners import varied
from torch import Tensor, nn
from torch.nn import functional

# Shares of a batch: painted corners, real ones without a known wing, and real ones with a wing.
SHARES = 0.72, 0.22, 0.06
# Weights of the losses, in the order of NUMBERS.
WEIGHTS = (1.0, 2.0, 4.0, 2.0, 8.0)
_LIKELY = np.array([name in ("liner", "wing") for name in NUMBERS])  # which are log-odds


class LinerNet(FormNet):
    """Corners (N, 72, 112, 3) uint8 -> (N, 4): all of NUMBERS but the liner."""

    def __init__(self) -> None:
        super().__init__(len(NUMBERS))

    def forward(self, rgb8: Tensor) -> Tensor:
        return self.all_numbers(rgb8)[:, 1:]

    def all_numbers(self, rgb8: Tensor) -> Tensor:
        """(N, 5): first the log-odds of liner, which only help the training, then the others."""
        return super().forward(rgb8)


def loss_of(found: Tensor, targets: Tensor) -> Tensor:
    """Cross-entropy of liner and wing, and absolute errors of the other numbers, where known.

    found: (N, 5), from LinerNet.all_numbers.  targets: (N, 5), as in Corner.
    """
    is_known = ~targets.isnan()
    there = targets.nan_to_num()
    entropy = functional.binary_cross_entropy_with_logits(found, there.clip(0, 1), reduction="none")
    off = functional.smooth_l1_loss(found, there, reduction="none", beta=0.05)
    losses = torch.where(torch.from_numpy(_LIKELY), entropy, off) * is_known
    each = losses.sum(0) / (is_known.sum(0) + 1)
    return each @ torch.tensor(WEIGHTS)


class Corners(Examples):
    kind, painted_share = Corner, SHARES[0]

    def how_often(self, targets: np.ndarray) -> np.ndarray:
        group = (targets[:, 1] == 1).astype(int)
        counts = np.bincount(group, minlength=2)
        shown: np.ndarray = (np.array(SHARES[1:]) / np.maximum(counts, 1))[group]
        return shown

    def vary(self, example: Corner, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
        return varied(example, rng)


def train(options: argparse.Namespace) -> None:
    config = "liner", len(NUMBERS)
    learn(options, LinerNet, config, Corners(options.data), loss_of_net, report, export)


def loss_of_net(net: LinerNet, crops: Tensor, targets: Tensor) -> Tensor:
    return loss_of(net.all_numbers(crops), targets)


def report(net: nn.Module, inputs: np.ndarray, targets: np.ndarray) -> str:
    """How well held-out corners are read: areas under the ROC curve, and mean errors."""
    said = []
    for name, likely, found, true in zip(
        NUMBERS[1:], _LIKELY[1:], numbers_of(net, inputs).T, targets[:, 1:].T, strict=True
    ):
        there = np.isfinite(true)
        if not there.any():
            continue
        if likely:
            said.append(f"{name} {area_under_curve(found[there], true[there] == 1):.3f}")
        else:
            said.append(f"{name} {np.abs(found - true)[there].mean():.3f}")
    return ", ".join(said)


def export(net: nn.Module, path: Path) -> None:
    """Write the net as ONNX: `rgb8` -> `liner`."""
    form_net.export(net, path, CORNER_WH, "liner")


if __name__ == "__main__":
    train(parser_of(__doc__, "worn.liner_crops", steps=1900).parse_args())
