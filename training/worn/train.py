"""Trains the net that reads what is worn, and exports it.

    python -m makeup_video.training.worn.train --data runs/*.npz --out runs/reference_makeup.onnx

Light, colour, sharpness and noise vary as in photos. The last tenth of the real faces of a set is
held out, with what was painted on them: neighbours in a set are often the same person.
"""

import argparse
import time
from pathlib import Path

import numpy as np
import torch
from makeup_video.pipeline.reference.makeup_input import PLACES, mirrored
from makeup_video.training.faces.checkpoint import Checkpoint, rate_at
from makeup_video.training.worn.model import MakeupNet
from makeup_video.training.worn.scores import UNKNOWN, area_under_curve
from torch import Tensor, nn
from torch.nn import functional

HELD_OUT = 0.1
BATCH, RATE, WARM_UP, CLIP, DECAY, AVERAGE = 40, 2e-3, 200, 5.0, 2e-2, 0.998
PAINTED_SHARE = 0.4  # of a batch: faces that wear drawn looks
SMOOTH = 0.05  # of labels: some are wrong
NUMBERS = 8.0  # weight of the numbers' squared error beside the labels' entropy
_KEYS = "inputs", "labels", "vectors", "weights", "real"


def varied(rgb8: Tensor) -> Tensor:
    """Pictures (N, H, W, 3) uint8 as other cameras would take them in other light."""
    x = rgb8.float() / 255
    n = len(x)

    def drawn(spread: float, *shape: int) -> Tensor:
        return torch.randn(n, *shape) * spread

    x = x ** torch.exp(drawn(0.18, 1, 1, 1))
    x = x * torch.exp(drawn(0.15, 1, 1, 1) + drawn(0.05, 1, 1, 3))
    grey = x.mean(3, keepdim=True)
    x = grey + (x - grey) * torch.exp(drawn(0.2, 1, 1, 1))
    x = _by_parts(x)
    x = x + torch.randn_like(x) * (0.03 * torch.rand(n, 1, 1, 1))
    return (x.clamp(0, 1) * 255).round().to(torch.uint8)


def _by_parts(x: Tensor) -> Tensor:
    """Mirror, shift, turn and blur each part by itself; the mirror is the same for all parts."""
    out = x.clone()
    flip = torch.rand(len(x)) < 0.5
    coarse = torch.rand(()) < 0.6
    factor = float(torch.empty(()).uniform_(1.2, 3.5))
    for left, top, wide, high in PLACES.values():
        part = x[:, top : top + high, left : left + wide].permute(0, 3, 1, 2)
        part = torch.where(flip[:, None, None, None], part.flip(3), part)
        if coarse:
            size = max(round(high / factor), 8), max(round(wide / factor), 8)
            part = functional.interpolate(part, size, mode="area")
            part = functional.interpolate(part, (high, wide), mode="bilinear")
        part = functional.grid_sample(
            part, _moved(len(x), high, wide), padding_mode="border", align_corners=False
        )
        out[:, top : top + high, left : left + wide] = part.permute(0, 2, 3, 1)
    return out


def _moved(n: int, high: int, wide: int) -> Tensor:
    angle, scale = torch.randn(n) * 0.05, torch.exp(torch.randn(n) * 0.05)
    cos, sin = torch.cos(angle) * scale, torch.sin(angle) * scale
    shift = torch.randn(n, 2) * 0.03
    rows = [
        torch.stack([cos, -sin * high / wide, shift[:, 0]], 1),
        torch.stack([sin * wide / high, cos, shift[:, 1] * wide / high], 1),
    ]
    return functional.affine_grid(torch.stack(rows, 1), [n, 3, high, wide], align_corners=False)


def loss_of(
    found: tuple[Tensor, Tensor], labels: Tensor, vectors: Tensor, weights: Tensor
) -> Tensor:
    """Cross-entropy of the labels that are known, and squared error of the numbers by weight."""
    logits, numbers = found
    known = labels != UNKNOWN
    target = (labels == 1).float()
    soft = target * (1 - 2 * SMOOTH) + SMOOTH
    each = functional.binary_cross_entropy_with_logits(logits, soft, reduction="none")
    off = weights * (numbers - vectors) ** 2
    return (each * known).sum() / known.sum().clamp(min=1) + NUMBERS * off.mean()


