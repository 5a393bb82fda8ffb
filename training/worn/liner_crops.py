"""Packs the outer corners of eyes, for the net that reads eyeliner.

    python -m makeup_video.training.worn.liner_crops --faces DIR --sets portraits \
        --shades DIR --out runs/liners.npz

DIR is as for prepare.py. Faces without liner and without clear eyeshadow are painted with drawn
looks, which give the targets. Faces that liners.csv names are packed as they are, with our labels:
for each eye, whether it has liner and a wing (0 no, 1 not sure, 2 yes), and how thick the line is,
if somebody looked. Eyes too small to show a line are left out.
"""

import argparse
from collections.abc import Iterator, Sequence
from math import nan
from pathlib import Path

import numpy as np
from makeup_video.pipeline.faces.face import Face
from makeup_video.pipeline.look.look import Look
from makeup_video.pipeline.reference.read_liner import ANGLE_UNIT, corner_inputs
from makeup_video.pipeline.render.apply_look import PaintPictures
from makeup_video.training.worn.corner import Corner, lids_of
from makeup_video.training.worn.draw_looks import draw_look, read_shades
from makeup_video.training.worn.packed import pack_sets
from makeup_video.training.worn.prepare import LABELS, parser_of
from makeup_video.training.worn.table import rows_of

SHARES = {"eyeshadow": 0.55, "eyeliner": 0.78}  # how often each kind is painted
_LEAST_OPACITY = 0.3  # of a liner that can be seen
_LEAST_WIDE_PX = 24.0  # width of an eye
_LABELS = Path(__file__).with_name("liners.csv")
_KNOWN = {"0": 0.0, "1": nan, "2": 1.0}  # label -> target
_EYES = ("right", "left")  # in the order of EYE_CORNERS

Target = tuple[float, ...]  # the NUMBERS of corner.py


def target_of(look: Look) -> Target:
    """The target of a drawn look. Its thickness is unknown: lashes are part of a line in photos."""
    for layer in look.of("eyeliner"):
        if layer.product.opacity * layer.strength > _LEAST_OPACITY:
            shape = layer.whole_shape
            wing = shape["wing"]
            length, angle = (wing, shape["wing_angle"] / ANGLE_UNIT) if wing else (nan, nan)
            return 1.0, float(wing > 0), length, angle, nan
    return 0.0, 0.0, nan, nan, nan


def labelled_liners() -> dict[str, list[Target | None]]:
    """The targets in liners.csv of the right and the left eye, for each picture; None for an eye
    without a label, which is turned away."""
    found: dict[str, list[Target | None]] = {}
    for row in rows_of(_LABELS):
        liner, wing, thickness = _KNOWN[row["liner"]], _KNOWN[row["wing"]], row["thickness"]
        target = (liner, wing, nan, nan, float(thickness or nan))
        found.setdefault(row["name"], [None, None])[_EYES.index(row["eye"])] = target
    return found


def corners_of(rgb8: np.ndarray, face: Face, targets: Sequence[Target | None]) -> Iterator[Corner]:
    """The corners of the right and the left eye, if they have a target and the eye is wide
    enough."""
    inputs, widths_px = corner_inputs(rgb8, face)
    for seen, target, lids, wide in zip(inputs, targets, lids_of(face), widths_px, strict=True):
        if target is not None and wide >= _LEAST_WIDE_PX:
            yield Corner(seen, np.float32(target), lids)


def pack(options: argparse.Namespace) -> None:
    rng, shades = np.random.default_rng(options.seed), read_shades(options.shades)
    paint, targets = PaintPictures(), labelled_liners()
    liner, shadow = list(LABELS).index("liner"), list(LABELS).index("shadow")

    def real_of(name: str, rgb8: np.ndarray, face: Face) -> Iterator[Corner]:
        if name in targets:
            yield from corners_of(rgb8, face, targets[name])

    def painted_of(rgb8: np.ndarray, face: Face, worn: list[int]) -> Iterator[Corner]:
        for _ in range(0 if worn[liner] or worn[shadow] == 1 else options.looks):
            look = draw_look(rng, shades, SHARES)
            yield from corners_of(paint(rgb8, look, [face]), face, [target_of(look)] * 2)

    pack_sets(options, real_of, painted_of)


if __name__ == "__main__":
    pack(parser_of(__doc__, looks=5).parse_args())
