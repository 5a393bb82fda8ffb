"""Packs crops of labelled faces and of painted ones, for the nets that read a form of makeup."""

import argparse
import itertools
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from makeup_video.pipeline.faces.face import Face
from makeup_video.pipeline.frames.affine import AffineArray, invert
from makeup_video.training.worn.prepare import named_faces, rows

Crop = Any  # a named tuple of arrays


def in_crop(points_px: np.ndarray, to_px: AffineArray) -> np.ndarray:
    """Points of a photo, (..., 2) px, in px of a crop, float32.

    to_px: the map from the crop to the photo.
    """
    to_crop = invert(to_px)
    return np.float32(points_px @ to_crop[:, :2].T + to_crop[:, 2])


def pack_sets(
    options: argparse.Namespace,
    real_of: Callable[[str, np.ndarray, Face], Iterable[Crop]],
    painted_of: Callable[[np.ndarray, Face, list[int]], Iterable[Crop]],
) -> None:
    """Pack the crops of all pictures of some sets; options: parsed by prepare.parser_of.

    real_of: the crops of a picture as it is, by its name; none if the picture has no labels of the
    form.  painted_of: the crops of a picture with makeup painted on, by its labels from
    prepare.rows; none if the face wears such makeup already.
    """
    painted: list[Crop] = []
    real: list[Crop] = []
    faces: list[int] = []  # the number of each painted crop's face
    number = itertools.count()
    for name in options.sets:
        pictures = dict(rows(options.faces / name))
        for path, rgb8, face in named_faces(pictures):
            real += real_of(path.name, rgb8, face)
            made = list(painted_of(rgb8, face, pictures[path]))
            painted += made
            faces += [next(number)] * len(made)
        print(f"{name}: {len(painted)} painted crops and {len(real)} real ones in all", flush=True)
    if not painted and not real:
        raise SystemExit(
            f"no crop is found in {', '.join(options.sets)} of {options.faces}: name other --sets"
        )
    save_crops(options.out, painted, real, faces)


def save_crops(
    path: Path, painted: Sequence[Crop], real: Sequence[Crop], faces: Sequence[int]
) -> None:
    """Write named tuples of one kind, an array for each field, and the arrays is_real and face.

    The painted crops come first.

    faces: the number of the face of each painted crop, rising; -1 is stored for real ones.
    """
    fields = (painted or real)[0]._fields
    packed = [np.stack(each) for each in zip(*painted, *real, strict=True)]
    is_real = np.arange(len(painted) + len(real)) >= len(painted)
    face = np.array([*faces, *[-1] * len(real)])
    path.parent.mkdir(parents=True, exist_ok=True)
    np.savez(path, **dict(zip(fields, packed, strict=True)), is_real=is_real, face=face)
