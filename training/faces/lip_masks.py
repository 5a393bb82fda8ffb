"""Makes lip masks for training: carries the outlines drawn by hand over to every face.

    python -m makeup_video.training.faces.lip_masks                        # for a first net
    python -m makeup_video.training.faces.lip_masks --net runs/lips.onnx   # for a better one

Neither the teacher's contours, nor the face's own colours, nor a net trained on such masks give the
vermilion border reliably. lip_evidence.py turns all three into features of every pixel, and a small
labeller, fitted to the mouths outlined by hand, weighs the features. Outlined mouths that are not
held out keep their outlines as masks, and training draws them more often.
"""

import argparse
from concurrent.futures import ProcessPoolExecutor
from functools import cache
from itertools import chain
from multiprocessing import get_context
from pathlib import Path

import cv2
import numpy as np
import onnxruntime
import torch
from makeup_video.training.faces.infer import take
from makeup_video.training.faces.lip_evidence import MASK_SPEC, average_of, features, to_mask_px
from makeup_video.training.faces.lip_outlines import Mouth, mouth_to_px, read_mouths
from torch import Tensor, nn

FOLDERS = ("portraits", "talking", "wild", "sharp")
HIDDEN, STEPS, BATCH, RATE = 32, 300, 4096, 5e-3  # larger values change nothing
JITTER = 0.15  # noise on the features, in deviations: else so few mouths are memorised
BESIDE = -4.0  # of the first feature: further out there is no lip
# A face: picture, points (478, 3) px, pose (2, 3)
Face = tuple[np.ndarray, np.ndarray, np.ndarray]


@cache
def session(path: Path) -> onnxruntime.InferenceSession:
    options = onnxruntime.SessionOptions()
    options.intra_op_num_threads = 1
    return onnxruntime.InferenceSession(str(path), options, providers=["CPUExecutionProvider"])


