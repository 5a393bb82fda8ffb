"""Trains the detector, which finds the place, the size and the turn of faces.

python -m makeup_video.training.faces.train_detector --data runs/faces.npz --samples 6e5
"""

import argparse
import time
from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
import torch
from makeup_video.pipeline.faces.nets import decode_cells
from makeup_video.training.faces.checkpoint import Checkpoint, averaged_weights
from makeup_video.training.faces.crops import Faces
from makeup_video.training.faces.detector_pictures import FACE_CENTRE, SCENE, STRIDE, Scenes
from makeup_video.training.faces.model import Conv, Join, Residual, normalise, stage
from makeup_video.training.faces.occluders import blot_out
from makeup_video.training.faces.train import IN_BFLOAT16
from makeup_video.training.inputs import existing, made_by
from torch import Tensor, nn
from torch.utils.data import DataLoader, IterableDataset

BATCH = 48
AVERAGE = 0.998  # of the weights, per step
CELLS = SCENE // STRIDE


class Detector(nn.Module):
    """(N, 3, H, W), sides a multiple of 32 -> (N, 6, H/8, W/8).

    Per cell: face logit; centre dx, dy in cells; log of IOD in cells; cosine, sine of the turn.
    """

    def __init__(self) -> None:
        super().__init__()
        self.near = nn.Sequential(Conv(3, 8, 2), Conv(8, 16, 2), Conv(16, 32, 2), Residual(32))
        self.far = nn.ModuleList([stage(32, 48, 1), stage(48, 64, 1)])
        self.down = nn.ModuleList([nn.Conv2d(64, 48, 1), nn.Conv2d(48, 32, 1)])
        self.join = nn.ModuleList([Join("nearest"), Join("nearest")])
        self.merge = nn.ModuleList([Conv(48, 48), Conv(32, 32)])
        self.out = nn.Conv2d(32, 6, 1)
        nn.init.constant_(self.out.bias[:1], -4)

    def forward(self, x: Tensor) -> Tensor:
        levels = [self.near(x)]
        for block in self.far:
            levels.append(block(levels[-1]))
        x = levels.pop()
        for down, join, merge in zip(self.down, self.join, self.merge, strict=True):
            x = merge(join(down(x), levels.pop()))
        return self.out(x).float()


