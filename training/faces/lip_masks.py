"""Makes lip masks for training: carries the outlines drawn by hand over to every face.

    python -m makeup_video.training.faces.lip_masks                        # for a first net
    python -m makeup_video.training.faces.lip_masks --net runs/lips.onnx   # for a better one

Neither the teacher's contours, nor the face's own colours, nor a net trained on such masks give the
vermilion border reliably. lip_evidence.py turns all three into features of every pixel, and a
labeller (lip_labeller.py), fitted to the mouths outlined by hand, sees them beside the picture.
Outlined mouths that are not held out keep their outlines as masks, and training draws them more
often. Those that are held out teach neither the labeller nor a net.
"""

import argparse
from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from functools import cache
from itertools import chain
from multiprocessing import get_context
from pathlib import Path

import cv2
import numpy as np
import torch
from makeup_video.training.faces.crops import MASK_FOLDERS, SPECS, CropSpec
from makeup_video.training.faces.infer import from_onnx, take
from makeup_video.training.faces.lip_evidence import MASK_SPEC, average_of, features, to_mask_px
from makeup_video.training.faces.lip_labeller import (
    Labeller,
    Labels,
    fit,
    label,
    to_input,
    to_labels,
)
from makeup_video.training.faces.lip_outlines import Mouth, mouth_to_px, read_mouths
from makeup_video.training.inputs import existing, made_by

# A face: picture, points (478, 3) px, pose (2, 3)
Face = tuple[np.ndarray, np.ndarray, np.ndarray]
Place = tuple[str, int]  # of a face: its folder, and its index there


_loaded = cache(from_onnx)


def evidence(
    net: Path | None, spec: CropSpec, face: Face, seed: int
) -> tuple[np.ndarray, np.ndarray]:
    """Features (144, 192, F) of a face, and the mask crop (144, 192, 3). spec: the net's crop."""
    rgb8, points, pose = face
    to_image = mouth_to_px(points, pose)
    average = np.zeros(MASK_SPEC.size_wh[::-1], np.float32)
    if net is not None:
        average = average_of(_loaded(net), rgb8, to_image, spec, seed)
    crop = take(rgb8, to_image, MASK_SPEC)
    return features(crop, to_mask_px(points, to_image), average), crop


def read_faces(data: Path, name: str) -> list[Face]:
    packed = np.load(data)
    columns = (packed[f"{name}_{key}"] for key in ("rgb8", "points", "frames"))
    return list(zip(*columns, strict=True))


def outlined(mouths: list[Mouth]) -> dict[Place, tuple[np.ndarray, np.ndarray]]:
    """The shares (144, 192, 3) and the covered share (144, 192) of each mouth: means of passes."""
    drawn: dict[Place, list[Mouth]] = {}
    for mouth in mouths:
        drawn.setdefault((mouth.folder, mouth.index), []).append(mouth)
    return {
        face: (np.mean([m.shares for m in passes], 0), np.mean([m.covered for m in passes], 0))
        for face, passes in drawn.items()
    }


def label_part(job: tuple[Labeller, Path | None, CropSpec, list[Face], int]) -> tuple[list, ...]:
    labeller, net, spec, faces, seed = job
    cv2.setNumThreads(1)
    torch.set_num_threads(1)
    found = [label(labeller, *evidence(net, spec, face, seed + i)) for i, face in enumerate(faces)]
    return tuple(zip(*found, strict=True))


def fitted(
    seen: dict[Place, tuple[np.ndarray, np.ndarray]],
    drawn: dict[Place, tuple[np.ndarray, np.ndarray]],
) -> Labeller:
    """A labeller fitted to outlined faces.  seen: from `evidence`.  drawn: from `outlined`."""
    inputs = np.stack([to_input(*seen[face]) for face in drawn])
    shares, known = (
        torch.from_numpy(np.stack(part))
        for part in zip(*[to_labels(*each) for each in drawn.values()], strict=True)
    )
    return fit(inputs, Labels(shares, known))


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--data", type=made_by("faces.prepare"), default="runs/faces.npz")
    parser.add_argument("--net", type=existing)
    parser.add_argument("--net-span", type=float, default=SPECS["lips"].span,
                        help="width of that net's crops in IOD, if not today's")  # fmt: skip
    parser.add_argument("--out", type=Path, default=Path("runs/lipmasks.npz"))
    parser.add_argument("--processes", type=int, default=2)
    options = parser.parse_args()
    spec = replace(SPECS["lips"], span=options.net_span)
    packed = np.load(options.data)
    held_out = {name: packed[f"{name}_validation"] for name in MASK_FOLDERS}
    faces = {name: read_faces(options.data, name) for name in MASK_FOLDERS}
    every = outlined(read_mouths(MASK_SPEC.size_wh, MASK_SPEC.span))
    drawn = {face: part for face, part in every.items() if not held_out[face[0]][face[1]]}
    seen = {(name, index): evidence(options.net, spec, faces[name][index], i)
            for i, (name, index) in enumerate(drawn)}  # fmt: skip
    labeller, out = fitted(seen, drawn), {}
    with ProcessPoolExecutor(options.processes, get_context("spawn")) as pool:
        for name in MASK_FOLDERS:
            jobs = [(labeller, options.net, spec, faces[name][i : i + 50], i)
                    for i in range(0, len(faces[name]), 50)]  # fmt: skip
            parts = zip(*pool.map(label_part, jobs), strict=True)
            masks, sure = (list(chain.from_iterable(part)) for part in parts)
            windows = [mouth_to_px(points, pose) for _, points, pose in faces[name]]
            out |= {f"{name}_masks": np.stack(masks), f"{name}_windows": np.stack(windows),
                    f"{name}_sure": np.array(sure),
                    f"{name}_outlined": np.zeros(len(faces[name]), bool)}  # fmt: skip
            print(name, len(masks), "masks, mean certainty", np.mean(sure), flush=True)
    for (name, index), (shares, _) in drawn.items():
        out[f"{name}_masks"][index] = np.rint(shares * 255)
        out[f"{name}_sure"][index], out[f"{name}_outlined"][index] = 1, True
    np.savez(options.out, **out)


if __name__ == "__main__":
    main()
