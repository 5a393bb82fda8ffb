"""A small net that reads the form of a kind of makeup from a close crop, and its training."""

import argparse
import time
from abc import ABC, abstractmethod
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar

import numpy as np
import torch
from makeup_video.training.faces.checkpoint import Checkpoint, rate_at
from makeup_video.training.inputs import made_by
from torch import Tensor, nn

BATCH, RATE, WARM_UP, CLIP, DECAY, AVERAGE = 96, 2e-3, 200, 5.0, 1e-3, 0.99
CHANNELS = (12, 32, 64)
LAST, HIDDEN, DROPPED = 96, 64, 0.3
GRID = 2, 3  # rows and columns of the last features after they are averaged
HELD_OUT = 0.1

Example = Any  # a named tuple of arrays
Net = TypeVar("Net", bound="FormNet")


class FormNet(nn.Module):
    """Crops (N, H, W, 3) uint8, about 112 x 80, -> (N, count) numbers."""

    def __init__(self, count: int) -> None:
        super().__init__()
        layers, before = [], 3
        for channels, after in zip(CHANNELS, (16, *CHANNELS[1:]), strict=True):
            layers += [_block(before, channels, 2), _block(channels, after, 1)]
            before = after
        layers += [_block(before, LAST, 2), nn.AvgPool2d(3, 2), nn.Flatten()]
        layers += [nn.Dropout(DROPPED), nn.Linear(LAST * GRID[0] * GRID[1], HIDDEN), nn.ReLU()]
        self.layers = nn.Sequential(*layers, nn.Linear(HIDDEN, count))

    def forward(self, rgb8: Tensor) -> Tensor:
        found: Tensor = self.layers(rgb8.permute(0, 3, 1, 2).float() / 63.75 - 1.8)
        return found


def _block(before: int, channels: int, stride: int) -> nn.Sequential:
    return nn.Sequential(
        nn.Conv2d(before, channels, 3, stride, 1, bias=False),
        nn.BatchNorm2d(channels),
        nn.ReLU(inplace=True),
    )


class Examples(ABC):
    """Packed crops, painted ones first. The last tenth of the painted ones is held out, by whole
    faces.

    packed.py writes the file. Its fields are those of `kind`, a named tuple with rgb8 and target.
    """

    kind: Callable[..., Example]
    painted_share: float  # share of painted crops in a batch

    def __init__(self, path: Path) -> None:
        with np.load(path) as data:
            is_real = data["is_real"]
            self._parts = {
                name: data[name] for name in data.files if name not in ("is_real", "face")
            }
            face = data["face"][~is_real]
        painted = len(face)
        shown = int(painted * (1 - HELD_OUT))
        if shown == painted:
            raise SystemExit(f"{path} has no painted crops to hold out: pack it with --looks 1")
        shown = int(np.searchsorted(face, face[shown]))  # where the cut face begins
        self.held_out = type(self).kind(**self._of(slice(shown, painted)))
        often = np.ones(len(is_real))
        often[shown:painted] = 0
        often[is_real] = self.how_often(self._parts["target"][is_real])
        for group, share in ((is_real, 1 - self.painted_share), (~is_real, self.painted_share)):
            often[group] *= share / max(often[group].sum(), 1e-9)
        self._shares = often / often.sum()

    def batch(self, rng: np.random.Generator) -> tuple[Tensor, Tensor]:
        """(BATCH, H, W, 3) uint8 and (BATCH, N): crops that vary, and their targets."""
        chosen = rng.choice(len(self._shares), BATCH, p=self._shares)
        seen = [self.vary(type(self).kind(**self._of(at)), rng) for at in chosen]
        pictures, targets = (torch.from_numpy(np.stack(each)) for each in zip(*seen, strict=True))
        return pictures, targets

    @abstractmethod
    def how_often(self, targets: np.ndarray) -> np.ndarray:
        """(N,) how often each real crop is shown, which depends on its target."""

    @abstractmethod
    def vary(self, example: Example, rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
        """A crop as another photo shows it, and its target."""

    def _of(self, at: Any) -> dict[str, np.ndarray]:
        return {name: part[at] for name, part in self._parts.items()}


def parser_of(description: str | None, data_from: str, *, steps: int) -> argparse.ArgumentParser:
    """A parser of the options of a training command.

    data_from: the module that packs the crops.  steps: the default length of the whole run.
    """
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("--data", type=made_by(data_from), required=True)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--steps", type=int, default=steps)
    parser.add_argument("--threads", type=int, default=2)
    return parser


def learn(
    options: argparse.Namespace,
    make: Callable[[], Net],
    config: tuple[str, int],
    examples: Examples,
    loss_of: Callable[[Net, Tensor, Tensor], Tensor],
    report: Callable[[nn.Module, np.ndarray, np.ndarray], str],
    write: Callable[[nn.Module, Path], None],
) -> None:
    """Train a net, or continue an interrupted run; save and export it every 200 steps.

    make: makes a new net.  config: the net's name, and how many numbers it returns.  loss_of: the
    loss of a net on crops with their targets.  report: says how well a net reads crops with these
    targets.  write: exports the net.
    """
    torch.manual_seed(0)
    torch.set_num_threads(options.threads)
    net, held_out = make(), examples.held_out
    optimiser = torch.optim.AdamW(net.parameters(), RATE, weight_decay=DECAY)
    state = Checkpoint(options.out.with_suffix(".pt"), net, optimiser, AVERAGE)
    state.resume()
    if state.step:  # even a finished run, which trains no more, is exported again
        write(state.average.module, options.out)
    # a resumed run must not draw the examples of its beginning again
    rng = np.random.default_rng(state.step)
    torch.manual_seed(state.step)
    began = time.monotonic()
    for step in range(state.step, options.steps):
        loss = loss_of(net, *examples.batch(rng))
        state.learn(loss, rate_at(step, options.steps, RATE, WARM_UP), CLIP)
        if state.step % 200 == 0 or state.step == options.steps:
            state.save(config)
            seconds = time.monotonic() - began
            print(f"step {state.step}, {seconds:.0f} s, loss {float(loss.detach()):.3f}, ", end="")
            print(report(state.average.module, held_out.rgb8, held_out.target), flush=True)
            write(state.average.module, options.out)


@torch.no_grad()
def numbers_of(net: nn.Module, pictures: np.ndarray) -> np.ndarray:
    """The numbers (N, count) that a net returns for pictures (N, H, W, 3) uint8."""
    net.eval()
    parts = [net(torch.from_numpy(pictures[at : at + 256])) for at in range(0, len(pictures), 256)]
    net.train()
    found: np.ndarray = torch.cat(parts).numpy()
    return found


def export(net: nn.Module, path: Path, size_wh: tuple[int, int], name: str) -> None:
    """Write the net as ONNX, with the input `rgb8` of this size and the output `name`."""
    net.eval()
    torch.onnx.export(
        net, (torch.zeros(2, *size_wh[::-1], 3, dtype=torch.uint8),), str(path), dynamo=False,
        input_names=["rgb8"], output_names=[name], opset_version=17,
        dynamic_axes={key: {0: "n"} for key in ("rgb8", name)},
    )  # fmt: skip
    net.train()
