"""Trains the net that reads how lipstick shines and fades, and exports it.

    python -m makeup_video.training.worn.train_lipstick --data runs/mouths.npz \
        --out runs/reference_lipstick.onnx
"""

import argparse
from pathlib import Path

import numpy as np
from makeup_video.pipeline.reference.read_lipstick import MOUTH_WH
from makeup_video.training.worn import form_net
from makeup_video.training.worn.form_net import Examples, FormNet, learn, numbers_of, parser_of
from makeup_video.training.worn.mouth import NUMBERS, Mouth
from makeup_video.training.worn.vary_mouths import varied
from torch import Tensor, nn
from torch.nn import functional

# Few real mouths have at least this gloss or this fade. They are shown so much more often.
_GLOSSY, _FADES = 1.75, 1.0
_MORE_GLOSSY, _MORE_FADING = 2.0, 3.0
_BETA = 0.3  # errors below this are squared


class Mouths(Examples):
    kind, painted_share = Mouth, 0.35

    def how_often(self, targets: np.ndarray) -> np.ndarray:
        gloss, fade = targets.T
        shown: np.ndarray = 1 + _MORE_GLOSSY * (gloss >= _GLOSSY) + _MORE_FADING * (fade >= _FADES)
        return shown

    def vary(self, example: Mouth, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
        return varied(example, rng)


def train(options: argparse.Namespace) -> None:
    config = "lipstick", len(NUMBERS)
    learn(options, make_net, config, Mouths(options.data), loss_of, report, export)


def make_net() -> FormNet:
    return FormNet(len(NUMBERS))


def loss_of(net: FormNet, crops: Tensor, targets: Tensor) -> Tensor:
    return len(NUMBERS) * functional.smooth_l1_loss(net(crops), targets, beta=_BETA)


def report(net: nn.Module, crops: np.ndarray, targets: np.ndarray) -> str:
    """How well held-out mouths are read: mean errors."""
    off = np.abs(numbers_of(net, crops) - targets).mean(0)
    return ", ".join(f"{name} {one:.3f}" for name, one in zip(NUMBERS, off, strict=True))


def export(net: nn.Module, path: Path) -> None:
    """Write the net as ONNX: `rgb8` -> `lipstick`."""
    form_net.export(net, path, MOUTH_WH, "lipstick")


if __name__ == "__main__":
    train(parser_of(__doc__, "worn.mouth_crops", steps=1300).parse_args())
