"""Trains the net that reads what is worn, and exports it.

    python -m makeup_video.training.worn.train --data runs/portraits.npz runs/wild.npz \
        --out runs/reference_makeup.onnx

Light, colour, sharpness and noise vary as in photos. Of each set, one fold of neighbouring real
faces is held out with their painted copies: neighbours are often the same person. The net's
log-odds for all faces are written beside the net (OUT.npy). --teachers takes such files of one net
for each fold. A net then learns from the teachers beside the labels: for a labelled face, from the
teacher that was not trained on that face. Teachers help because labels given at a glance are
sometimes wrong, and because faces without labels then teach as well.
"""

import argparse
import time
from pathlib import Path

import numpy as np
import torch
from makeup_video.pipeline.reference.makeup_input import PLACES, mirrored
from makeup_video.training.faces.checkpoint import Checkpoint, rate_at
from makeup_video.training.inputs import existing, made_by
from makeup_video.training.worn.evaluate import log_odds
from makeup_video.training.worn.model import CHANNELS, MakeupNet
from makeup_video.training.worn.scores import UNKNOWN, area_under_curve
from torch import Tensor, nn
from torch.nn import functional

FOLDS = 10  # the default; by default the last fold is held out
RATE, WARM_UP, CLIP, DECAY, AVERAGE = 2e-3, 200, 5.0, 2e-2, 0.998
PAINTED_SHARE = 0.4  # of a batch: faces that wear drawn looks
UNLABELLED_SHARE = 0.3  # of a batch: faces without labels, where there are teachers
TAUGHT = 0.8  # share of the teachers' answer in the target of a known label
ALIKE = 40  # so many pictures are made coarser by the same factor
SMOOTH = 0.05  # how far labels are moved from 0 and 1, because some are wrong
NUMBERS = 8.0  # weight of the numbers' squared error beside the labels' entropy
_KEYS = "inputs", "labels", "vectors", "weights", "real"


def varied(rgb8: Tensor) -> Tensor:
    """Pictures (N, H, W, 3) uint8 as other cameras would take them in other light."""
    return torch.cat([_varied(few) for few in rgb8.split(ALIKE)])


def _varied(rgb8: Tensor) -> Tensor:
    x = rgb8.float() / 255
    n = len(x)

    def drawn(spread: float, *shape: int) -> Tensor:
        return torch.randn(n, *shape, device=x.device) * spread

    x = x ** torch.exp(drawn(0.3, 1, 1, 1))
    x = x * torch.exp(drawn(0.25, 1, 1, 1) + drawn(0.085, 1, 1, 3))
    grey = x.mean(3, keepdim=True)
    x = grey + (x - grey) * torch.exp(drawn(0.2, 1, 1, 1))
    x = _by_parts(x)
    x = x + torch.randn_like(x) * (0.03 * torch.rand(n, 1, 1, 1, device=x.device))
    return (x.clamp(0, 1) * 255).round().to(torch.uint8)


def _by_parts(x: Tensor) -> Tensor:
    """Shift and turn each part by itself, light it from a side, and cover a piece of it. Mirroring
    and coarseness are the same for all parts of a picture."""
    out = x.clone()
    flip = torch.rand(len(x), device=x.device) < 0.5
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
            part, _moved(part), padding_mode="border", align_corners=False
        )
        part = _covered(part * _from_a_side(part))
        out[:, top : top + high, left : left + wide] = part.permute(0, 2, 3, 1)
    return out


def _moved(part: Tensor) -> Tensor:
    n, _, high, wide = part.shape
    angle, scale, shift = (torch.randn(n, k, device=part.device) for k in (1, 1, 2))
    angle, scale, shift = angle[:, 0] * 0.05, torch.exp(scale[:, 0] * 0.05), shift * 0.03
    cos, sin = torch.cos(angle) * scale, torch.sin(angle) * scale
    rows = [
        torch.stack([cos, -sin * high / wide, shift[:, 0]], 1),
        torch.stack([sin * wide / high, cos, shift[:, 1] * wide / high], 1),
    ]
    return functional.affine_grid(torch.stack(rows, 1), [n, 3, high, wide], align_corners=False)


