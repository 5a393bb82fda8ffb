"""Packs the labelled faces into one file that training can map into memory.

    python -m makeup_video.training.faces.prepare --faces DIR --out runs/faces.npz

DIR holds portraits/, wild/, talking/, sharp/ and covered/, each with pictures and labels.npz
(docs/models.md describes them). Every face gets a pose: the similarity that lays the
mean face, whose outer eye corners are 1 apart, over the face. Training uses the face's
own coordinates, before the pose is applied, so every error is in IOD. The file calls the
poses `frames`.
"""

import argparse
from pathlib import Path

import cv2
import numpy as np
from makeup_video.pipeline.faces.topology import EYE_CORNERS
from makeup_video.training.faces.similarity_fit import fit_similarity
from makeup_video.training.faces.topology68 import mirror_permutation
from makeup_video.training.inputs import existing

FOLDERS = ("portraits", "wild", "talking", "sharp", "covered")
MAX_SPREAD = 2.0  # % of IOD by which the three labelling passes may disagree
VALIDATION_SHARE = 0.08  # of each source, the last pictures: neighbours stay together
DEPTH_CELLS, DEPTH_REACH = 33, 1.6  # depth grid over [-reach, reach] IOD


def read_folder(folder: Path) -> dict[str, np.ndarray]:
    labels = np.load(folder / "labels.npz")
    rgb8 = np.stack([cv2.imread(str(folder / name))[..., ::-1] for name in labels["name"]])
    points = labels["points"].astype(np.float32)  # (N, 478, 3)
    validation = np.zeros(len(points), bool)
    for source in np.unique(labels["source"]):
        index = np.flatnonzero(labels["source"] == source)
        validation[index[int(len(index) * (1 - VALIDATION_SHARE)) :]] = True
    good = labels["spread"] < MAX_SPREAD
    if folder.name == "covered":  # poor labels are typical of a covered mouth
        good = labels["spread"] < 4 * MAX_SPREAD
    columns = {"rgb8": rgb8, "points": points, "validation": validation, "source": labels["source"]}
    return {key: value[good] for key, value in columns.items()}


def poses_of(points: np.ndarray, mean: np.ndarray) -> np.ndarray:
    """Points (N, K, 2) -> poses (N, 2, 3) float32, which lay the mean face (K, 2) over them."""
    return fit_similarity(mean, points).astype(np.float32)


def to_own_coordinates(points: np.ndarray, poses: np.ndarray) -> np.ndarray:
    """Points (N, K, 3) in image px -> the face's own coordinates in IOD.

    z is scaled, too, and centred.
    """
    inverse = np.linalg.inv(poses[:, :, :2])
    xy = (points[..., :2] - poses[:, None, :, 2]) @ inverse.transpose(0, 2, 1)
    z = points[..., 2] / np.sqrt(np.linalg.det(poses[:, :, :2]))[:, None]
    return np.concatenate([xy, (z - z.mean(1, keepdims=True))[..., None]], 2)


def mean_face(points: np.ndarray) -> np.ndarray:
    """The Procrustes mean (478, 3): outer eye corners 1 apart, level, their midpoint at 0."""
    mean = points[0].copy()
    for _ in range(6):
        poses = poses_of(points[..., :2], mean[:, :2])
        mean = to_own_coordinates(points, poses).mean(0)
        left, right = mean[EYE_CORNERS[0], :2], mean[EYE_CORNERS[1], :2]
        across = right - left
        turn = np.array([[across[0], across[1]], [-across[1], across[0]]]) / (across @ across)
        mean[:, :2] = (mean[:, :2] - (left + right) / 2) @ turn.T
        mean[:, 2] /= np.linalg.norm(across)
    return mean


def depth_grids(face_points: np.ndarray) -> np.ndarray:
    """Points (N, 478, 3) in IOD -> depth (N, 33, 33), smoothly continued off the face."""
    size = DEPTH_CELLS
    cells = np.rint((face_points[..., :2] / DEPTH_REACH + 1) / 2 * (size - 1)).astype(int)
    cells = cells.clip(0, size - 1)
    grids = np.empty((len(face_points), size, size), np.float32)
    for grid, cell, z in zip(grids, cells, face_points[..., 2], strict=True):
        weight, total = np.zeros((2, size, size), np.float32)
        np.add.at(weight, (cell[:, 1], cell[:, 0]), 1)
        np.add.at(total, (cell[:, 1], cell[:, 0]), z)
        depth = np.full((size, size), np.float32(total.sum() / weight.sum()))
        for sigma in (8.0, 4.0, 2.0, 1.0):  # wide blurs fill the surroundings, narrow ones the face
            near = cv2.GaussianBlur(weight, (0, 0), sigma)
            here = cv2.GaussianBlur(total, (0, 0), sigma) / np.maximum(near, 1e-9)
            trust = np.clip(near * sigma**2 * 6, 0, 1)
            depth += trust * (here - depth)
        grid[:] = depth
    return grids


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--faces", type=existing, required=True)
    parser.add_argument("--out", type=Path, default=Path("runs/faces.npz"))
    options = parser.parse_args()

    folders = {name: read_folder(options.faces / name) for name in FOLDERS}
    points = np.concatenate([folders[name]["points"] for name in FOLDERS[:3]])
    mean = mean_face(points)
    mirror = mirror_permutation(mean)
    mean = (mean + mean[mirror] * [-1, 1, 1]) / 2
    packed: dict[str, np.ndarray] = {"mean": mean.astype(np.float32), "mirror": mirror}
    for name, columns in folders.items():
        poses = poses_of(columns["points"][..., :2], mean[:, :2])
        face_points = to_own_coordinates(columns["points"], poses)
        columns |= {"frames": poses, "face_points": face_points.astype(np.float32)}
        columns["depth"] = depth_grids(face_points)
        packed |= {f"{name}_{key}": value for key, value in columns.items()}
        print(name, len(face_points), "faces,", int(columns["validation"].sum()), "held out")
    options.out.parent.mkdir(parents=True, exist_ok=True)
    np.savez(options.out, **packed)


if __name__ == "__main__":
    main()
