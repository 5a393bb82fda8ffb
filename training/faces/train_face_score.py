"""Trains the face score of the mesh net on what only looks like a face.

    python -m makeup_video.training.faces.train_face_score --checkpoints runs --weights runs/weights

The training of the points shows the net few crops without a face, and only easy ones. In use the
net meets the detector's mistakes: shoes, patterns, a chin taken for a small face. So this training
gathers such false detections, the crops to which the mesh net moves on from them, parts of faces,
and faces that lie on their side or are upside down. Only the layer of the score learns; the points
do not change.
"""

import argparse
from collections.abc import Iterator

import cv2
import numpy as np
import torch
from makeup_video.pipeline.faces.nets import FaceNets
from makeup_video.pipeline.frames.views import RgbPicture
from makeup_video.training.faces.augment import photograph
from makeup_video.training.faces.checkpoint import saved_in
from makeup_video.training.faces.crops import SPECS, Cropper, Faces
from makeup_video.training.faces.detector_pictures import FACE_CENTRE, backdrops
from makeup_video.training.faces.export import load
from makeup_video.training.faces.infer import crop_to_px, place, take
from makeup_video.training.faces.model import PointNet, normalise
from makeup_video.training.faces.prepare import poses_of
from makeup_video.training.inputs import existing, made_by
from torch import Tensor, nn

SPEC = SPECS["mesh"]
SIDES = (256, 512)  # px: longer sides of the detector's input in the product
DOUBTFUL = 0.05  # least probability of a detection that is worth learning from
BATCH = 256


class NoFaces:
    """Draws crops (96, 96, 3) without a face, with a tilted face or with a part of a face."""

    def __init__(self, faces: Faces, nets: FaceNets, seed: int) -> None:
        self.faces, self.nets = faces, nets
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
            picture, pose = self.faces.pictures[face][0], self.faces.poses[face]
            yield photograph(self._part(picture, pose), self.rng)
            yield photograph(self._tilted(picture, pose), self.rng)
            # nobody else is in these pictures
            if self.faces.folder[face] in ("portraits", "talking"):
                yield from self._mistakes(picture, pose)

    def _backdrop(self) -> np.ndarray:
        picture = self.backdrops[int(self.rng.integers(len(self.backdrops)))]
        side = int(min(picture.shape[:2]) * self.rng.uniform(0.2, 1))
        y, x = (int(self.rng.integers(0, size - side + 1)) for size in picture.shape[:2])
        return np.ascontiguousarray(picture[y : y + side, x : x + side])

    def _part(self, picture: np.ndarray, pose: np.ndarray) -> np.ndarray:
        """A crop of a part of the face, or of a place beside the face."""
        rng = self.rng
        scale = np.exp(rng.uniform(np.log(0.2), np.log(0.6)))
        shift = rng.normal(size=2) * [0.5, 0.6] + [0, 0.4]
        if rng.random() < 0.3:  # as large as a face, but of shoulder, hair or wall
            scale = np.exp(rng.normal(0, 0.4))
            turn = rng.uniform(0, 2 * np.pi)
            shift = np.array([np.cos(turn), np.sin(turn)]) * rng.uniform(1.1, 2.2) + [0, 0.42]
        moved = np.column_stack([pose[:, :2] * scale, pose @ [*shift, 1]])
        return take(picture, moved, SPEC)

    def _tilted(self, picture: np.ndarray, pose: np.ndarray) -> np.ndarray:
        """A crop of the face on its side or upside down, which counts as no face: the product
        finds such a face only by turning the picture."""
        turn = self.rng.uniform(1.4, 2 * np.pi - 1.4)
        c, s = np.cos(turn), np.sin(turn)
        moved = np.column_stack([pose[:, :2] @ [[c, -s], [s, c]], pose @ [*FACE_CENTRE, 1]])
        return take(picture, moved, SPEC)

    def _mistakes(self, picture: np.ndarray, pose: np.ndarray | None) -> Iterator[np.ndarray]:
        """Crops of false detections, and the crops to which the mesh net moves on from them."""
        detections = _detections(self.nets, picture, int(self.rng.choice(SIDES)))
        if pose is not None:
            middle, unit = pose @ [*FACE_CENTRE, 1], np.linalg.norm(pose[:, 0])
            detections = [g for g in detections if _is_elsewhere(g, middle, unit)]
        for detection in detections[:4]:
            for _ in range(3):
                crop = take(picture, crop_to_px(detection, np.array(SPEC.centre)), SPEC)
                yield photograph(crop, self.rng)
                points = self.nets.mesh(crop[None])["points"][0]
                placed = place(points, crop_to_px(detection, np.array(SPEC.centre)))
                detection = poses_of(placed[None, :, :2], self.faces.mean[:, :2])[0]
                if not 4 < np.linalg.norm(detection[:, 0]) < 2 * max(picture.shape):
                    break


