"""Teach the mesh net's face score what only looks like a face.

    python -m makeup_video.training.faces.train_face_score --checkpoints runs --weights runs/weights

The points' training shows the net few crops without a face, and easy ones. What it meets in use
are the detector's mistakes: shoes, patterns, a chin taken for a small face. So these are gathered
here: what the detector finds beside the faces, where the mesh net then goes from there, parts of
faces, faces that lie or stand on their head. Only the layer that tells the score learns; points
stay as they are.
"""

import argparse
from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
import torch
from makeup_video.training.faces.augment import photograph
from makeup_video.training.faces.crops import SPECS, Cropper, Faces
from makeup_video.training.faces.detector_pictures import FACE_CENTRE, backdrops
from makeup_video.training.faces.export import load
from makeup_video.training.faces.infer import Net, from_onnx, place, take, window
from makeup_video.training.faces.model import PointNet, normalise
from makeup_video.training.faces.prepare import frames_of
from makeup_video.training.faces.train_detector import decode
from torch import Tensor, nn

SPEC = SPECS["mesh"]
SIDES = (256, 512)  # px: the sizes that the product's detector looks at
DOUBTFUL = 0.05  # a guess this sure already teaches something
BATCH = 256


class NoFaces:
    """Draws crops (96, 96, 3) that show no face, or one that is not meant: tilted, or a part."""

    def __init__(self, faces: Faces, mesh: Net, detector: Net, seed: int) -> None:
        self.faces, self.mesh, self.detector = faces, mesh, detector
        self.rng = np.random.default_rng(seed)
        self.cropper = Cropper(faces, SPEC, seed)
        self.backdrops = backdrops()

    def stream(self) -> Iterator[np.ndarray]:
        while True:
            if self.rng.random() < 0.15:
                picture = self._backdrop()
                yield from self._mistakes(picture, None)
                continue
            face = int(self.rng.choice(len(self.cropper.p), p=self.cropper.p))
            picture, frame = self.faces.pictures[face][0], self.faces.frames[face]
            yield photograph(self._part(picture, frame), self.rng)
            yield photograph(self._tilted(picture, frame), self.rng)
            if self.faces.folder[face] in ("portraits", "talking"):  # nobody else is in these
                yield from self._mistakes(picture, frame)

    def _backdrop(self) -> np.ndarray:
        picture = self.backdrops[int(self.rng.integers(len(self.backdrops)))]
        side = int(min(picture.shape[:2]) * self.rng.uniform(0.2, 1))
        y, x = (int(self.rng.integers(0, size - side + 1)) for size in picture.shape[:2])
        return np.ascontiguousarray(picture[y : y + side, x : x + side])

    def _part(self, picture: np.ndarray, frame: np.ndarray) -> np.ndarray:
        """A window on a part of the face, or beside it."""
        rng = self.rng
        scale = np.exp(rng.uniform(np.log(0.2), np.log(0.6)))
        shift = rng.normal(size=2) * [0.5, 0.6] + [0, 0.4]
        if rng.random() < 0.3:  # as large as a face, but on shoulder, hair or wall
            scale = np.exp(rng.normal(0, 0.4))
            turn = rng.uniform(0, 2 * np.pi)
            shift = np.array([np.cos(turn), np.sin(turn)]) * rng.uniform(1.1, 2.2) + [0, 0.42]
        moved = np.column_stack([frame[:, :2] * scale, frame @ [*shift, 1]])
        return take(picture, moved, SPEC)

    def _tilted(self, picture: np.ndarray, frame: np.ndarray) -> np.ndarray:
        """The face itself, lying or upside down: found through the frame's rotation only."""
        turn = self.rng.uniform(1.4, 2 * np.pi - 1.4)
        c, s = np.cos(turn), np.sin(turn)
        moved = np.column_stack([frame[:, :2] @ [[c, -s], [s, c]], frame @ [*FACE_CENTRE, 1]])
        return take(picture, moved, SPEC)

    def _mistakes(self, picture: np.ndarray, frame: np.ndarray | None) -> Iterator[np.ndarray]:
        """What the detector takes for a face and is none, and where the mesh net goes from it."""
        guesses = self._guesses(picture)
        if frame is not None:
            middle, unit = frame @ [*FACE_CENTRE, 1], np.linalg.norm(frame[:, 0])
            guesses = [g for g in guesses if _is_elsewhere(g, middle, unit)]
        for guess in guesses[:4]:
            for _ in range(3):
                crop = take(picture, window(guess, np.array(SPEC.centre), SPEC), SPEC)
                yield photograph(crop, self.rng)
                points = self.mesh(crop[None])[0][0]
                placed = place(points, window(guess, np.array(SPEC.centre), SPEC))
                guess = frames_of(placed[None, :, :2], self.faces.mean[:, :2])[0]
                if not 4 < np.linalg.norm(guess[:, 0]) < 2 * max(picture.shape):
                    break

    def _guesses(self, picture: np.ndarray) -> list[np.ndarray]:
        side = int(self.rng.choice(SIDES))
        scale = max(picture.shape[:2]) / side
        h, w = (max(32, round(size / scale / 32) * 32) for size in picture.shape[:2])
        small = cv2.resize(picture, (w, h), interpolation=cv2.INTER_AREA)
        return decode(self.detector(small[None])[0][0], scale, DOUBTFUL)


