"""Trains the reference net of a region. A stopped run resumes from its checkpoint.

    python -m makeup_video.training.reference.train lips --net lite0 --shades lip_shades.csv

Separate processes draw the crops on the fly. Both people and products are held out.
"""

import argparse
import os
import sys
import time
from collections.abc import Iterable, Iterator
from pathlib import Path

import cv2
import numpy as np
import torch
from makeup_video.pipeline.reference.crops import CROPPED, NUMBERS, from_targets, to_targets
from makeup_video.training.faces.checkpoint import Checkpoint, rate_at
from makeup_video.training.faces.model import normalise
from makeup_video.training.inputs import existing, made_by
from makeup_video.training.reference.draw_products import (
    COLOUR_SEEN,
    Mixture,
    errors_in_words,
    read_products,
)
from makeup_video.training.reference.model import SIZES, ReferenceNet
from makeup_video.training.reference.rendered_crops import renderer
from torch import Tensor, nn
from torch.utils.data import DataLoader, IterableDataset, get_worker_info

WARM_UP = 300  # steps
AVERAGE = 0.999  # of the weights, per step
SAVE_SECONDS = 180
# Weight of the colour of an invisible product; from the opacity COLOUR_SEEN on the weight is 1.
COLOUR_LEAST = 0.05
PAINTED_WEIGHT = 5.0  # of the error of worn colours, in the loss
# Lips and lids from light to dark skin, in neutral light: looks are compared on these.
BARE = torch.tensor(
    [[0.82, 0.60, 0.54], [0.68, 0.45, 0.40], [0.55, 0.33, 0.29], [0.32, 0.19, 0.17]]
)


class Stream(IterableDataset):
    """Batches from a separate process with its own OpenCL device."""

    def __init__(self, options: argparse.Namespace, seed: int) -> None:
        self.options, self.seed = options, seed

    def __iter__(self) -> Iterator[tuple[Tensor, Tensor]]:
        cv2.setNumThreads(1)
        options, worker = self.options, get_worker_info()
        seed = self.seed * 64 + (worker.id if worker else 0)
        source = renderer(options.data, options.shades, options.region, "train", seed)
        for rgb8, values in source.batches(options.batch):
            yield torch.from_numpy(rgb8), torch.from_numpy(to_targets(values)).float()


def weight_of(targets: Tensor) -> Tensor:
    """(N, 7) the weight of each number; the colour of a sheer product hardly shows."""
    weight = torch.ones_like(targets)
    weight[:, 1:4] = (targets[:, :1] / COLOUR_SEEN).clamp(COLOUR_LEAST, 1)
    return weight


def painted(targets: Tensor) -> Tensor:
    """Targets (N, 7) -> (N, 4, 3) encoded colours of lips or lids that wear the product.

    Opacity mixes roots of light, which are about encoded values. A single photo hardly
    distinguishes a sheer strong colour from a thick pale one. On a face both look alike, so the
    loss compares the look.
    """
    opacity = targets[:, :1, None]
    return opacity * targets[:, None, 1:4] + (1 - opacity) * BARE


def inputs(rgb8: Tensor) -> Tensor:
    """Crops (N, H, W, 3) uint8 -> the tensor (N, 3, H, W) that the net takes."""
    return normalise(rgb8).to(memory_format=torch.channels_last)


def error_of(estimated: Tensor, targets: Tensor) -> Tensor:
    """The loss: squared error of targets (N, 7), and of the colours they have when worn."""
    weight = weight_of(targets)
    numbers = ((estimated - targets).square() * weight).sum() / weight.sum()
    worn = (painted(estimated) - painted(targets)).square().mean()
    return numbers + PAINTED_WEIGHT * worn


def held_out(options: argparse.Namespace) -> tuple[Tensor, Tensor]:
    """Varied crops of people and products of the validation split, always the same."""
    source = renderer(options.data, options.shades, options.region, "validation", seed=1)
    rgb8, values = next(source.batches(options.held_out, mix=1))
    return torch.from_numpy(rgb8), torch.from_numpy(to_targets(values)).float()


@torch.no_grad()
def estimates(net: nn.Module, rgb8: Tensor) -> Tensor:
    """Targets (N, 7) that the net computes."""
    net.eval()
    return torch.cat([net(inputs(part)) for part in rgb8.split(64)])


