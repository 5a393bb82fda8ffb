"""Evaluates lip masks on mouths outlined by hand, of held-out faces that no net trained on.

    python -m makeup_video.training.faces.evaluate_lip_mask \\
        --weights runs/lips.pt --masks runs/lipmasks.npz

Offsets of borders are in % of IOD, positive where too much is painted. If a mouth was outlined
twice, the first outline counts.
"""

import argparse
from collections.abc import Callable
from pathlib import Path

import cv2
import numpy as np
import torch
from makeup_video.training.faces.crops import MASK_SPAN, SPECS, CropSpec
from makeup_video.training.faces.evaluate import iou_of
from makeup_video.training.faces.export import from_checkpoint
from makeup_video.training.faces.infer import from_onnx, take
from makeup_video.training.faces.lip_evidence import MASK_SPEC
from makeup_video.training.faces.lip_outlines import Mouth, mouth_to_px, read_mouths
from makeup_video.training.inputs import existing, made_by

SIZE_WH = 500, 360  # px of the compared pictures
UNIT = SIZE_WH[0] / MASK_SPAN  # px per IOD
SMALLEST = 40  # px: a smaller opening does not count
BORDERS = ("outer upper", "outer lower", "inner upper", "inner lower", "corners")
TRIALS = 4  # crops of each mouth for a net, misplaced as by a tracker

# Index of a mouth -> the painted px, one (360, 500) bool for each trial
Painter = Callable[[int], list[np.ndarray]]


def overlap(painted: np.ndarray, mouth: Mouth) -> tuple[float, float]:
    """IoU with the lips, and the painted share of the interior (nan for a closed mouth)."""
    lips, interior = mouth.lips > 0.5, mouth.interior > 0.5
    share = painted[interior].mean() if interior.sum() > SMALLEST else np.nan
    return iou_of(painted, lips), share


def edges(mask: np.ndarray) -> np.ndarray:
    """(2, W): the first and the last row that is set in each column; nan where none is."""
    found = np.stack([mask.argmax(0), len(mask) - 1 - mask[::-1].argmax(0)]).astype(float)
    return np.where(mask.any(0), found, np.nan)