def _detections(nets: FaceNets, picture: np.ndarray, side_px: int) -> list[np.ndarray]:
    """Poses (2, 3) in px of the picture, surest first.  side_px: as in FaceNets.detect."""
    found = nets.detect(RgbPicture(picture), side_px, DOUBTFUL)
    return [pose.array() for _, pose in found]


def _is_elsewhere(detection: np.ndarray, middle: np.ndarray, unit: float) -> bool:
    """True for a pose that is not of the labelled face."""
    apart = np.linalg.norm(detection @ [*FACE_CENTRE, 1] - middle) / unit
    ratio = np.linalg.norm(detection[:, 0]) / unit
    return bool(apart > 0.9 or (apart > 0.35 and ratio < 0.6) or ratio < 0.4)


@torch.no_grad()
def features(net: PointNet, crops: np.ndarray) -> Tensor:
    """Crops (N, 96, 96, 3) uint8 -> features (N, F) that the score is computed from."""
    x = normalise(torch.from_numpy(crops)).to(memory_format=torch.channels_last)
    for stage in net.stages:
        x = stage(x)
    return x.flatten(1)


def gather(faces: Faces, mesh: PointNet, nets: FaceNets, count: int, seed: int) -> list[Tensor]:
    """Features of `count` crops of faces and of as many without: two (count, F)."""
    cropper = Cropper(faces, SPEC, seed)
    without = NoFaces(faces, nets, seed).stream()
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
    parser.add_argument("--data", type=made_by("faces.prepare"), default="runs/faces.npz")
    parser.add_argument("--checkpoints", type=existing, default="runs")
    parser.add_argument(
        "--weights", type=existing, default="runs/weights", help="folder of all exported nets"
    )
    parser.add_argument("--samples", type=float, default=3e4)
    options = parser.parse_args()
    torch.set_num_threads(1)
    cv2.setNumThreads(1)
    torch.manual_seed(0)
    path = options.checkpoints / "mesh.pt"
    _, mesh = load(path)
    assert isinstance(mesh, PointNet)
    nets = FaceNets(options.weights)
    held_out = gather(Faces(options.data, True), mesh, nets, 3000, seed=1)
    report("before", mesh.score, held_out)
    sets = gather(Faces(options.data, False), mesh, nets, int(options.samples), seed=0)
    score = mesh.score
    optimizer = torch.optim.AdamW(score.parameters(), lr=1e-3, weight_decay=0.05)
    mouth = {key: getattr(score, key).detach()[1].clone() for key in ("weight", "bias")}
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
        optimizer.step()
    with torch.no_grad():
        for key, row in mouth.items():
            getattr(score, key)[1] = row  # undoes what weight decay did to the mouth's score
    report("after", score, held_out)
    saved = saved_in(path)
    for key in ("weight", "bias"):
        saved["average"][f"module.score.{key}"] = getattr(score, key).data
    torch.save(saved, path)


if __name__ == "__main__":
    main()
