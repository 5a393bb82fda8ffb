"""Trains the net that reads how lipstick shines and fades, and exports it.

    python -m makeup_video.training.worn.train_lipstick --data runs/mouths.npz \
        --out runs/reference_lipstick.onnx

The last tenth of the drawn mouths is held out: the mouths of one face are neighbours.
"""

import argparse
from pathlib import Path

import numpy as np
import torch
from makeup_video.pipeline.reference.read_lipstick import MOUTH_WH
from makeup_video.training.worn import form_net
from makeup_video.training.worn.form_net import BATCH, FormNet, learn, numbers_of, parser_of
from makeup_video.training.worn.mouth import NUMBERS, Mouth
from makeup_video.training.worn.vary_mouths import varied
from torch import Tensor, nn
from torch.nn import functional

HELD_OUT = 0.1
DRAWN_SHARE = 0.35  # of a batch; the others are real
# How much more often mouths are shown that are wet, or fade: few real ones are.
_WET, _FADES = 1.75, 1.0
_MORE_WET, _MORE_FADING = 2.0, 3.0
_MATTE, _MORE_MATTE = 0.4, 1.0
_BETA = 0.3  # errors below this are squared


class Mouths:
    """The packed mouths: those that are learned from, and the drawn ones that are held out."""

    def __init__(self, path: Path) -> None:
        with np.load(path) as data:
            self._parts = Mouth(*(data[name] for name in Mouth._fields))
            is_real = data["is_real"]
        drawn = int((~is_real).sum())  # which come first
        shown = int(drawn * (1 - HELD_OUT))
        self.held_out = Mouth(*(part[shown:drawn] for part in self._parts))
        gloss, fade = self._parts.target.T
        rare = 1 + _MORE_WET * (gloss >= _WET) + _MORE_MATTE * (gloss < _MATTE)
        rare += _MORE_FADING * (fade >= _FADES)
        often = np.where(is_real, rare, 1.0)
        often[shown:drawn] = 0
        for group, share in ((is_real, 1 - DRAWN_SHARE), (~is_real, DRAWN_SHARE)):
            often[group] *= share / max(often[group].sum(), 1e-9)
        self._shares = often / often.sum()

    def batch(self, rng: np.random.Generator) -> tuple[Tensor, Tensor]:
        """(BATCH, 80, 112, 3) uint8 and (BATCH, 2): mouths that vary, and their targets."""
        chosen = rng.choice(len(self._shares), BATCH, p=self._shares)
        seen = [varied(Mouth(*(part[at] for part in self._parts)), rng) for at in chosen]
        pictures, targets = (torch.from_numpy(np.stack(each)) for each in zip(*seen, strict=True))
        return pictures, targets


def train(options: argparse.Namespace) -> None:
    torch.manual_seed(0)
    torch.set_num_threads(options.threads)
    mouths = Mouths(options.data)
    net = FormNet(len(NUMBERS))

    def loss_of_batch(rng: np.random.Generator) -> Tensor:
        pictures, targets = mouths.batch(rng)
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