def _from_a_side(part: Tensor) -> Tensor:
    """Light (N, 1, H, W) that grows evenly in any direction."""
    n, _, high, wide = part.shape
    slope = torch.randn(n, 2, 1, 1, 1, device=part.device) * 0.12
    across = torch.linspace(-1, 1, wide, device=part.device)
    down = torch.linspace(-1, 1, high, device=part.device)[:, None]
    return torch.exp(slope[:, 0] * across + slope[:, 1] * down)


def _covered(part: Tensor) -> Tensor:
    """Cover three of ten parts with a box in a random colour, up to two fifths of each side."""
    n, _, high, wide = part.shape
    middle, size = torch.rand(2, n, 2, 1, 1, device=part.device)
    size = size * 0.2 * (torch.rand(n, 1, 1, 1, device=part.device) < 0.3)
    across = torch.linspace(0, 1, wide, device=part.device)
    down = torch.linspace(0, 1, high, device=part.device)[:, None]
    near = ((across - middle[:, 0]).abs() < size[:, 0]) & ((down - middle[:, 1]).abs() < size[:, 1])
    return torch.where(near[:, None], torch.rand(n, 3, 1, 1, device=part.device), part)


def targets_of(labels: np.ndarray, taught: np.ndarray | None) -> tuple[np.ndarray, np.ndarray]:
    """The probabilities (N, labels) that a net is to learn, and whether they are known.

    taught: (N, labels), the log-odds of the teachers, if there are any.
    """
    known = labels != UNKNOWN
    probabilities = np.where(labels == 1, 1 - SMOOTH, SMOOTH)
    if taught is not None:
        told = 1 / (1 + np.exp(-taught))
        probabilities = np.where(known, probabilities * (1 - TAUGHT) + told * TAUGHT, told)
        known = np.ones_like(known)
    return probabilities.astype(np.float32), known


def loss_of(
    found: tuple[Tensor, Tensor], targets: Tensor, known: Tensor, vectors: Tensor, weights: Tensor
) -> Tensor:
    """Cross-entropy of the known targets, and the weighted squared error of the numbers."""
    logits, numbers = found
    each = functional.binary_cross_entropy_with_logits(logits, targets, reduction="none")
    off = weights * (numbers - vectors) ** 2
    return (each * known).sum() / known.sum().clamp(min=1) + NUMBERS * off.mean()


def split(sources: np.ndarray, real: np.ndarray, folds: int, fold: int) -> np.ndarray:
    """(N,) bool: the examples of the fold that is held out."""
    person = np.cumsum(real)  # the painted copies of a face follow it
    held = np.zeros(len(real), bool)
    for source in np.unique(sources):
        of = np.unique(person[sources == source])
        first, end = len(of) * fold // folds, len(of) * (fold + 1) // folds
        held |= (sources == source) & np.isin(person, of[first:end])
    return held


def teachers_of(odds: list[np.ndarray], data: dict[str, np.ndarray]) -> np.ndarray:
    """The log-odds (N, labels) that faces get from teachers, one net for each fold.

    A labelled face gets those of the net that did not learn from the face. A face without labels
    gets the mean, since no teacher learned from such faces.
    """
    labels, taught = data["labels"], np.mean(odds, 0)
    labelled = (labels != UNKNOWN).any(1)
    for fold, told in enumerate(odds):
        held = labelled & split(data["sources"], data["real"], len(odds), fold)
        taught[held] = told[held]
    return taught


@torch.no_grad()
def scores_of(net: nn.Module, inputs: Tensor) -> np.ndarray:
    """Log-odds (N, labels): the mean over each picture and its mirror image."""
    net.eval()
    found = []
    for rgb8 in inputs.split(128):
        other = torch.from_numpy(mirrored(rgb8.cpu().numpy())).to(rgb8.device)
        found.append((net(rgb8)[0] + net(other)[0]) / 2)
    net.train()
    return torch.cat(found).cpu().numpy()


