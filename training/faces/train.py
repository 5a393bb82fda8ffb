"""Trains one of the face nets. A stopped run resumes from its last checkpoint.

python -m makeup_video.training.faces.train mesh --data runs/faces.npz --samples 2e6
"""

import argparse
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import cv2
import numpy as np
import torch
from makeup_video.pipeline.faces.topology import EYE, EYE_CONTOUR, LIPS
from makeup_video.training.faces.checkpoint import Checkpoint, rate_at, saved_in
from makeup_video.training.faces.crops import SPECS, Batch, Cropper, Faces
from makeup_video.training.faces.model import build, normalise
from makeup_video.training.inputs import existing, made_by
from torch import Tensor, nn
from torch.utils.data import DataLoader, IterableDataset

BATCH = 128
WARM_UP = 500  # steps
AVERAGE = 0.9995  # of the weights, per step
BORDER = 3.0  # weight added to px at the border of a mouth's opening; other px have 1
BESIDE = 3  # px: how far the border reaches to either side
TEETH = 0.1  # weight of the teeth in the opening, against the whole mouth and the opening
# Without bfloat16 units a processor multiplies in bfloat16 eight times as slowly as in float32.
_CAN = torch.cpu.get_capabilities()
IN_BFLOAT16 = bool(_CAN.get("amx_bf16") or _CAN.get("avx512_bf16"))


class Stream(IterableDataset):
    """Batches from a background process, so that the net never waits for pictures."""

    def __init__(self, faces: Faces, net: str, seed: int) -> None:
        self.faces, self.net, self.seed = faces, net, seed

    def __iter__(self) -> Iterator[tuple[Tensor, ...]]:
        cv2.setNumThreads(1)
        cropper = Cropper(self.faces, SPECS[self.net], self.seed)
        yield from map(tensors, cropper.stream(BATCH))


def tensors(batch: Batch) -> tuple[Tensor, ...]:
    columns = (batch.rgb8, batch.points, batch.weight, batch.labels, batch.mask)
    return tuple(torch.from_numpy(column) for column in columns if column is not None)


def cross_entropy_of(logits: Tensor, shares: Tensor, known: Tensor) -> Tensor:
    """The mean cross-entropy of whole mouth and opening where they are known, and of teeth in the
    opening as far as they are known.

    logits: (N, 3, H, W), as in LipNet.  shares: (N, 3, H, W), as in Mouth.  known: (N, H, W).
    """
    wrong = nn.functional.binary_cross_entropy_with_logits(logits, shares, reduction="none")
    _, opening, teeth = shares.unbind(1)
    around = nn.functional.avg_pool2d(opening[:, None], 2 * BESIDE + 1, 1, BESIDE)[:, 0]
    worth = known * (1 + BORDER * 4 * around * (1 - around))
    of_mouth = (wrong[:, :2].sum(1) * worth).sum() / worth.sum().clamp(min=1)
    there = known * opening * (2 * teeth - 1).abs()
    return of_mouth + TEETH * (wrong[:, 2] * there).sum() / there.sum().clamp(min=1)


def mask_loss(logits: Tensor, mask: Tensor) -> Tensor:
    """The cross-entropy of masks, and the soft Dice loss of the lips.

    logits: (N, 3, H, W), as in LipNet.  mask: (N, H, W, 4), as in Batch.
    """
    *shares, known = (mask.float() / 255).unbind(-1)
    whole, opening, _ = shares
    cross = cross_entropy_of(logits.float(), torch.stack(shares, 1), known)
    painted = logits[:, 0].sigmoid() * (-logits[:, 1]).sigmoid() * known
    target = whole * (1 - opening)
    both, sums = (painted * target).sum((1, 2)), (painted + target * known).sum((1, 2))
    lips = (target * known).sum((1, 2)) > 60
    dice = 1 - (2 * both + 1) / (sums + 1)
    return cross + 0.1 * (dice * lips).sum() / lips.sum().clamp(min=1)


def point_worth(net: str, mirror: np.ndarray) -> Tensor:
    """Weights (K,) of the points: those around lips and eyes, which are painted, count most."""
    worth = np.ones(478, np.float32)
    worth[LIPS] = 2
    worth[EYE], worth[mirror[EYE]] = 1.5, 1.5
    worth[EYE_CONTOUR], worth[mirror[EYE_CONTOUR]] = 3, 3
    chosen = worth[SPECS[net].points]
    return torch.from_numpy(chosen / chosen.mean())


def point_error(points: Tensor, target: Tensor) -> Tensor:
    """Errors (N, K) in IOD: the distance in the picture, and a share of the depth error."""
    off = points - target
    return (off[..., :2].square().sum(-1) + 0.1 * off[..., 2].square() + 1e-7).sqrt()


def loss_of(net: Callable, batch: tuple[Tensor, ...], worth: Tensor) -> tuple[Tensor, Tensor]:
    rgb8, target, weight, labels, *mask = batch
    x = normalise(rgb8).to(memory_format=torch.channels_last)
    with torch.autocast("cpu", dtype=torch.bfloat16, enabled=IN_BFLOAT16):
        points, logits, *painted = net(x)
    weight = weight * worth
    error = (point_error(points, target) * weight).sum() / weight.sum().clamp(min=1)
    judged = labels.clone()
    # without a face, the score of the mouth does not count
    importance = torch.stack([torch.ones(len(labels)), labels[:, 0]], 1)
    score = nn.functional.binary_cross_entropy_with_logits(logits, judged, importance)
    loss = error + 0.02 * score
    if mask:
        loss = loss + 0.3 * mask_loss(painted[0], mask[0])
    return loss, error


