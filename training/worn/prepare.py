"""Packs labelled faces, and bare ones that wear drawn looks, for the net that reads what is worn.

    python -m makeup_video.training.worn.prepare --faces DIR --sets portraits wild \
        --shades DIR --out runs/worn.npz

DIR has a folder for each set, with pictures and worn.csv, whose columns are name, LABELS (0 bare,
1 not known, 2 clear) and flags. A look is painted only on faces whose labels are all 0, so that
these wear nothing else. With --unlabelled, the pictures that worn.csv does not name are packed.
Each input is packed with the log-odds from the real face's colours, so run fit_colours.py first.
"""

import argparse
from collections.abc import Iterable, Iterator
from pathlib import Path

import cv2
import numpy as np
from makeup_video.pipeline.faces.face import Face
from makeup_video.pipeline.faces.find import find_faces
from makeup_video.pipeline.look.ciede2000 import ciede2000, lab_of
from makeup_video.pipeline.look.look import Look
from makeup_video.pipeline.reference.colours import Colours
from makeup_video.pipeline.reference.makeup_input import PLACES, makeup_input
from makeup_video.pipeline.reference.makeup_numbers import LAYERS, WORN, to_vector
from makeup_video.pipeline.reference.neutral_face import neutral_face
from makeup_video.pipeline.reference.photo_light import photo_light
from makeup_video.pipeline.render.apply_look import PaintPictures
from makeup_video.training.inputs import existing
from makeup_video.training.worn.draw_looks import draw_look, read_shades
from makeup_video.training.worn.scores import UNKNOWN
from makeup_video.training.worn.table import has_table, labelled_rows

# The columns of worn.csv, and the kind of makeup that each is about.
LABELS = dict(zip(("lips", "shadow", "liner", "blush"), WORN, strict=True))
UNUSABLE = set("xys")  # flags: unusable, grey, sunglasses
# Median CIEDE2000 by which paint changes pixels of the input. Below UNSEEN a kind counts as bare,
# from CLEAR on as clear, in between as unknown.
UNSEEN, CLEAR = 1.5, 4.0
# The part of the input that shows the makeup of each label.
_SEEN_IN = {"lips": "lips", "shadow": "eyes", "liner": "eyes", "blush": "face"}
_LEAST_DIFFERENT = 1.0  # CIEDE2000; a pixel that changed by no more is not painted
_KEYS = ("inputs", "labels", "vectors", "weights", "sources", "real", "colours")
# Where the vector has the opacity of each layer, which comes before its colour and its dials.
_OPACITIES = np.cumsum([0] + [4 + len(dials) for *_, dials in LAYERS])[:-1]


def rows(folder: Path) -> Iterator[tuple[Path, list[int]]]:
    """The usable pictures of a set with their labels: 0 bare, 1 clear, or UNKNOWN.

    Without worn.csv all pictures count as bare.
    """
    if not has_table(folder):
        yield from ((path, [0] * len(LABELS)) for path in _pictures(folder))
        return
    for row in labelled_rows(folder):
        if set(row["flags"]) & UNUSABLE:
            continue
        labels = [{"0": 0, "2": 1}.get(row[name].strip(), UNKNOWN) for name in LABELS]
        # h: something is in front of the face, and may hide makeup on what looks bare
        if "h" in row["flags"]:
            labels = [UNKNOWN if label == 0 else label for label in labels]
        yield folder / row["name"], labels


def rows_without_labels(folder: Path) -> Iterator[tuple[Path, list[int]]]:
    """The pictures of a set that worn.csv does not name, with all labels UNKNOWN."""
    named = {row["name"] for row in labelled_rows(folder)} if has_table(folder) else set()
    for path in _pictures(folder):
        if path.name not in named:
            yield path, [UNKNOWN] * len(LABELS)


def _pictures(folder: Path) -> list[Path]:
    """The pictures of a set. Raises SystemExit for a set without a folder."""
    if not folder.is_dir():
        raise SystemExit(f"there is no folder {folder}: name the sets of --faces with --sets")
    return sorted(folder.glob("*.jpg"))


def labelled_faces(folder: Path) -> Iterator[tuple[np.ndarray, Face, list[int]]]:
    """Each picture of a set, (H, W, 3) uint8, its largest face, and its labels from `rows`."""
    return faces_of(rows(folder))


def faces_of(
    pictures: Iterable[tuple[Path, list[int]]],
) -> Iterator[tuple[np.ndarray, Face, list[int]]]:
    """Like labelled_faces, for the given pictures and labels."""
    known = dict(pictures)
    for path, rgb8, face in named_faces(known):
        yield rgb8, face, known[path]


