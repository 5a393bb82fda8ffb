"""Trains the net that reads how lipstick shines and fades, and exports it.

    python -m makeup_video.training.worn.train_lipstick --data runs/mouths.npz \
        --out runs/reference_lipstick.onnx
"""

import argparse
from pathlib import Path

import numpy as np
import torch
from makeup_video.pipeline.reference.read_lipstick import MOUTH_WH
from makeup_video.training.worn import form_net
from makeup_video.training.worn.form_net import Examples, FormNet, learn, numbers_of, parser_of
from makeup_video.training.worn.mouth import NUMBERS, Mouth
from makeup_video.training.worn.vary_mouths import varied
from torch import Tensor, nn
from torch.nn import functional

DRAWN_SHARE = 0.35  # of a batch; the others are real
# How much more often mouths are shown that are wet, or fade: few real ones are.
_WET, _FADES = 1.75, 1.0
_MORE_WET, _MORE_FADING = 2.0, 3.0
_MATTE, _MORE_MATTE = 0.4, 1.0
_BETA = 0.3  # errors below this are squared


def examples(path: Path) -> Examples:
    return Examples(path, Mouth, DRAWN_SHARE, how_rare)


def how_rare(targets: np.ndarray) -> np.ndarray:
    """(N,) how often mouths are shown, by their targets."""
    gloss, fade = targets.T
    wet, matte = _MORE_WET * (gloss >= _WET), _MORE_MATTE * (gloss < _MATTE)
    shown: np.ndarray = 1 + wet + matte + _MORE_FADING * (fade >= _FADES)
    return shown


def train(options: argparse.Namespace) -> None:
    torch.manual_seed(0)
    torch.set_num_threads(options.threads)
    mouths = examples(options.data)
    net = FormNet(len(NUMBERS))

    def loss_of_batch(rng: np.random.Generator) -> Tensor:
        pictures, targets = mouths.batch(rng, varied)
        return len(NUMBERS) * functional.smooth_l1_loss(net(pictures), targets, beta=_BETA)

    held_out = mouths.held_out
    learn(
        options, net, ("lipstick", len(NUMBERS)), loss_of_batch,
        lambda average: report(average, held_out.rgb8, held_out.target), export,
    )  # fmt: skip


def report(net: nn.Module, pictures: np.ndarray, targets: np.ndarray) -> str:
    """How well mouths that are held out are read: mean errors."""
    off = np.abs(numbers_of(net, pictures) - targets).mean(0)
    return ", ".join(f"{name} {one:.3f}" for name, one in zip(NUMBERS, off, strict=True))


def export(net: nn.Module, path: Path) -> None:
    """Write the net as ONNX: `rgb8` -> `lipstick`."""
    form_net.export(net, path, MOUTH_WH, "lipstick")


if __name__ == "__main__":
    train(parser_of(__doc__, "worn.mouth_crops").parse_args())
