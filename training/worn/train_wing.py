"""Trains the net that reads the wing of an eyeliner, and exports it.

    python -m makeup_video.training.worn.train_wing --data runs/wings.npz \
        --out runs/reference_wing.onnx

The last tenth of the corners is held out: the crops of one face are neighbours.
"""

import argparse
import time
from pathlib import Path

import numpy as np
import torch
from makeup_video.training.faces.checkpoint import Checkpoint, rate_at
from makeup_video.training.inputs import made_by
from makeup_video.training.worn.scores import area_under_curve
from makeup_video.training.worn.wing_crops import varied
from torch import Tensor, nn
from torch.nn import functional

HELD_OUT = 0.1
BATCH, RATE, WARM_UP, CLIP, DECAY, AVERAGE = 96, 2e-3, 200, 5.0, 1e-3, 0.99
CHANNELS = (12, 32, 64)
LAST, HIDDEN, DROPPED = 96, 64, 0.3
GRID = 2, 3  # of the means that remain of the last features
WING, LENGTH, ANGLE = 2.0, 4.0, 2.0  # weights of the losses beside that of the liner


class WingNet(nn.Module):
    """Corners (N, 72, 112, 3) uint8 -> (N, 3): log-odds of a wing, its length and its angle.

    length: in widths of the eye.  angle: of ANGLE_UNIT.
    """

    def __init__(self) -> None:
        super().__init__()
        layers, before = [], 3
        for channels, after in zip(CHANNELS, (16, *CHANNELS[1:]), strict=True):
            layers += [_block(before, channels, 2), _block(channels, after, 1)]
            before = after
        layers += [_block(before, LAST, 2), nn.AvgPool2d(3, 2), nn.Flatten()]
        layers += [nn.Dropout(DROPPED), nn.Linear(LAST * GRID[0] * GRID[1], HIDDEN), nn.ReLU()]
        self.layers = nn.Sequential(*layers, nn.Linear(HIDDEN, 4))

    def forward(self, rgb8: Tensor) -> Tensor:
        return self.all_numbers(rgb8)[:, 1:]

    def all_numbers(self, rgb8: Tensor) -> Tensor:
        """(N, 4): the log-odds of a liner come first, which only help to train."""
        found: Tensor = self.layers(rgb8.permute(0, 3, 1, 2).float() / 63.75 - 1.8)
        return found


def _block(before: int, channels: int, stride: int) -> nn.Sequential:
    return nn.Sequential(
        nn.Conv2d(before, channels, 3, stride, 1, bias=False),
        nn.BatchNorm2d(channels),
        nn.ReLU(inplace=True),
    )


def loss_of(found: Tensor, targets: Tensor) -> Tensor:
    """Cross-entropy of liner and wing, and absolute errors of the wings that are there.

    found, targets: (N, 4), as of WingNet.all_numbers and wing_crops.target_of.
    """
    entropy = functional.binary_cross_entropy_with_logits
    off = functional.smooth_l1_loss(found[:, 2:], targets[:, 2:], reduction="none", beta=0.05)
    there = targets[:, 1:2]
    length, angle = (off * there).sum(0) / (there.sum() + 1)
    worn = entropy(found[:, 0], targets[:, 0]) + WING * entropy(found[:, 1], targets[:, 1])
    return worn + LENGTH * length + ANGLE * angle


def train(options: argparse.Namespace) -> None:
    torch.manual_seed(0)
    torch.set_num_threads(options.threads)
    with np.load(options.data) as data:
        inputs, targets = data["inputs"], data["targets"]
    shown = int(len(inputs) * (1 - HELD_OUT))
    net = WingNet()
    optimiser = torch.optim.AdamW(net.parameters(), RATE, weight_decay=DECAY)
    state = Checkpoint(options.out.with_suffix(".pt"), net, optimiser, AVERAGE)
    state.resume()  # a finished one is exported again
    # a resumed run must not draw the examples of its beginning again
    rng = np.random.default_rng(state.step)
    torch.manual_seed(state.step)
    began = time.monotonic()
    for step in range(state.step, options.steps):
        at = rng.integers(0, shown, BATCH)
        seen = torch.from_numpy(np.stack([varied(inputs[one], rng) for one in at]))
        loss = loss_of(net.all_numbers(seen), torch.from_numpy(targets[at]))
        state.learn(loss, rate_at(step, options.steps, RATE, WARM_UP), CLIP)
        if state.step % 200 == 0 or state.step == options.steps:
            state.save(("wing", targets.shape[1]))
            seconds = time.monotonic() - began
            print(f"step {state.step}, {seconds:.0f} s, loss {float(loss.detach()):.3f}, ", end="")
            print(report(state.average.module, inputs[shown:], targets[shown:]), flush=True)
            export(state.average.module, options.out)


@torch.no_grad()
def report(net: nn.Module, inputs: np.ndarray, targets: np.ndarray) -> str:
    """How well wings of corners that are held out are read."""
    net.eval()
    parts = [net(torch.from_numpy(inputs[at : at + 256])) for at in range(0, len(inputs), 256)]
    net.train()
    found, there = torch.cat(parts).numpy(), targets[:, 1] == 1
    area = area_under_curve(found[:, 0], there)
    length, angle = np.abs(found[there, 1:] - targets[there, 2:]).mean(0)
    return f"held out: area under curve {area:.3f}, off by {length:.3f} and {angle:.3f}"


def export(net: nn.Module, path: Path) -> None:
    """Write the net as ONNX: `rgb8` -> `wing`."""
    net.eval()
    torch.onnx.export(
        net, (torch.zeros(2, 72, 112, 3, dtype=torch.uint8),), str(path), dynamo=False,
        input_names=["rgb8"], output_names=["wing"], opset_version=17,
        dynamic_axes={name: {0: "n"} for name in ("rgb8", "wing")},
    )  # fmt: skip
    net.train()


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--data", type=made_by("worn.wing_crops"), required=True)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--steps", type=int, default=1600)
    parser.add_argument("--threads", type=int, default=2)
    train(parser.parse_args())
