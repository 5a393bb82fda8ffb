"""Trains the dense layers of a net on the colours of crops, before the convolutions learn the rest.

    python -m makeup_video.training.reference.train_head eyes \\
        --shades eyeshadow_shades.csv --out runs/first
    python -m makeup_video.training.reference.train eyes \\
        --shades eyeshadow_shades.csv --start runs/first/eyes-lite0.pt

A minute of this replaces an hour of training the whole net, because the dense layers take only some
hundred numbers of each crop.
"""

import argparse
import os
from pathlib import Path

import cv2
import torch
from makeup_video.pipeline.reference.crops import CROPS, to_targets
from makeup_video.training.faces.model import normalise
from makeup_video.training.reference.model import HEAD, HIDDEN, LEAK, ReferenceNet
from makeup_video.training.reference.rendered_crops import renderer
from makeup_video.training.reference.train import (
    beginning,
    error_of,
    held_out,
    name_of,
    parser_of,
    validate,
)
from torch import Tensor, nn

BATCH, RATE, DECAY = 128, 1e-3, 0.05


def drawn(options: argparse.Namespace, net: ReferenceNet) -> tuple[Tensor, Tensor]:
    """Colours (N, S) of the squares of new crops, and targets (N, 7)."""
    source = renderer(options.data, options.shades, options.region, "train", seed=21)
    squares, targets = [], []
    batches = source.batches(64)
    for _ in range(int(options.crops) // 64):
        rgb8, values = next(batches)
        squares.append(net.squares(normalise(torch.from_numpy(rgb8))))
        targets.append(torch.from_numpy(to_targets(values)).float())
    return torch.cat(squares), torch.cat(targets)


def mirrored(squares: Tensor, region: str, square: int) -> Tensor:
    """Colours (N, S) of the squares of the mirrored crops."""
    across, down = (side // square for side in CROPS[region].input_wh)
    return squares.view(-1, 3, down, across).flip(3).flatten(1)


def train_layers(
    net: ReferenceNet, squares: Tensor, targets: Tensor, region: str, epochs: int
) -> None:
    """Trains the layers and their part of the head.

    The head's weights for the convolutions' features become 0.
    """
    head = nn.Linear(net.head.in_features - HEAD, net.head.out_features)
    nn.init.normal_(head.weight, 0, 0.003)
    head.bias.data.copy_(targets.mean(0))
    both = nn.Sequential(net.colours, head).train()
    optimizer = torch.optim.AdamW(both.parameters(), lr=RATE, weight_decay=DECAY)
    steps = len(squares) // BATCH
    schedule = torch.optim.lr_scheduler.OneCycleLR(optimizer, RATE, total_steps=epochs * steps)
    for epoch in range(epochs):
        total = 0.0
        for chosen in torch.randperm(len(squares))[: steps * BATCH].split(BATCH):
            batch = squares[chosen]
            if torch.rand(1) < 0.5:
                batch = mirrored(batch, region, net.square)
            loss = error_of(nn.functional.leaky_relu(both(batch), LEAK), targets[chosen])
            optimizer.zero_grad()
            loss.backward()
            optimizer.step()
            schedule.step()
            total += loss.item()
        print(f"epoch {epoch + 1}/{epochs} loss {total / steps:.4f}", flush=True)
    with torch.no_grad():
        net.head.weight.zero_()
        net.head.weight[:, HEAD:] = head.weight
        net.head.bias.copy_(head.bias)


def main() -> None:
    parser = parser_of(__doc__, [name for name, widths in HIDDEN.items() if widths])
    parser.add_argument("--out", type=Path, default=Path("runs/first"))
    parser.add_argument("--crops", type=float, default=7e4)
    parser.add_argument("--epochs", type=int, default=48)
    options = parser.parse_args()
    options.shrink, options.rate, options.start, options.held_out = 2, RATE, None, 768
    os.environ["POCL_MAX_PTHREAD_COUNT"] = "1"
    cv2.setNumThreads(1)
    run = beginning(options)
    if run.step:
        raise SystemExit(
            f"{run.path} has been trained already: move it away, or give another --out"
        )
    net: ReferenceNet = run.net  # type: ignore[assignment]
    train_layers(net, *drawn(options, net), options.region, options.epochs)
    run.average.module.load_state_dict(net.state_dict())
    run.save((name_of(options), net.head.out_features))
    print("held out:", validate(run.average, held_out(options)))


if __name__ == "__main__":
    main()