def evidence(net: Path | None, face: Face, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Features (144, 192, F) of a face, and the mask crop (144, 192, 3)."""
    rgb8, points, pose = face
    to_image = mouth_to_px(points, pose)
    average = np.zeros(MASK_SPEC.size_wh[::-1], np.float32)
    if net is not None:
        run = session(net)
        average = average_of(lambda crops: run.run(None, {"rgb8": crops}), rgb8, to_image, seed)
    crop = take(rgb8, to_image, MASK_SPEC)
    return features(crop, to_mask_px(points, to_image), average), crop


class Labeller(nn.Module):
    """Features (..., F) -> log-odds (..., 2) of the whole mouth and of the opening."""

    def __init__(self, count: int) -> None:
        super().__init__()
        self.register_buffer("mean", torch.zeros(count))
        self.register_buffer("deviation", torch.ones(count))
        self.layers = nn.Sequential(
            nn.Linear(count, HIDDEN), nn.ReLU(), nn.Linear(HIDDEN, HIDDEN), nn.ReLU(),
            nn.Linear(HIDDEN, 2),
        )  # fmt: skip

    def forward(self, x: Tensor) -> Tensor:
        x = (x - self.mean) / self.deviation
        return self.layers(x + JITTER * torch.randn_like(x) if self.training else x)


def fit(seen: list[np.ndarray], mouths: list[Mouth]) -> Labeller:
    """Fit a labeller. seen: features (144, 192, F) of every mouth."""
    torch.manual_seed(0)
    wanted = [mouth.whole_and_opening for mouth in mouths]
    near = [(x[..., 0] > BESIDE) & (m.covered < 0.1) for x, m in zip(seen, mouths, strict=True)]
    x = torch.from_numpy(np.concatenate([a[b] for a, b in zip(seen, near, strict=True)]))
    target = torch.from_numpy(np.concatenate([a[b] for a, b in zip(wanted, near, strict=True)]))
    labeller = Labeller(x.shape[1])
    labeller.mean[:], labeller.deviation[:] = x.mean(0), x.std(0) + 1e-3
    optimizer = torch.optim.AdamW(labeller.parameters(), lr=RATE, weight_decay=0.02)
    for step in range(STEPS):
        for group in optimizer.param_groups:
            group["lr"] = RATE * (1 - step / STEPS) + 1e-5
        chosen = torch.randint(len(x), (BATCH,))
        loss = nn.functional.binary_cross_entropy_with_logits(labeller(x[chosen]), target[chosen])
        optimizer.zero_grad()
        loss.backward()
        optimizer.step()
    return labeller.eval()


@torch.no_grad()
def label(labeller: Labeller, seen: np.ndarray, crop: np.ndarray) -> tuple[np.ndarray, float]:
    """Whole mouth and opening (144, 192, 2) uint8, and the mean certainty, 0 to 1."""
    log_odds = labeller(torch.from_numpy(seen)).numpy()
    log_odds[..., 0][seen[..., 0] <= BESIDE] = -9
    guide = cv2.cvtColor(crop, cv2.COLOR_RGB2GRAY).astype(np.float32) / 255
    smooth = [cv2.ximgproc.guidedFilter(guide, np.ascontiguousarray(weight), 2, 1e-4)
              for weight in np.moveaxis(1 / (1 + np.exp(-log_odds)), -1, 0)]  # fmt: skip
    weight = np.dstack(smooth).clip(0, 1)
    lips = weight[..., 0] * (1 - weight[..., 1])
    sure = np.square(2 * lips - 1)[lips > 0.1].mean() if lips.max() > 0.5 else 0.0
    return np.rint(weight * 255).astype(np.uint8), float(sure)


def read_faces(data: Path, name: str) -> list[Face]:
    packed = np.load(data)
    columns = (packed[f"{name}_{key}"] for key in ("rgb8", "points", "frames"))
    return list(zip(*columns, strict=True))


def cross_validated(seen: list, mouths: list[Mouth], folds: int = 6) -> list[Labeller]:
    """A labeller for each mouth that was fitted to other mouths."""
    faces = sorted({(mouth.folder, mouth.index) for mouth in mouths})
    places = np.random.default_rng(0).permutation(len(faces)) % folds
    fold_of = dict(zip(faces, places, strict=True))
    fold = np.array([fold_of[mouth.folder, mouth.index] for mouth in mouths])
    fitted = []
    for index in range(folds):
        others = np.flatnonzero(fold != index)
        fitted.append(fit([seen[i] for i in others], [mouths[i] for i in others]))
    return [fitted[index] for index in fold]


def outlined_masks(mouths: list[Mouth]) -> dict[tuple[str, int], np.ndarray]:
    """(folder, index) -> whole mouth and opening (144, 192, 2) uint8, the mean of all passes."""
    drawn: dict[tuple[str, int], list[np.ndarray]] = {}
    for mouth in mouths:
        drawn.setdefault((mouth.folder, mouth.index), []).append(mouth.whole_and_opening)
    return {face: np.rint(np.mean(m, 0) * 255).astype(np.uint8) for face, m in drawn.items()}


def label_part(job: tuple[Labeller, Path | None, list[Face], int]) -> tuple[list, ...]:
    labeller, net, faces, seed = job
    cv2.setNumThreads(1)
    torch.set_num_threads(1)
    found = [label(labeller, *evidence(net, face, seed + i)) for i, face in enumerate(faces)]
    return tuple(zip(*found, strict=True))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--data", type=Path, default=Path("runs/faces.npz"))
    parser.add_argument("--net", type=Path)
    parser.add_argument("--out", type=Path, default=Path("runs/lipmasks.npz"))
    parser.add_argument("--processes", type=int, default=2)
    options = parser.parse_args()
    torch.set_num_threads(1)
    mouths = read_mouths(MASK_SPEC.size_wh, MASK_SPEC.span)
    faces = {name: read_faces(options.data, name) for name in FOLDERS}
    seen, crops = zip(*[evidence(options.net, faces[m.folder][m.index], i)
                        for i, m in enumerate(mouths)], strict=True)  # fmt: skip
    labeller, out = fit(seen, mouths), {}
    with ProcessPoolExecutor(options.processes, get_context("spawn")) as pool:
        for name in FOLDERS:
            jobs = [(labeller, options.net, faces[name][i : i + 50], i)
                    for i in range(0, len(faces[name]), 50)]  # fmt: skip
            parts = zip(*pool.map(label_part, jobs), strict=True)
            masks, sure = (list(chain.from_iterable(part)) for part in parts)
            windows = [mouth_to_px(points, pose) for _, points, pose in faces[name]]
            out |= {f"{name}_masks": np.stack(masks), f"{name}_windows": np.stack(windows),
                    f"{name}_sure": np.array(sure)}  # fmt: skip
            print(name, len(masks), "masks, mean certainty", np.mean(sure), flush=True)
    packed = np.load(options.data)
    held_out = {name: packed[f"{name}_validation"] for name in FOLDERS}
    # Held-out mouths get masks from labellers fitted to others, so that evaluate_lip_mask.py can
    # evaluate them.
    for i, (mouth, blind) in enumerate(zip(mouths, cross_validated(seen, mouths), strict=True)):
        if held_out[mouth.folder][mouth.index]:
            out[f"{mouth.folder}_masks"][mouth.index] = label(blind, seen[i], crops[i])[0]
    out |= {f"{name}_outlined": np.zeros(len(faces[name]), bool) for name in FOLDERS}
    for (name, index), mask in outlined_masks(mouths).items():
        if not held_out[name][index]:
            out[f"{name}_masks"][index] = mask
            out[f"{name}_sure"][index], out[f"{name}_outlined"][index] = 1, True
    np.savez(options.out, **out)


if __name__ == "__main__":
    main()