def train(options: argparse.Namespace) -> None:
    torch.manual_seed(options.seed)
    torch.set_num_threads(options.threads)
    data = _read(options.data)
    labels, real = data["labels"], data["real"]
    odds = [np.load(path) for path in options.teachers]
    if options.older:
        older = log_odds(options.older, data["inputs"])
        odds = [(told + older) / 2 for told in odds]
    taught = teachers_of(odds, data) if odds else None
    held = split(data["sources"], real, options.folds, options.fold)
    labelled = (labels != UNKNOWN).any(1)
    shown, painted = np.flatnonzero(real & labelled & ~held), np.flatnonzero(~real & ~held)
    others = np.flatnonzero(~labelled & ~held)
    share, batch = _shares(labels[shown]), options.batch
    few = round(batch * PAINTED_SHARE)
    more = round(batch * UNLABELLED_SHARE) if odds and len(others) else 0
    net = MakeupNet(labels.shape[1], data["vectors"].shape[1], options.size).to(options.device)
    optimiser = torch.optim.AdamW(net.parameters(), RATE, weight_decay=DECAY)
    state = Checkpoint(options.out.with_suffix(".pt"), net, optimiser, AVERAGE)
    state.resume()  # a finished run trains no more, but is exported again
    # a resumed run must not draw the examples of its beginning again
    rng = np.random.default_rng((options.seed, state.step))
    torch.manual_seed(options.seed + state.step)
    inputs, *truth = (
        torch.from_numpy(each).to(options.device)
        for each in (data["inputs"], *targets_of(labels, taught), data["vectors"], data["weights"])
    )
    began = time.monotonic()
    for step in range(state.step, options.steps):
        drawn = [rng.choice(shown, batch - few - more, p=share)]
        drawn += [rng.choice(others, more)] if more else []
        drawn += [rng.choice(painted, few)]
        at = torch.from_numpy(np.concatenate(drawn)).to(options.device)
        loss = loss_of(net(varied(inputs[at])), *(each[at] for each in truth))
        state.learn(loss, rate_at(step, options.steps, RATE, WARM_UP), CLIP)
        if state.step % options.report == 0 or state.step == options.steps:
            seconds = time.monotonic() - began
            print(f"step {state.step}, {seconds:.0f} s, loss {float(loss.detach()):.3f}")
            state.save(("makeup", labels.shape[1]))
            average = state.average.module
            _report(scores_of(average, inputs[torch.from_numpy(held & real)]), labels[held & real])
    average = state.average.module
    np.save(options.out.with_suffix(".npy"), scores_of(average, inputs))
    export(average.cpu(), options.out)


def _read(paths: list[Path]) -> dict[str, np.ndarray]:
    """The arrays of all files, joined; each file keeps sources of its own."""
    packed = [np.load(path) for path in paths]
    joined = {key: np.concatenate([data[key] for data in packed]) for key in _KEYS}
    # a file has at most 16 sources, its sets
    sources = [data["sources"].astype(int) + 16 * number for number, data in enumerate(packed)]
    return joined | {"sources": np.concatenate(sources)}


def _shares(labels: np.ndarray) -> np.ndarray:
    """(N,) how often each real face is drawn: more often if it wears something rare."""
    worn = labels == 1
    rare = (worn / np.maximum(worn.sum(0), 1)).sum(1)
    share = 1 / len(labels) + 0.5 * rare / max(rare.sum(), 1e-9) * worn.any(1).mean() * 2
    return np.asarray(share / share.sum())


def _report(scores: np.ndarray, labels: np.ndarray) -> None:
    areas = []
    for column in range(labels.shape[1]):
        known = labels[:, column] != UNKNOWN
        areas.append(area_under_curve(scores[known, column], labels[known, column] == 1))
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
    parser.add_argument("--data", type=made_by("worn.prepare"), nargs="+", required=True)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--size", choices=list(CHANNELS), default="small")
    parser.add_argument("--steps", type=int, default=6000)
    parser.add_argument("--batch", type=int, default=40)
    parser.add_argument("--report", type=int, default=500, help="after so many steps, and save")
    parser.add_argument("--folds", type=int, default=FOLDS)
    parser.add_argument("--fold", type=int,
                        help="the one that is held out; default: the last")  # fmt: skip
    parser.add_argument("--teachers", type=existing, nargs="+", default=[],
                        help="log-odds by nets of all folds, in their order")  # fmt: skip
    parser.add_argument("--older", type=existing, metavar="NET.onnx",
                        help="an exported net, averaged with each of the teachers")  # fmt: skip
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--device", default="cpu")
    parser.add_argument("--threads", type=int, default=2)
    chosen = parser.parse_args()
    if chosen.fold is None:
        chosen.fold = chosen.folds - 1
    if not 0 <= chosen.fold < chosen.folds:
        parser.error(f"--fold must be 0 to {chosen.folds - 1}, got {chosen.fold}")
    train(chosen)