def targets(faces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Faces (F, 4) -> heat (C, C) in [0, 1], and (6, C, C): five values and a weight per cell."""
    heat = np.zeros((CELLS, CELLS), np.float32)
    values = np.zeros((6, CELLS, CELLS), np.float32)
    y, x = np.mgrid[:CELLS, :CELLS].astype(np.float32)
    for centre_x, centre_y, unit, turn in faces:
        at_x, at_y = (centre_x + 0.5) / STRIDE - 0.5, (centre_y + 0.5) / STRIDE - 0.5
        reach = np.clip(unit / STRIDE * 0.35, 0.7, 3.5)
        near = np.exp(-((x - at_x) ** 2 + (y - at_y) ** 2) / (2 * reach**2))
        ours = near > np.maximum(heat, 0.3)
        numbers = (at_x - x, at_y - y, np.log(unit / STRIDE), np.cos(turn), np.sin(turn), 1.0)
        for plane, number in zip(values, numbers, strict=True):
            plane[ours] = np.broadcast_to(number, x.shape)[ours]
        heat = np.maximum(heat, near)
        cell = np.clip(np.rint([at_y, at_x]).astype(int), 0, CELLS - 1)
        heat[tuple(cell)] = 1
    return heat, values


def detector_loss(out: Tensor, heat: Tensor, values: Tensor) -> Tensor:
    score, positive = out[:, 0].sigmoid().clamp(1e-4, 1 - 1e-4), heat == 1
    hit = -((1 - score) ** 2 * score.log())[positive].sum()
    miss = -((1 - heat) ** 4 * score**2 * (1 - score).log())[~positive].sum()
    off = ((out[:, 1:] - values[:, :5]).abs() * values[:, 5:]).sum()
    count = positive.sum().clamp(min=1)
    return (hit + miss) / count + off / values[:, 5].sum().clamp(min=1)


def decode(out: np.ndarray, scale: float, threshold: float = 0.35) -> list[np.ndarray]:
    """(6, C, C) -> poses (2, 3) in image px, surest first. scale: image px per input px."""
    poses = [pose for _, pose in decode_cells(out, threshold)]
    return [(pose.array() * scale).astype(np.float32) for pose in poses]


def letterbox(rgb8: np.ndarray) -> tuple[np.ndarray, float]:
    """The whole picture, top left in a (256, 256) square, and image px per px of the square."""
    scale = max(rgb8.shape[:2]) / SCENE
    size = [max(1, round(side / scale)) for side in rgb8.shape[1::-1]]
    small = cv2.resize(rgb8, size, interpolation=cv2.INTER_AREA)
    square = np.zeros((SCENE, SCENE, 3), np.uint8)
    square[: size[1], : size[0]] = small
    return square, scale


@torch.no_grad()
def hide_strangers(faces: Faces, net: nn.Module) -> int:
    """Paint over, in place, what a net takes for further faces; returns their number.

    Only one face of a picture is labelled. The detector would learn the others as background.
    """
    rng, hidden = np.random.default_rng(0), 0
    for levels, own, folder in zip(faces.pictures, faces.poses, faces.folder, strict=True):
        if folder not in ("wild", "covered"):  # the other folders show one person each
            continue
        square, scale = letterbox(levels[0])
        out = net(normalise(torch.from_numpy(square[None])).to(memory_format=torch.channels_last))
        for pose in decode(out[0].numpy(), scale, threshold=0.5):
            unit = np.linalg.norm(pose[:, 0])
            middle = pose @ [*FACE_CENTRE, 1]
            if np.hypot(*(middle - own @ [*FACE_CENTRE, 1])) < 0.8 * np.linalg.norm(own[:, 0]):
                continue
            turn = np.arctan2(pose[1, 0], pose[0, 0])
            for level, rgb8 in enumerate(levels):
                place = np.array([*(middle / 2**level), unit / 2**level, turn])
                blot_out(rgb8, place, rng)
            hidden += 1
    return hidden


def load_average(path: Path) -> nn.Module:
    """A detector with the averaged weights of a checkpoint."""
    net = Detector().to(memory_format=torch.channels_last)
    net.load_state_dict(averaged_weights(path))
    return net.eval()


class Stream(IterableDataset):
    """Batches of scenes; each scene comes once more, mirrored and in another tone."""

    def __init__(self, faces: Faces, seed: int) -> None:
        self.faces, self.seed = faces, seed

    def __iter__(self) -> Iterator[tuple[Tensor, ...]]:
        cv2.setNumThreads(1)
        scenes, recent = Scenes(self.faces, self.seed), []
        while True:
            recent.append([scenes.draw() for _ in range(BATCH)])
            yield tensors(recent[-1])
            if len(recent) > 12:
                past = recent.pop(int(scenes.rng.integers(6)))
                yield tensors([echo(*drawn, scenes.rng) for drawn in past])


def tensors(drawn: list[tuple[np.ndarray, np.ndarray]]) -> tuple[Tensor, ...]:
    heat, values = zip(*(targets(faces) for _, faces in drawn), strict=True)
    columns = ([rgb8 for rgb8, _ in drawn], heat, values)
    return tuple(torch.from_numpy(np.stack(column)) for column in columns)


def echo(
    rgb8: np.ndarray, faces: np.ndarray, rng: np.random.Generator
) -> tuple[np.ndarray, np.ndarray]:
    """The scene mirrored and in another tone: a tenth of the work of a new scene."""
    tone = np.arange(256)[:, None] * np.exp(rng.normal(0, 0.2) + rng.normal(0, 0.08, 3))
    rgb8 = cv2.LUT(np.ascontiguousarray(rgb8[:, ::-1]), tone.clip(0, 255).astype(np.uint8)[None])
    return rgb8, faces * [-1, 1, 1, -1] + [SCENE - 1, 0, 0, 0]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--data", type=made_by("faces.prepare"), default="runs/faces.npz")
    parser.add_argument("--out", type=Path, default=Path("runs"))
    parser.add_argument("--samples", type=float, default=6e5)
    parser.add_argument("--rate", type=float, default=2e-3)
    parser.add_argument("--start", type=existing, help="begin with the weights of this checkpoint")
    parser.add_argument(
        "--minutes", type=float, default=np.inf, help="stop after so many minutes at the latest"
    )
    parser.add_argument(
        "--threads", type=int, default=2, help="threads of the net; 1 on a shared machine"
    )
    options = parser.parse_args()
    torch.set_num_threads(1)  # a single scene is too little work for two threads
    cv2.setNumThreads(1)  # OpenCV's threads do not survive the loader's fork
    options.out.mkdir(parents=True, exist_ok=True)
    net = Detector().to(memory_format=torch.channels_last).train()
    optimizer = torch.optim.AdamW(net.parameters(), lr=options.rate, weight_decay=0.02, fused=True)
    run = Checkpoint(options.out / "detector.pt", net, optimizer, AVERAGE)
    if options.start and not run.path.exists():
        run.start_from(options.start)
    run.resume(int(options.samples / BATCH))
    faces = Faces(options.data, False)
    if options.start:
        strangers = hide_strangers(faces, load_average(options.start))
        print("painted over", strangers, "faces without a label", flush=True)
    torch.set_num_threads(options.threads)
    train(run, faces, options)


def train(run: Checkpoint, faces: Faces, options: argparse.Namespace) -> None:
    """Train at a constant rate, which falls to almost 0 over the last 40 % of samples or time."""
    steps, began = int(options.samples / BATCH), time.time()
    stream = Stream(faces, seed=run.step)
    loader = iter(DataLoader(stream, None, num_workers=1, prefetch_factor=8))
    forward = torch.compile(run.net) if IN_BFLOAT16 else run.net  # float32 gains nothing
    since, running, counted = time.time(), 0.0, 0
    done = run.step / steps
    while done < 1:
        rate = options.rate * min(1, (run.step + 1) / 300, 2.5 * (1 - done) + 0.005)
        rgb8, heat, values = next(loader)
        x = normalise(rgb8).to(memory_format=torch.channels_last)
        with torch.autocast("cpu", dtype=torch.bfloat16, enabled=IN_BFLOAT16):
            out = forward(x)
        loss = detector_loss(out, heat, values)
        run.learn(loss, rate, clip=2.0)
        running, counted = running + loss.item(), counted + 1
        done = max(run.step / steps, (time.time() - began) / 60 / options.minutes)
        if run.step % 200 == 0 or done >= 1:
            speed = counted * BATCH / (time.time() - since)
            print(f"{time.strftime('%H:%M:%S')} step {run.step}/{steps} loss "
                  f"{running / counted:.3f} rate {rate:.1e} {speed:.0f}/s", flush=True)  # fmt: skip
            run.save(("detector", 0))
            since, running, counted = time.time(), 0.0, 0


if __name__ == "__main__":
    main()