def validate(net: nn.Module, crops: tuple[Tensor, Tensor]) -> str:
    """One line of errors on held-out crops."""
    rgb8, targets = crops
    estimated = estimates(net, rgb8)
    off = 255 * (painted(estimated) - painted(targets)).abs().mean((1, 2))
    return (
        f"loss {error_of(estimated, targets):.4f}; "
        f"worn {off.median():.2f}, 90 % {off.quantile(0.9):.2f}; "
        f"{errors_in_words(from_targets(targets.numpy()), from_targets(estimated.numpy()))}"
    )


def name_of(options: argparse.Namespace) -> str:
    """The name of a net in its checkpoint; `export.load` reads it."""
    return f"{options.region}-{options.net}-{options.shrink}"


def beginning(options: argparse.Namespace, steps: int | None = None) -> Checkpoint:
    """A net, its running average and its optimizer: new, or from the last run.

    steps: as in Checkpoint.resume.
    """
    torch.manual_seed(0)
    options.out.mkdir(parents=True, exist_ok=True)
    products = read_products(options.shades, options.region)
    drawn = Mixture(products.values[products.split == 0]).draw(20000, np.random.default_rng(0))
    mean = torch.from_numpy(to_targets(drawn).mean(0)).float()
    net = ReferenceNet(options.net, mean, options.region, options.shrink)
    net = net.to(memory_format=torch.channels_last).train()
    optimizer = torch.optim.AdamW(net.parameters(), lr=options.rate, weight_decay=0.02)
    run = Checkpoint(options.out / f"{options.region}-{options.net}.pt", net, optimizer, AVERAGE)
    if options.start and not run.path.exists():
        run.start_from(options.start)
    run.resume(steps)
    return run


def parser_of(doc: str, regions: Iterable[str]) -> argparse.ArgumentParser:
    """A parser of the region, the net and the training data."""
    parser = argparse.ArgumentParser(description=doc.splitlines()[0])
    parser.add_argument("region", choices=regions)
    parser.add_argument("--net", choices=list(SIZES), default="lite0")
    parser.add_argument("--data", type=made_by("reference.prepare"), default="runs/reference.npz")
    parser.add_argument("--shades", type=existing, required=True)
    return parser


def parsed() -> argparse.Namespace:
    parser = parser_of(__doc__, CROPPED)
    parser.add_argument("--out", type=Path, default=Path("runs"))
    parser.add_argument("--samples", type=float, default=4e5)
    parser.add_argument("--batch", type=int, default=64)
    parser.add_argument("--rate", type=float, default=1.5e-3)
    parser.add_argument("--held-out", type=int, default=768, help="crops for validation")
    parser.add_argument(
        "--shrink",
        type=int,
        choices=(1, 2),
        default=2,
        help="how many times the net shrinks crops; 1 takes four times as long",
    )
    parser.add_argument("--start", type=existing, help="begin with the weights of this checkpoint")
    parser.add_argument("--threads", type=int, default=2, help="threads of the net")
    parser.add_argument("--workers", type=int, default=1, help="processes that draw crops")
    return parser.parse_args()


def main() -> None:
    options = parsed()
    os.environ["POCL_MAX_PTHREAD_COUNT"] = "1"  # inherited by the processes that draw
    cv2.setNumThreads(1)
    torch.set_num_threads(options.threads)
    steps = int(options.samples / options.batch)
    run = beginning(options, steps)
    watched = held_out(options)
    # OpenCL does not survive a fork.
    loader = iter(DataLoader(
        Stream(options, seed=run.step + 1), None, num_workers=options.workers,
        multiprocessing_context="spawn", prefetch_factor=4,
    ))  # fmt: skip
    running, counted, since, saved_at = 0.0, 0, time.time(), time.time()
    while run.step < steps:
        rgb8, targets = next(loader)
        loss = error_of(run.net(inputs(rgb8)), targets)
        run.learn(loss, rate_at(run.step, steps, options.rate, WARM_UP), clip=1.0)
        running, counted = running + loss.item(), counted + 1
        if run.step % 100 == 0 or run.step == steps:
            speed = counted * options.batch / (time.time() - since)
            print(f"{time.strftime('%H:%M:%S')} step {run.step}/{steps} "
                  f"loss {running / counted:.4f} {speed:.0f}/s", flush=True)  # fmt: skip
            running, counted, since = 0.0, 0, time.time()
        if time.time() - saved_at > SAVE_SECONDS or run.step == steps:
            run.save((name_of(options), len(NUMBERS)))
            print("  held out:", validate(run.average, watched), flush=True)
            saved_at = time.time()
            running, counted, since = 0.0, 0, time.time()
    # PoCL's threads abort a process that has drawn crops when it ends normally, and that would be
    # reported as an error.
    sys.stdout.flush()
    os._exit(0)


if __name__ == "__main__":
    main()