def _is_elsewhere(guess: np.ndarray, middle: np.ndarray, unit: float) -> bool:
    """Not the face that is known to be there."""
    apart = np.linalg.norm(guess @ [*FACE_CENTRE, 1] - middle) / unit
    ratio = np.linalg.norm(guess[:, 0]) / unit
    return bool(apart > 0.9 or (apart > 0.35 and ratio < 0.6) or ratio < 0.4)


@torch.no_grad()
def features(net: PointNet, crops: np.ndarray) -> Tensor:
    """(N, 96, 96, 3) uint8 -> (N, F), what the score is told from."""
    x = normalise(torch.from_numpy(crops)).to(memory_format=torch.channels_last)
    for stage in net.stages:
        x = stage(x)
    return x.flatten(1)


def gather(faces: Faces, mesh: PointNet, nets: list[Net], count: int, seed: int) -> list[Tensor]:
    """count crops of faces and as many of none -> their features, two (count, F)."""
    cropper = Cropper(faces, SPEC, seed)
    without = NoFaces(faces, *nets, seed).stream()
    found: list[list[Tensor]] = [[], []]
    for _ in range(-(-count // BATCH)):
        batch = cropper.batch(BATCH)
        found[0].append(features(mesh, batch.rgb8[batch.labels[:, 0] == 1]))
        found[1].append(features(mesh, np.stack([next(without) for _ in range(BATCH)])))
    return [torch.cat(parts) for parts in found]


def report(name: str, score: nn.Linear, sets: list[Tensor]) -> None:
    with torch.no_grad():
        face, none = (score(part)[:, 0].sigmoid() for part in sets)
    print(f"{name}: faces missed {100 * (face < 0.5).float().mean():.2f} %, "
          f"others taken for one {100 * (none > 0.5).float().mean():.2f} %")  # fmt: skip


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--data", type=Path, default=Path("runs/faces.npz"))
    parser.add_argument("--checkpoints", type=Path, default=Path("runs"))
    parser.add_argument("--weights", type=Path, default=Path("runs/weights"), help="as exported")
    parser.add_argument("--samples", type=float, default=3e4)
    options = parser.parse_args()
    torch.set_num_threads(1)
    cv2.setNumThreads(1)
    torch.manual_seed(0)
    path = options.checkpoints / "mesh.pt"
    _, mesh = load(path)
    assert isinstance(mesh, PointNet)
    nets = [from_onnx(options.weights / f"{name}.onnx") for name in ("mesh", "detector")]
    held_out = gather(Faces(options.data, True), mesh, nets, 3000, seed=1)
    report("before", mesh.score, held_out)
    sets = gather(Faces(options.data, False), mesh, nets, int(options.samples), seed=0)
    score = mesh.score
    optimizer = torch.optim.AdamW(score.parameters(), lr=1e-3, weight_decay=0.05)
    steps = 6000
    for step in range(steps):
        optimizer.param_groups[0]["lr"] = 1e-3 * (1 - step / steps)
        loss = torch.zeros(())
        for part, wanted in zip(sets, (1.0, 0.0), strict=True):
            picked = part[torch.randint(len(part), (BATCH,))]
            logit = score(picked)[:, 0]
            loss = loss + nn.functional.binary_cross_entropy_with_logits(
                logit, torch.full_like(logit, wanted)
            )
        optimizer.zero_grad()
        loss.backward()
        score.weight.grad[1], score.bias.grad[1] = 0, 0  # the mouth's score stays
        optimizer.step()
    report("after", score, held_out)
    saved = torch.load(path, weights_only=True)
    for key in ("weight", "bias"):
        saved["average"][f"module.score.{key}"] = getattr(score, key).data
    torch.save(saved, path)


if __name__ == "__main__":
    main()
