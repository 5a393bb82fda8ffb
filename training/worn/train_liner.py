"""Trains the net that reads the form of an eyeliner, and exports it.

    python -m makeup_video.training.worn.train_liner --data runs/liners.npz \
        --out runs/reference_liner.onnx

The last tenth of the drawn corners is held out: the crops of one face are neighbours.
"""

import argparse
import time
from pathlib import Path

import numpy as np
import torch
from makeup_video.training.faces.checkpoint import Checkpoint, rate_at
from makeup_video.training.inputs import made_by
from makeup_video.training.worn.corner import NUMBERS, Corner
from makeup_video.training.worn.scores import area_under_curve
from makeup_video.training.worn.vary_corners import varied
from torch import Tensor, nn
from torch.nn import functional

HELD_OUT = 0.1
BATCH, RATE, WARM_UP, CLIP, DECAY, AVERAGE = 96, 2e-3, 200, 5.0, 1e-3, 0.99
CHANNELS = (12, 32, 64)
LAST, HIDDEN, DROPPED = 96, 64, 0.3
# Of a batch: drawn corners, real ones without a wing that is known, and with one.
SHARES = 0.72, 0.22, 0.06
GRID = 2, 3  # of the means that remain of the last features
# Of the losses, in the order of NUMBERS.
WEIGHTS = (1.0, 2.0, 4.0, 2.0, 8.0)
_LIKELY = np.array([name in ("liner", "wing") for name in NUMBERS])  # log-odds


class LinerNet(nn.Module):
    """Corners (N, 72, 112, 3) uint8 -> (N, 4): all of NUMBERS but the liner."""

    def __init__(self) -> None:
        super().__init__()
        layers, before = [], 3
        for channels, after in zip(CHANNELS, (16, *CHANNELS[1:]), strict=True):
            layers += [_block(before, channels, 2), _block(channels, after, 1)]
            before = after
        layers += [_block(before, LAST, 2), nn.AvgPool2d(3, 2), nn.Flatten()]
        layers += [nn.Dropout(DROPPED), nn.Linear(LAST * GRID[0] * GRID[1], HIDDEN), nn.ReLU()]
        self.layers = nn.Sequential(*layers, nn.Linear(HIDDEN, len(NUMBERS)))

    def forward(self, rgb8: Tensor) -> Tensor:
        return self.all_numbers(rgb8)[:, 1:]

    def all_numbers(self, rgb8: Tensor) -> Tensor:
        """(N, 5): the log-odds of a liner come first, which only help to train."""
        found: Tensor = self.layers(rgb8.permute(0, 3, 1, 2).float() / 63.75 - 1.8)
        return found


def _block(before: int, channels: int, stride: int) -> nn.Sequential:
    return nn.Sequential(
        nn.Conv2d(before, channels, 3, stride, 1, bias=False),
        nn.BatchNorm2d(channels),
        nn.ReLU(inplace=True),
    )


def loss_of(found: Tensor, targets: Tensor) -> Tensor:
    """Cross-entropy of what is worn, and absolute errors of the numbers, where they are known.

    found, targets: (N, 5), as of LinerNet.all_numbers and Corner.
    """
    is_known = ~targets.isnan()
    there = targets.nan_to_num()
    entropy = functional.binary_cross_entropy_with_logits(found, there.clip(0, 1), reduction="none")
    off = functional.smooth_l1_loss(found, there, reduction="none", beta=0.05)
    losses = torch.where(torch.from_numpy(_LIKELY), entropy, off) * is_known
    each = losses.sum(0) / (is_known.sum(0) + 1)
    return each @ torch.tensor(WEIGHTS)


class Corners:
    """The packed corners: those that are learned from, and the drawn ones that are held out."""

    def __init__(self, path: Path) -> None:
        with np.load(path) as data:
            self._parts = Corner(*(data[name] for name in Corner._fields))
            is_real = data["is_real"]
        drawn = int((~is_real).sum())  # which come first
        shown = int(drawn * (1 - HELD_OUT))
        self.held_out = Corner(*(part[shown:drawn] for part in self._parts))
        group = np.where(is_real, 1 + (self._parts.target[:, 1] == 1), 0)
        is_shown = np.ones(len(group))
        is_shown[shown:drawn] = 0
        counts = np.bincount(group, is_shown, minlength=len(SHARES))
        shares = is_shown * np.array(SHARES)[group] / counts[group]
        self._shares = shares / shares.sum()

    def batch(self, rng: np.random.Generator) -> tuple[Tensor, Tensor]:
        """(BATCH, 72, 112, 3) uint8 and (BATCH, 5): corners that vary, and their targets."""
        chosen = rng.choice(len(self._shares), BATCH, p=self._shares)
        seen = [varied(Corner(*(part[at] for part in self._parts)), rng) for at in chosen]
        pictures, targets = (torch.from_numpy(np.stack(each)) for each in zip(*seen, strict=True))
        return pictures, targets


def train(options: argparse.Namespace) -> None:
    torch.manual_seed(0)
    torch.set_num_threads(options.threads)
    corners = Corners(options.data)
    held_out = corners.held_out
    net = LinerNet()
    optimiser = torch.optim.AdamW(net.parameters(), RATE, weight_decay=DECAY)
    state = Checkpoint(options.out.with_suffix(".pt"), net, optimiser, AVERAGE)
    state.resume()  # a finished one is exported again
    # a resumed run must not draw the examples of its beginning again
    rng = np.random.default_rng(state.step)
    torch.manual_seed(state.step)
    began = time.monotonic()
    for step in range(state.step, options.steps):
        seen, targets = corners.batch(rng)
        loss = loss_of(net.all_numbers(seen), targets)
        state.learn(loss, rate_at(step, options.steps, RATE, WARM_UP), CLIP)
        if state.step % 200 == 0 or state.step == options.steps:
            state.save(("liner", len(NUMBERS)))
            seconds = time.monotonic() - began
            print(f"step {state.step}, {seconds:.0f} s, loss {float(loss.detach()):.3f}, ", end="")
            print(report(state.average.module, held_out.rgb8, held_out.target), flush=True)
            export(state.average.module, options.out)


@torch.no_grad()
def report(net: nn.Module, inputs: np.ndarray, targets: np.ndarray) -> str:
    """How well corners that are held out are read: areas under the ROC curve, and mean errors."""
    net.eval()
    parts = [net(torch.from_numpy(inputs[at : at + 256])) for at in range(0, len(inputs), 256)]
    net.train()
    said = []
    for name, likely, found, true in zip(
        NUMBERS[1:], _LIKELY[1:], torch.cat(parts).numpy().T, targets[:, 1:].T, strict=True
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
    net.eval()
    torch.onnx.export(
        net, (torch.zeros(2, 72, 112, 3, dtype=torch.uint8),), str(path), dynamo=False,
        input_names=["rgb8"], output_names=["liner"], opset_version=17,
        dynamic_axes={name: {0: "n"} for name in ("rgb8", "liner")},
    )  # fmt: skip
    net.train()


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--data", type=made_by("worn.liner_crops"), required=True)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--steps", type=int, default=1900)
    parser.add_argument("--threads", type=int, default=2)
    train(parser.parse_args())