def named_faces(paths: Iterable[Path]) -> Iterator[tuple[Path, np.ndarray, Face]]:
    """Each picture that shows a face: its path, its px (H, W, 3) uint8, and its largest face."""
    for path in paths:
        bgr = cv2.imread(str(path))
        rgb8 = None if bgr is None else np.ascontiguousarray(bgr[..., ::-1])
        faces = [] if rgb8 is None else find_faces(rgb8)
        if rgb8 is not None and faces:
            yield path, rgb8, faces[0]


def painted(
    rgb8: np.ndarray, face: Face, look: Look, paint: PaintPictures
) -> tuple[np.ndarray, list[int]]:
    """The input of a face with a look on, and its labels.

    A kind of makeup that hardly shows is labelled as unknown or bare.
    """
    light = photo_light(rgb8, face)
    bare = makeup_input(rgb8, face, light)
    made_up = paint(rgb8, look, [face])
    labels = []
    for label, name in LABELS.items():
        if not look.of(name):
            labels.append(0)
            continue
        alone = paint(rgb8, Look(look.of(name)), [face])
        labels.append(_seen(bare, makeup_input(alone, face, light), _SEEN_IN[label]))
    return makeup_input(made_up, face, photo_light(made_up, face)), labels


def _seen(bare: np.ndarray, made_up: np.ndarray, part: str) -> int:
    """The label of a kind of makeup, from how much the kind changes its part of the input."""
    left, top, wide, high = PLACES[part]
    at = np.s_[top : top + high, left : left + wide]
    off = ciede2000(lab_of(bare[at]), lab_of(made_up[at]))
    changed = off[off > _LEAST_DIFFERENT]
    if changed.size < 30:
        return 0 if changed.size == 0 else UNKNOWN
    median = float(np.median(changed))
    return 1 if median >= CLEAR else UNKNOWN if median >= UNSEEN else 0


def pack(options: argparse.Namespace) -> None:
    options.out.parent.mkdir(parents=True, exist_ok=True)
    rng, shades = np.random.default_rng(options.seed), read_shades(options.shades)
    paint = PaintPictures()
    packed: dict[str, list[np.ndarray]] = {key: [] for key in _KEYS}
    for number, name in enumerate(options.sets):
        pictures = (rows_without_labels if options.unlabelled else rows)(options.faces / name)
        for count, (rgb8, face, known) in enumerate(faces_of(pictures)):
            light = photo_light(rgb8, face)
            colours = Colours.of(neutral_face(rgb8, face, light)).log_odds()
            made = [(makeup_input(rgb8, face, light), known, None)]
            if not any(known):
                looks = [draw_look(rng, shades) for _ in range(options.looks)]
                made += [(*painted(rgb8, face, look, paint), look) for look in looks]
            for seen, worn, look in made:
                values = [*_example(seen, worn, look, number), colours]
                for key, value in zip(_KEYS, values, strict=True):
                    packed[key].append(value)
            if count % 200 == 0:
                print(f"{name}: {count} pictures, {len(packed['inputs'])} inputs", flush=True)
    np.savez(options.out, **{key: np.stack(values) for key, values in packed.items()})


def _example(seen: np.ndarray, worn: list[int], look: Look | None, source: int) -> list[np.ndarray]:
    """Input, labels, vector, weights of the vector, source, and whether the face is real."""
    vector, weights = to_vector(look or Look())
    if look is None:  # a real face: only the opacity of a kind that is not worn is known, 0
        weights = np.zeros_like(weights)
        weights[_OPACITIES] = [worn[WORN.index(kind)] == 0 for kind, *_ in LAYERS]
    labels = np.array(worn, np.uint8)
    return [seen, labels, vector, weights, np.uint8(source), np.bool_(look is None)]


def parser_of(description: str | None, *, looks: int) -> argparse.ArgumentParser:
    """A parser of the options: which faces are packed, and which looks are painted on them.

    looks: the default number of looks on each face.
    """
    parser = argparse.ArgumentParser(description=description)
    parser.add_argument("--faces", type=existing, required=True)
    parser.add_argument("--sets", nargs="+", required=True)
    parser.add_argument("--shades", type=existing, required=True)
    parser.add_argument("--looks", type=int, default=looks, help="painted on each bare face")
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--out", type=Path, required=True)
    return parser


if __name__ == "__main__":
    parser = parser_of(__doc__, looks=4)
    parser.add_argument("--unlabelled", action="store_true",
                        help="the pictures that worn.csv does not name")  # fmt: skip
    pack(parser.parse_args())
