"""Fits a trained net's points to crops of another width, by least squares.

    python -m makeup_video.training.faces.fit_points lips --start runs/lips_first.pt

Only the layer of the shape's coefficients changes: its outputs go through the affine map that
brings the points nearest to those of training crops. Features, and so masks, stay as they are.
Further training of that layer, with everything else frozen, brings the points no nearer.
"""

import argparse
from pathlib import Path

import torch
from makeup_video.training.faces.checkpoint import averaged_weights, saved_in
from makeup_video.training.faces.crops import SPECS, Cropper, Faces
from makeup_video.training.faces.model import PointNet, build, normalise
from makeup_video.training.faces.train import point_worth, tensors
from makeup_video.training.inputs import existing, made_by
from torch import Tensor

BATCH = 128
RIDGE = 0.05  # share of each coefficient's mean square; pulls towards unchanged coefficients
ROUNDS = 6  # of the fit; in each, a crop counts less the further off its points are
HIDDEN = 0.5  # a crop whose points have a lower mean weight does not count: most are hidden
DEPTH = 0.3  # weight of an error in depth, against one in the picture
_LAYER = "points.coefficients"


def shapes_of(
    net: PointNet, cropper: Cropper, worth: Tensor, samples: int
) -> tuple[Tensor, Tensor]:
    """The coefficients that a net reads in crops, and those that come nearest to the true points,
    (N, C) float64 each.

    worth: (K,), the weight of each point.
    """
    counts = (worth.double().sqrt()[:, None] * torch.tensor([1, 1, DEPTH])).flatten().double()
    mean, basis = net.points.mean.detach().double(), net.points.basis.detach().double()
    read, true = [], []
    for _ in range(samples // BATCH):
        rgb8, points, weight, *_ = tensors(cropper.batch(BATCH))
        x = normalise(rgb8).to(memory_format=torch.channels_last)
        with torch.no_grad():
            for block in net.stages:
                x = block(x)
            coefficients = net.points.coefficients(x.flatten(1)).double()
        off = (points.double() - mean).flatten(1) * counts
        nearest = torch.linalg.lstsq((basis * counts).T, off.T).solution.T
        seen = weight.mean(1) > HIDDEN
        read.append(coefficients[seen])
        true.append(nearest[seen])
    return torch.cat(read), torch.cat(true)


def affine_of(read: Tensor, true: Tensor, basis: Tensor) -> tuple[Tensor, Tensor]:
    """The matrix (C, C) and shift (C,) with which `read @ matrix + shift` comes nearest to `true`.

    basis: (C, 3 K), how each coefficient moves the points.
    """
    count = read.shape[1]
    given = torch.cat([read, torch.ones(len(read), 1, dtype=read.dtype)], 1)
    stiff = RIDGE * torch.diag(given.square().mean(0))
    stays = torch.eye(count + 1, count, dtype=read.dtype)
    weight = torch.ones(len(read), dtype=read.dtype)
    for _ in range(ROUNDS):
        weighted = given * weight[:, None]
        normal = weighted.T @ given + weight.sum() * stiff
        found = torch.linalg.solve(normal, weighted.T @ true + weight.sum() * stiff @ stays)
        off = ((given @ found - true) @ basis).norm(dim=1)
        weight = 1 / (off + off.median() / 2)
    return found[:count], found[count]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("net", choices=list(SPECS))
    parser.add_argument("--start", type=existing, required=True, help="a checkpoint of that net")
    parser.add_argument("--data", type=made_by("faces.prepare"), default="runs/faces.npz")
    parser.add_argument("--out", type=Path, default=Path("runs"))
    parser.add_argument("--samples", type=float, default=3e4)
    options = parser.parse_args()
    faces, spec = Faces(options.data, validation=False), SPECS[options.net]
    cropper = Cropper(faces, spec, seed=7)
    index = cropper.rng.choice(len(cropper.p), 2000, p=cropper.p)
    net = build(options.net, spec.size_wh, torch.from_numpy(cropper.geometry(index)["target"]))
    net.load_state_dict(averaged_weights(options.start))
    worth = point_worth(options.net, faces.mirror)
    read, true = shapes_of(net.eval(), cropper, worth, int(options.samples))
    matrix, shift = affine_of(read, true, net.points.basis.detach().double())
    checkpoint = saved_in(options.start)
    for state, prefix in ((checkpoint["net"], ""), (checkpoint["average"], "module.")):
        layer, bias = (f"{prefix}{_LAYER}.{part}" for part in ("weight", "bias"))
        state[layer] = (matrix.T @ state[layer].double()).float()
        state[bias] = (state[bias].double() @ matrix + shift).float()
    options.out.mkdir(parents=True, exist_ok=True)
    torch.save(checkpoint, options.out / f"{options.net}.pt")


if __name__ == "__main__":
    main()
