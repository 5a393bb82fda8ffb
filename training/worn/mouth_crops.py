"""Packs mouths, for the net that reads how lipstick shines and fades.

    python -m makeup_video.training.worn.mouth_crops --faces DIR --sets portraits \
        --shades DIR --out runs/mouths.npz

DIR is as for prepare.py. Mouths without lipstick are painted. Their targets are the gloss and the
fade that a person saw on lips painted with such gloss and gradient. Mouths that lipsticks.csv names
are packed as they are, with the labels that we gave them by eye.
"""

import argparse
from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
from makeup_video.pipeline.faces.face import Face
from makeup_video.pipeline.look.finishes import product
from makeup_video.pipeline.look.look import Layer, Look
from makeup_video.pipeline.reference.read_lipstick import mouth_input
from makeup_video.pipeline.render.apply_look import PaintPictures
from makeup_video.training.worn.draw_looks import read_shades, rgb_from
from makeup_video.training.worn.mouth import Mouth, contours_of
from makeup_video.training.worn.packed import pack_sets
from makeup_video.training.worn.prepare import LABELS, parser_of
from makeup_video.training.worn.table import rows_of

_LABELS = Path(__file__).with_name("lipsticks.csv")
_FADES, _SHINES, _COVERS = 0.5, 0.7, 0.75  # how often a lipstick fades, shines and covers
_COVERING = 0.85  # least opacity of one that covers
# Gloss and gradient of 240 painted mouths, and the mean gloss and fade that a person saw there.
_GLOSS = (0.0, 0.1, 0.3, 0.5, 0.7, 0.9, 1.15, 1.4)
_GLOSS_SAID = (0.46, 0.8, 1.05, 1.3, 1.45, 1.66, 1.88, 2.1)
_GRADIENT = (0.0, 0.2, 0.3, 0.5, 0.7, 0.9, 1.0)
_FADE_SAID = (0.08, 0.08, 0.15, 0.5, 1.06, 1.68, 1.95)

Target = tuple[float, float]  # the NUMBERS of mouth.py


def labelled_lipsticks() -> dict[str, Target]:
    """The targets in lipsticks.csv, for each picture."""
    return {row["name"]: (float(row["gloss"]), float(row["fade"])) for row in rows_of(_LABELS)}


def draw_lipstick(rng: np.random.Generator, shades: Sequence[str]) -> Layer:
    """A lipstick with a random gloss and gradient; either is often 0."""
    gradient = float(rng.uniform(0.1, 1)) if rng.random() < _FADES else 0.0
    gloss = float(rng.uniform(0, 1.3)) if rng.random() < _SHINES else 0.0
    covers = (_COVERING, 1.0) if rng.random() < _COVERS else (0.35, _COVERING)
    worn = replace(
        product(rgb_from(rng, shades), "gloss" if gloss else "matte", "lips"),
        opacity=float(rng.uniform(*covers)),
        gloss=gloss,
        gloss_roughness=float(rng.uniform(0.15, 0.4)),
        reflection=float(rng.uniform(0, 0.05)),
    )
    return Layer("lipstick", worn, {"gradient": gradient})


def target_of(lipstick: Layer) -> Target:
    """The gloss and the fade that a person would see in a drawn lipstick."""
    gloss = float(np.interp(lipstick.product.gloss, _GLOSS, _GLOSS_SAID))
    return gloss, float(np.interp(lipstick.whole_shape["gradient"], _GRADIENT, _FADE_SAID))


def mouth_of(rgb8: np.ndarray, face: Face, target: Target) -> Mouth:
    return Mouth(mouth_input(rgb8, face), np.float32(target), contours_of(face))


def pack(options: argparse.Namespace) -> None:
    rng, shades = np.random.default_rng(options.seed), read_shades(options.shades)["lips"]
    paint, targets = PaintPictures(), labelled_lipsticks()
    lips = list(LABELS).index("lips")

    def real_of(name: str, rgb8: np.ndarray, face: Face) -> Iterator[Mouth]:
        if name in targets:
            yield mouth_of(rgb8, face, targets[name])

    def painted_of(rgb8: np.ndarray, face: Face, worn: list[int]) -> Iterator[Mouth]:
        for _ in range(0 if worn[lips] else options.looks):
            lipstick = draw_lipstick(rng, shades)
            yield mouth_of(paint(rgb8, Look([lipstick]), [face]), face, target_of(lipstick))

    pack_sets(options, real_of, painted_of)


if __name__ == "__main__":
    pack(parser_of(__doc__, looks=4).parse_args())
