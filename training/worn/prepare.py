"""Packs labelled faces, and bare ones that wear drawn looks, for the net that tells what is worn.

    python -m makeup_video.training.worn.prepare --faces DIR --sets portraits wild \
        --shades DIR --out runs/worn.npz

DIR has a folder for each set, with pictures and worn.csv: name, the labels of LABELS (0 bare, 1 do
not know, 2 clear) and flags. A look is painted only on faces where all labels are 0, so that
nothing else is worn.
"""

import argparse
import csv
from collections.abc import Iterator
from pathlib import Path

import cv2
import numpy as np
from makeup_video.pipeline.faces.face import Face
from makeup_video.pipeline.faces.find import find_faces
from makeup_video.pipeline.look.ciede2000 import ciede2000, lab_of
from makeup_video.pipeline.look.finishes import FINISHES, product
from makeup_video.pipeline.look.kinds import KINDS
from makeup_video.pipeline.look.kinds.kind import Kind
from makeup_video.pipeline.look.look import Layer, Look
from makeup_video.pipeline.look.params import rgb_of_hex
from makeup_video.pipeline.render.apply_look import apply_look
from makeup_video.training.worn.crops import PLACES, worn_input
from makeup_video.training.worn.scores import UNKNOWN

# The columns of worn.csv, and the kind of makeup that each is about.
LABELS = {"lips": "lipstick", "shadow": "eyeshadow", "liner": "eyeliner", "blush": "blush"}
UNUSABLE = set("xys")  # flags: unusable, grey, sunglasses
# Median CIEDE2000 by which paint must change the part of the input that shows it: below the first
# it counts as nothing, from the second on as clear.
UNSEEN, CLEAR = 1.5, 4.0
_SEEN_IN = {"lips": "lips", "shadow": "eyes", "liner": "eyes", "blush": "face"}
_LEAST_DIFFERENT = 1.0  # CIEDE2000: pixels that changed by less are not painted


def rows(folder: Path) -> Iterator[tuple[Path, list[int]]]:
    """Pictures of a set with their labels, UNKNOWN for 1; unusable ones are left out.

    Without worn.csv all are bare.
    """
    if not (folder / "worn.csv").exists():
        yield from ((path, [0] * len(LABELS)) for path in sorted(folder.glob("*.jpg")))
        return
    with (folder / "worn.csv").open(newline="") as table:
        for row in csv.DictReader(table):
            if set(row["flags"]) & UNUSABLE:
                continue
            labels = [{"0": 0, "2": 1}.get(row[name].strip(), UNKNOWN) for name in LABELS]
            if (
                "h" in row["flags"]
            ):  # something is in front: what is not seen is not known to be bare
                labels = [UNKNOWN if label == 0 else label for label in labels]
            yield folder / row["name"], labels


def draw_look(rng: np.random.Generator, shades: dict[str, list[str]]) -> Look:
    """A look of some kinds, in colours of shops or in any colours."""
    layers: list[Layer] = []
    for kind in (KINDS[name] for name in LABELS.values()):
        if rng.random() < 0.45:
            count = int(rng.integers(1, kind.most + 1))
            layers += [_draw_layer(kind, rng, shades.get(kind.part, [])) for _ in range(count)]
    return Look(layers)


def _draw_layer(kind: Kind, rng: np.random.Generator, shades: list[str]) -> Layer:
    if shades and rng.random() < 0.75:
        rgb = rgb_of_hex(shades[rng.integers(len(shades))]) or kind.first_rgb
    elif kind.part == "liner" and rng.random() < 0.8:
        rgb = tuple(rng.integers(8, 50, 3).tolist())
    elif kind.part == "blush":
        spread = rng.normal(0, 25, 3)
        rgb = tuple(np.clip(np.array(kind.first_rgb) + spread, 0, 255).tolist())
    else:
        rgb = tuple(rng.integers(0, 256, 3).tolist())
    names = list(FINISHES)
    worn = product(rgb, names[rng.integers(len(names))], kind.part)
    shape = {}
    for dial in kind.dials:
        if dial.choices:
            shape[dial.name] = dial.choices[rng.integers(len(dial.choices))]
        elif not dial.is_colour and rng.random() < 0.5 and not kind.slots:
            shape[dial.name] = float(rng.uniform(dial.low, dial.high))
    return Layer(kind.name, worn, shape, float(rng.uniform(0.25, 1)))


def painted(rgb8: np.ndarray, face: Face, look: Look) -> tuple[np.ndarray, list[int]]:
    """The input with a look on, and its labels: what hardly shows is unknown, or bare."""
    bare = worn_input(rgb8, face)
    labels = []
    for label, name in LABELS.items():
        alone = Look(look.of(name))
        labels.append(0 if alone.is_bare else _seen(bare, rgb8, face, alone, _SEEN_IN[label]))
    return worn_input(apply_look(rgb8, look, [face]), face), labels


def _seen(bare: np.ndarray, rgb8: np.ndarray, face: Face, look: Look, part: str) -> int:
    """The label of a look of one kind: by how much it changes what it is painted on."""
    left, top, wide, high = PLACES[part]
    at = np.s_[top : top + high, left : left + wide]
    made_up = worn_input(apply_look(rgb8, look, [face]), face)
    off = ciede2000(lab_of(bare[at]), lab_of(made_up[at]))
    changed = off[off > _LEAST_DIFFERENT]
    if changed.size < 30:
        return 0 if changed.size == 0 else UNKNOWN
    median = float(np.median(changed))
    return 1 if median >= CLEAR else UNKNOWN if median >= UNSEEN else 0


def read_shades(folder: Path) -> dict[str, list[str]]:
    """Hex colours of products by part."""
    tables = {"lips": "lip_shades.csv", "eyes": "eyeshadow_shades.csv"}
    found = {}
    for part, name in tables.items():
        with (folder / name).open(newline="", encoding="utf-8") as table:
            found[part] = [row["hex"] for row in csv.DictReader(table)]
    return found


def pack(options: argparse.Namespace) -> None:
    rng, shades = np.random.default_rng(0), read_shades(options.shades)
    inputs, labels, sources, real = [], [], [], []
    for number, name in enumerate(options.sets):
        for count, (path, known) in enumerate(rows(options.faces / name)):
            bgr = cv2.imread(str(path))
            if bgr is None:
                continue
            rgb8 = np.ascontiguousarray(bgr[..., ::-1])
            faces = find_faces(rgb8)
            if not faces:
                continue
            made = [(worn_input(rgb8, faces[0]), known)]
            if not any(known):
                looks = [draw_look(rng, shades) for _ in range(options.looks)]
                made += [painted(rgb8, faces[0], look) for look in looks if not look.is_bare]
            for at, (seen, worn) in enumerate(made):
                inputs.append(seen)
                labels.append(worn)
                sources.append(number)
                real.append(at == 0)
            if count % 200 == 0:
                print(f"{name}: {count} pictures, {len(inputs)} inputs", flush=True)
    np.savez(
        options.out, inputs=np.stack(inputs), labels=np.array(labels, np.uint8),
        sources=np.array(sources, np.uint8), real=np.array(real),
    )  # fmt: skip


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--faces", type=Path, required=True)
    parser.add_argument("--sets", nargs="+", required=True)
    parser.add_argument("--shades", type=Path, required=True)
    parser.add_argument("--looks", type=int, default=2, help="painted on each bare face")
    parser.add_argument("--out", type=Path, required=True)
    pack(parser.parse_args())
