"""Packs the outer corners of eyes that wear drawn liners, for the net that reads wings.

    python -m makeup_video.training.worn.wing_crops --faces DIR --sets portraits wild \
        --shades DIR --out runs/wings.npz

DIR is as for prepare.py. Only faces without liner are painted, and without clear eyeshadow: nobody
has labelled how long a wing is, so the truth is that of the drawn look. `varied` puts before such a
corner what else is dark there in real photos: lashes, hair and folds.
"""

import argparse
import math

import cv2
import numpy as np
from makeup_video.pipeline.look.look import Look
from makeup_video.pipeline.reference.wing import (
    ANGLE_UNIT,
    CORNER_WH,
    CORNER_XY,
    EYE_PX,
    corner_inputs,
)
from makeup_video.pipeline.render.apply_look import PaintPictures
from makeup_video.training.faces.augment import jpeg
from makeup_video.training.worn.draw_looks import draw_look, read_shades
from makeup_video.training.worn.prepare import LABELS, labelled_faces, parser_of

SHARES = {"eyeshadow": 0.55, "eyeliner": 0.78}
_LEAST_OPACITY = 0.3  # of a liner that can be seen
_SUBPIXEL = 3  # bits, of the lines that OpenCV draws


def target_of(look: Look) -> tuple[float, float, float, float]:
    """Whether liner is worn, whether it has a wing, and of the wing length and angle, 0..1."""
    for layer in look.of("eyeliner"):
        if layer.product.opacity * layer.strength > _LEAST_OPACITY:
            shape = layer.whole_shape
            wing, angle = shape["wing"], shape["wing_angle"]
            return 1.0, float(wing > 0), wing, angle / ANGLE_UNIT
    return 0.0, 0.0, 0.0, 0.0


def varied(rgb8: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """A corner (72, 112, 3) uint8 as other photos show it."""
    for share, add in ((0.4, _add_lashes), (0.25, _add_hair), (0.35, _add_fold)):
        if rng.random() < share:
            rgb8 = add(rgb8, rng)
    rgb8 = _moved(rgb8, rng)
    if rng.random() < 0.5:
        factor = rng.uniform(0.3, 0.9)
        small = cv2.resize(rgb8, None, fx=factor, fy=factor, interpolation=cv2.INTER_AREA)
        rgb8 = cv2.resize(small, CORNER_WH, interpolation=cv2.INTER_LINEAR)
    if rng.random() < 0.4:
        rgb8 = jpeg(rgb8, int(rng.integers(25, 90)))
    x = (rgb8.astype(np.float32) / 255) ** math.exp(rng.normal(0, 0.3))
    x *= np.exp(rng.normal(0, 0.12, 3) + rng.normal(0, 0.15))
    x = x.mean() + (x - x.mean()) * rng.uniform(0.7, 1.4)
    x += rng.normal(0, rng.uniform(0, 0.03), x.shape)
    coded: np.ndarray = np.rint(255 * x.clip(0, 1)).astype(np.uint8)
    return coded


def _add_lashes(rgb8: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Lashes of the outer half of the upper lid, which fan out."""
    drawn, dark = rgb8.copy(), rng.uniform(0, 50, 3).tolist()
    for _ in range(rng.integers(4, 16)):
        x = rng.uniform(35, CORNER_XY[0])
        across = math.sin(math.pi * (CORNER_XY[0] - x) / EYE_PX)
        y = CORNER_XY[1] - EYE_PX * rng.uniform(0.25, 0.35) * across + rng.uniform(-2, 2)
        angle = math.radians(float(np.clip(128 - 1.4 * x + rng.normal(0, 12), 5, 100)))
        _draw(drawn, [_ray((x, y), angle, rng.uniform(6, 18))], dark, 1)
    return drawn


def _add_hair(rgb8: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Strands that hang down beside the eye."""
    drawn, colour = rgb8.copy(), (rng.uniform(10, 110) * np.array([1, 0.8, 0.65])).tolist()
    x, bend = rng.uniform(74, CORNER_WH[0]), rng.normal(0, 12)
    down = np.linspace(0, 1, 5)
    for _ in range(rng.integers(1, 12)):
        across = x + rng.normal(0, 6) + bend * down + rng.normal(0, 1, 5)
        line = np.column_stack([across, CORNER_WH[1] * down])
        _draw(drawn, [line], colour, int(rng.integers(1, 4)))
    return drawn


def _add_fold(rgb8: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """A soft dark fold that begins at the corner."""
    fold = np.zeros(CORNER_WH[::-1], np.float32)
    start = rng.uniform(62, 74), rng.uniform(36, 46)
    ray = _ray(start, math.radians(rng.uniform(-50, 40)), rng.uniform(6, 26))
    _draw(fold, [ray], [1.0], int(rng.integers(1, 4)))
    fold = cv2.GaussianBlur(fold, (0, 0), rng.uniform(0.8, 2.2))
    depth = rng.uniform(0.1, 0.4) / max(float(fold.max()), 1e-3)
    darker: np.ndarray = (rgb8 * (1 - depth * fold[..., None])).astype(np.uint8)
    return darker


def _ray(start: tuple[float, float], angle: float, length: float) -> np.ndarray:
    """A line that rises by an angle (radians), (2, 2) px."""
    along = length * np.array([math.cos(angle), -math.sin(angle)])
    return np.array([start, start + along])


def _draw(
    picture: np.ndarray, lines: list[np.ndarray], colour: list[float], thickness: int
) -> None:
    fixed = [np.rint(line * 2**_SUBPIXEL).astype(np.int32) for line in lines]
    cv2.polylines(picture, fixed, False, colour, thickness, cv2.LINE_AA, _SUBPIXEL)


def _moved(rgb8: np.ndarray, rng: np.random.Generator) -> np.ndarray:
    """Turned, scaled and shifted about the corner, as landmarks of photos err."""
    turn, scale = rng.normal(0, 0.07), math.exp(rng.normal(0, 0.05))
    linear = scale * np.array([[math.cos(turn), math.sin(turn)], [-math.sin(turn), math.cos(turn)]])
    shift = CORNER_XY - linear @ CORNER_XY + rng.normal(0, 1.6, 2)
    moved = np.column_stack([linear, shift])
    return cv2.warpAffine(rgb8, moved, CORNER_WH, borderMode=cv2.BORDER_REPLICATE)


def pack(options: argparse.Namespace) -> None:
    options.out.parent.mkdir(parents=True, exist_ok=True)
    rng, shades = np.random.default_rng(options.seed), read_shades(options.shades)
    paint = PaintPictures()
    inputs: list[np.ndarray] = []
    targets: list[tuple[float, ...]] = []
    liner, shadow = list(LABELS).index("liner"), list(LABELS).index("shadow")
    for name in options.sets:
        for rgb8, face, known in labelled_faces(options.faces / name):
            if known[liner] != 0 or known[shadow] == 1:
                continue
            for _ in range(options.looks):
                look = draw_look(rng, shades, SHARES)
                inputs += list(corner_inputs(paint(rgb8, look, [face]), face)[0])
                targets += [target_of(look)] * 2
        print(f"{name}: {len(inputs)} corners in all", flush=True)
    np.savez(options.out, inputs=inputs, targets=np.float32(targets))


if __name__ == "__main__":
    pack(parser_of(__doc__, looks=5).parse_args())