def split(sources: np.ndarray, real: np.ndarray) -> np.ndarray:
    """(N,) bool: the examples that are held out."""
    person = np.cumsum(real)  # what is painted follows its face
    held = np.zeros(len(real), bool)
    for source in np.unique(sources):
        of = np.unique(person[sources == source])
        first = of[int(len(of) * (1 - HELD_OUT))]
        held |= (sources == source) & (person >= first)
    return held


@torch.no_grad()
def scores_of(net: nn.Module, inputs: np.ndarray) -> np.ndarray:
    """Log-odds (N, labels): the mean over each picture and its mirror image."""
    net.eval()
    found = []
    for at in range(0, len(inputs), 128):
        rgb8 = inputs[at : at + 128]
        one, other = (net(torch.from_numpy(each))[0] for each in (rgb8, mirrored(rgb8)))
        found.append((one + other) / 2)
    net.train()
    return torch.cat(found).numpy()


def train(options: argparse.Namespace) -> None:
    torch.manual_seed(0)
    torch.set_num_threads(options.threads)
    rng = np.random.default_rng(0)
    data = _read(options.data)
    inputs, labels, real = data["inputs"], data["labels"], data["real"]
    held = split(data["sources"], real)
    shown, painted = np.flatnonzero(real & ~held), np.flatnonzero(~real & ~held)
    share = _shares(labels[shown])
    net = MakeupNet(labels.shape[1], data["vectors"].shape[1])
    optimiser = torch.optim.AdamW(net.parameters(), RATE, weight_decay=DECAY)
    state = Checkpoint(options.out.with_suffix(".pt"), net, optimiser, AVERAGE)
    state.resume()
    began, few = time.monotonic(), round(BATCH * PAINTED_SHARE)
    for step in range(state.step, options.steps):
        at = np.concatenate([rng.choice(shown, BATCH - few, p=share), rng.choice(painted, few)])
        batch = (torch.from_numpy(data[key][at]) for key in ("labels", "vectors", "weights"))
        loss = loss_of(net(varied(torch.from_numpy(inputs[at]))), *batch)
        state.learn(loss, rate_at(step, options.steps, RATE, WARM_UP), CLIP)
        if state.step % 200 == 0:
            seconds = time.monotonic() - began
            print(
                f"step {state.step}, {seconds:.0f} s, loss {float(loss.detach()):.3f}", flush=True
            )
        if state.step % 500 == 0 or state.step == options.steps:
            state.save(("makeup", labels.shape[1]))
            _report(state.average.module, inputs, labels, held & real)
            export(state.average.module, options.out)


def _read(paths: list[Path]) -> dict[str, np.ndarray]:
    """All files joined; each file has sources of its own."""
    packed = [np.load(path) for path in paths]
    joined = {key: np.concatenate([data[key] for data in packed]) for key in _KEYS}
    sources = [data["sources"].astype(int) + 16 * number for number, data in enumerate(packed)]
    return joined | {"sources": np.concatenate(sources)}


def _shares(labels: np.ndarray) -> np.ndarray:
    """How often each real face is drawn: those that wear something rare more often."""
    worn = labels == 1
    rare = (worn / np.maximum(worn.sum(0), 1)).sum(1)
    share = 1 / len(labels) + 0.5 * rare / max(rare.sum(), 1e-9) * worn.any(1).mean() * 2
    return np.asarray(share / share.sum())


def _report(net: nn.Module, inputs: np.ndarray, labels: np.ndarray, which: np.ndarray) -> None:
    scores, areas = scores_of(net, inputs[which]), []
    for column in range(labels.shape[1]):
        known = labels[which, column] != UNKNOWN
        areas.append(area_under_curve(scores[known, column], labels[which, column][known] == 1))
    print(f"held out: area under curve {', '.join(f'{area:.3f}' for area in areas)}", flush=True)


def export(net: nn.Module, path: Path) -> None:
    """Write the net as ONNX: `rgb8` -> `log_odds`, `numbers`."""
    net.eval()
    torch.onnx.export(
        net, (torch.zeros(2, 160, 192, 3, dtype=torch.uint8),), str(path), dynamo=False,
        input_names=["rgb8"], output_names=["log_odds", "numbers"], opset_version=17,
        dynamic_axes={name: {0: "n"} for name in ("rgb8", "log_odds", "numbers")},
    )  # fmt: skip


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--data", type=Path, nargs="+", required=True)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--steps", type=int, default=6000)
    parser.add_argument("--threads", type=int, default=2)
    train(parser.parse_args())