@torch.no_grad()
def validate(net: nn.Module, faces: Faces, name: str) -> str:
    """Mean errors in % of IOD on held-out faces by source: all points, lips, eye contours."""
    net.eval()
    cropper = Cropper(faces, SPECS[name], seed=1, augment=False)
    index = np.flatnonzero(faces.folder != "covered")
    errors, overlaps = [], []
    for part in np.array_split(index, max(1, len(index) // 64)):
        rgb8, target, _, _, *mask = tensors(cropper.batch(len(part), part))
        points, _, *painted = net(normalise(rgb8).to(memory_format=torch.channels_last))
        if mask:
            ours = painted[0] > 0
            theirs = (mask[0][..., 0] > 127) & (mask[0][..., 1] <= 127)
            iou = (ours & theirs).sum((1, 2)) / (ours | theirs).sum((1, 2)).clamp(min=1)
            overlaps.append(iou[torch.tensor([int(face) in faces.masks for face in part])])
        errors.append(100 * (points - target)[..., :2].norm(dim=2))
    net.train()
    error = torch.cat(errors).numpy()
    groups = {
        "lips": np.isin(SPECS[name].points, LIPS),
        "eyes": np.isin(SPECS[name].points, np.r_[EYE_CONTOUR, faces.mirror[EYE_CONTOUR]]),
    }
    report = []
    for source in np.unique(faces.source[index]):
        of_source = error[faces.source[index] == source]
        parts = [f"{of_source[:, inside].mean():.2f}" for inside in groups.values() if inside.any()]
        report.append(f"{source[:9]} {of_source.mean():.2f} " + " ".join(parts))
    if overlaps:
        report.append(f"mask IoU {torch.cat(overlaps).mean():.4f}")
    return " | ".join(report)


@torch.no_grad()
def inherit(net: nn.Module, average: dict[str, Tensor]) -> None:
    """Take over averaged weights as far as they fit, even from a net with fewer channels."""
    for key, value in net.state_dict().items():
        old = average.get(f"module.{key}", value)
        common = tuple(slice(min(a, b)) for a, b in zip(value.shape, old.shape, strict=True))
        value[common] = old[common]


def beginning(options: argparse.Namespace, faces: Faces, steps: int) -> Checkpoint:
    """A net, its running average and its optimizer: new, or from the last run."""
    spec = SPECS[options.net]
    drawer = Cropper(faces, spec, seed=0)
    index = drawer.rng.choice(len(drawer.p), 6000, p=drawer.p)
    targets = drawer.geometry(index)["target"]
    net = build(options.net, spec.size_wh, torch.from_numpy(targets))
    if options.start:
        inherit(net, saved_in(options.start)["average"])
    net = net.to(memory_format=torch.channels_last).train()
    optimizer = torch.optim.AdamW(net.parameters(), lr=options.rate, weight_decay=0.05, fused=True)
    run = Checkpoint(options.out / f"{options.net}.pt", net, optimizer, AVERAGE)
    run.resume(steps)
    return run


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("net", choices=list(SPECS))
    parser.add_argument("--data", type=made_by("faces.prepare"), default="runs/faces.npz")
    parser.add_argument("--out", type=Path, default=Path("runs"))
    parser.add_argument("--samples", type=float, default=2e6)
    parser.add_argument("--rate", type=float, default=2e-3)
    parser.add_argument("--start", type=existing, help="begin with the weights of this checkpoint")
    options = parser.parse_args()
    torch.set_num_threads(2)
    masks = options.data.with_name("lipmasks.npz")
    if options.net == "lips" and not masks.exists():
        raise SystemExit(f"{masks} is missing: make it with training.faces.lip_masks")
    faces, held_out = Faces(options.data, False), Faces(options.data, True)
    steps = int(options.samples / BATCH)
    run = beginning(options, faces, steps)
    worth = point_worth(options.net, faces.mirror)
    loader = iter(DataLoader(Stream(faces, options.net, seed=run.step), None, num_workers=1,
                             prefetch_factor=8))  # fmt: skip
    forward = torch.compile(run.net) if IN_BFLOAT16 else run.net  # float32 gains nothing
    running, counted, since, saved_at = 0.0, 0, time.time(), time.time()
    while run.step < steps:
        rate = rate_at(run.step, steps, options.rate, WARM_UP)
        loss, error = loss_of(forward, next(loader), worth)
        run.learn(loss, rate, clip=1.0)
        running, counted = running + error.item(), counted + 1
        if run.step % 200 == 0:
            speed = counted * BATCH / (time.time() - since)
            print(
                f"{time.strftime('%H:%M:%S')} step {run.step}/{steps} error "
                f"{100 * running / counted:.2f} % rate {rate:.1e} {speed:.0f}/s",
                flush=True,
            )
            running, counted, since = 0.0, 0, time.time()
        if time.time() - saved_at > 150 or run.step == steps:
            run.save((options.net, len(SPECS[options.net].points)))
            print("  held out:", validate(run.average, held_out, options.net), flush=True)
            running, counted, saved_at, since = 0.0, 0, time.time(), time.time()


if __name__ == "__main__":
    main()