def offsets(painted: np.ndarray, mouth: Mouth) -> np.ndarray:
    """(5,) offsets of BORDERS, % of IOD; nan where an offset cannot be measured."""
    interior = mouth.interior > 0.5
    if not painted.any():
        return np.full(5, np.nan)
    human, ours = edges((mouth.lips > 0.5) | interior), edges(painted)
    columns, painted_columns = (np.flatnonzero(~np.isnan(rows[0])) for rows in (human, ours))
    inner = columns[len(columns) // 8 : -len(columns) // 8]  # away from the corners
    outer = (ours - human)[:, inner] * [[-1], [1]]
    corners = (columns[0] - painted_columns[0] + painted_columns[-1] - columns[-1]) / 2
    gap = np.full((2, 1), np.nan)
    if interior.sum() > SMALLEST:  # how far paint reaches in from above, and from below
        border = edges(interior)
        middle, y = np.nan_to_num(border.mean(0)).astype(int), np.arange(len(painted))[:, None]
        above = np.where(painted & (y < middle), y, -9999).max(0)
        below = np.where(painted & (y > middle), y, 9999).min(0)
        reached = np.stack([above + 1 - border[0], border[1] + 1 - below])
        gap = np.where(np.abs(reached) < 0.1 * UNIT, reached, np.nan)[:, inner]
    mean = [np.nanmedian(side) if np.isfinite(side).any() else np.nan for side in (*outer, *gap)]
    return 100 / UNIT * np.array([*mean, corners])


def magnify(values: np.ndarray, placed: np.ndarray, spec: CropSpec) -> np.ndarray:
    """The values of a crop, resampled to the (360, 500) grid.

    placed: (2, 3), IOD of the crop -> IOD of the grid.
    """
    size = np.array(values.shape[::-1])
    linear = placed[:, :2] * (spec.span / size[0] * UNIT)
    offset = placed[:, 2] * UNIT + (np.array(SIZE_WH) - 1) / 2 - linear @ ((size - 1) / 2)
    return cv2.warpAffine(values, np.column_stack([linear, offset]), SIZE_WH,
                          flags=cv2.INTER_CUBIC, borderValue=-20)  # fmt: skip


def from_masks(path: Path, mouths: list[Mouth]) -> Painter:
    """A painter from the masks that lip_masks.py made of the same faces."""
    masks = np.load(path)
    of = {name: masks[f"{name}_masks"] for name in {mouth.folder for mouth in mouths}}

    def paint(at: int) -> list[np.ndarray]:
        mask = of[mouths[at].folder][mouths[at].index].astype(np.float32)
        lips = np.minimum(mask[..., 0], 255 - mask[..., 1])
        return [magnify(lips, np.eye(2, 3), MASK_SPEC) > 127]

    return paint


def from_net(path: Path, data: Path, mouths: list[Mouth]) -> Painter:
    """A painter from a checkpoint or an exported net."""
    run = (from_onnx if path.suffix == ".onnx" else from_checkpoint)(path)
    rng, packed, spec = np.random.default_rng(3), np.load(data), SPECS["lips"]
    columns = {(name, key): packed[f"{name}_{key}"] for name in {m.folder for m in mouths}
               for key in ("rgb8", "points", "frames")}  # fmt: skip
    crops, places = [], []
    for mouth in mouths:
        rgb8, points, pose = (
            columns[mouth.folder, key][mouth.index] for key in ("rgb8", "points", "frames")
        )
        for _ in range(TRIALS):
            turn, scale, *shift = rng.normal(size=4) * [0.06, 0.06, 0.035, 0.035]
            c, s = np.cos(turn) * np.exp(scale), np.sin(turn) * np.exp(scale)
            places.append(np.array([[c, -s, shift[0]], [s, c, shift[1]]]))
            placed = np.vstack([places[-1], [0, 0, 1]])
            crops.append(take(rgb8, mouth_to_px(points, pose) @ placed, spec))
    logits = np.concatenate([run(part)[-1] for part in np.array_split(np.stack(crops), 8)])

    def paint(at: int) -> list[np.ndarray]:
        trials = range(at * TRIALS, (at + 1) * TRIALS)
        return [magnify(logits[i], places[i], spec) > 0 for i in trials]

    return paint


def report(name: str, paint: Painter, mouths: list[Mouth]) -> None:
    scores = np.array([np.mean([overlap(p, m) for p in paint(i)], 0) for i, m in enumerate(mouths)])
    off = np.array([np.mean([offsets(p, m) for p in paint(i)], 0) for i, m in enumerate(mouths)])
    folders, opened = np.array([m.folder for m in mouths]), ~np.isnan(scores[:, 1])
    groups = {"all": folders != "", **{f: folders == f for f in np.unique(folders)},
              "open": opened, "closed": ~opened}  # fmt: skip
    print(f"{name}\n{'':12}  n    IoU  interior " + " ".join(f"{b:>11}" for b in BORDERS))
    for label, chosen in groups.items():
        iou, inside = (mean_of(values) for values in scores[chosen].T)
        print(f"{label:12} {chosen.sum():2}  {iou:.3f}  {100 * inside:6.1f} % "
              + " ".join(f"{mean_of(values):11.2f}" for values in off[chosen].T))  # fmt: skip


def mean_of(values: np.ndarray) -> float:
    """The mean of all values but nan."""
    known = values[~np.isnan(values)]
    return float(known.mean()) if len(known) else np.nan


def held_out(mouths: list[Mouth], data: Path) -> list[Mouth]:
    """The mouths of faces that no net trained on, each once."""
    with np.load(data) as packed:
        of = {name: packed[f"{name}_validation"] for name in {mouth.folder for mouth in mouths}}
    first = {(mouth.folder, mouth.index): mouth for mouth in reversed(mouths)}
    return [mouth for (folder, index), mouth in first.items() if of[folder][index]]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--weights", type=existing, nargs="*", default=[])
    parser.add_argument("--masks", type=existing, nargs="*", default=[])
    parser.add_argument("--data", type=made_by("faces.prepare"), default="runs/faces.npz")
    options = parser.parse_args()
    torch.set_num_threads(1)
    mouths = held_out(read_mouths(SIZE_WH, MASK_SPAN), options.data)
    for path in options.masks:
        report(str(path), from_masks(path, mouths), mouths)
    for path in options.weights:
        report(str(path), from_net(path, options.data, mouths), mouths)


if __name__ == "__main__":
    main()
