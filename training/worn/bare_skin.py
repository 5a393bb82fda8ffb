"""Measures bare faces: the skin around their eyes and on their cheeks, and how products show there.

    python -m makeup_video.training.worn.bare_skin --faces DIR --out pipeline/weights

DIR has the folders `portraits` and `wild`, as worn/prepare.py describes them. Only faces without
any makeup count. Writes bare_eyes.npy and bare_cheeks.npy, and prints how blush and lipstick show:
these numbers are constants of the product. The shipped files were measured while hair over the
forehead still counted as skin, and hair beside the eyes as the skin there
(docs/decisions/reference.md).
"""

import argparse
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import islice
from pathlib import Path

import cv2
import numpy as np
from makeup_video.kernels.colour import SRGB, to_linear
from makeup_video.pipeline.faces.face import Face, iod_px
from makeup_video.pipeline.look.finishes import product
from makeup_video.pipeline.look.kinds import PARTS
from makeup_video.pipeline.look.look import Layer, Look
from makeup_video.pipeline.reference.cheeks import SIDE, Cheeks, density
from makeup_video.pipeline.reference.colours import Colours
from makeup_video.pipeline.reference.fit_lips import shown_by_lips
from makeup_video.pipeline.reference.neutral_face import NeutralFace, neutral_face
from makeup_video.pipeline.reference.photo_light import photo_light
from makeup_video.pipeline.render.apply_look import PaintPictures
from makeup_video.training.inputs import existing
from makeup_video.training.list_hashes import list_hashes
from makeup_video.training.worn.prepare import labelled_faces

SETS = {"portraits": 3, "wild": 4}  # every third, and every fourth face is measured
NARROWEST_PX = 40  # least IOD
_PAINTED = 8  # one face in so many is also painted, in _COLOURS random colours
_COLOURS = 3
_LIPS, _BLUSH = 0.85, 0.6  # opacities of the painted lipstick and blush
_LEAST_DENSE = 0.1  # places with less blush do not count
_SURELY_SKIN = 0.5
_LEAST_COUNT = 20  # a cell of the cheeks with no more nodes counts as unknown
# The skin under makeup around the eyes is taken for this percentile of bare faces: people who wear
# makeup have thinner brows and more even skin than most bare faces, many of which are men's.
_LIGHTER = 65
_SPREAD = 0.01  # added to the variance of bare faces, for differences that none of them shows
# Eyeshadow all around the eye: above it and below it.
_ALL_AROUND = [
    {"low": low, "high": high, "inner": -0.3, "outer": 1.6, "softness": 0.0}
    for low, high in ((0.0, 2.2), (-1.3, 0.0))
]


def bare_faces(folder: Path) -> Iterator[tuple[np.ndarray, Face]]:
    for name, step in SETS.items():
        bare = (one for one in labelled_faces(folder / name) if not any(one[2]))
        for rgb8, face, _ in islice(bare, None, None, step):
            if iod_px(face) >= NARROWEST_PX:
                yield rgb8, face


def neutral_of(rgb8: np.ndarray, face: Face) -> NeutralFace:
    return neutral_face(rgb8, face, photo_light(rgb8, face))


class Response:
    """Fits `painted = (1 - cover) * bare + response * root` by least squares, cell by cell."""

    def __init__(self) -> None:
        self._sums = np.zeros(5)

    def add(self, bare: np.ndarray, painted: np.ndarray, added: np.ndarray) -> None:
        """Add cells, (..., 3) roots each; `added` is what `response` multiplies.

        The last axis is summed over.
        """
        off = painted - bare
        products = (bare * bare, -bare * added, added * added, -bare * off, added * off)
        sums = np.stack([each.sum(-1) for each in products])
        self._sums = self._sums + sums if self._sums.shape == sums.shape else sums

    def solve(self) -> tuple[np.ndarray, np.ndarray]:
        """The cover, 0..1, and the response, 0..2, of each cell."""
        a, b, c, p, q = self._sums
        det = np.maximum(a * c - b * b, 1e-9)
        return np.clip((p * c - q * b) / det, 0, 1), np.clip((a * q - b * p) / det, 0, 2)


def measure(folder: Path, out: Path) -> None:
    rng, painted = np.random.default_rng(0), Painted()
    eyes: list[np.ndarray] = []
    lips: list[np.ndarray] = []
    cheeks = np.zeros((SIDE, SIDE, 4))
    for number, (rgb8, face) in enumerate(bare_faces(folder)):
        seen = Colours.of(neutral_of(rgb8, face))
        if seen.eyes is None or seen.lips is None or seen.cheeks is None:
            continue
        eyes.append(seen.eyes)
        lips.append(shown_by_lips(seen.neutral, seen.lips))
        _splat(cheeks, seen.cheeks)
        for _ in range(0 if number % _PAINTED else _COLOURS):
            red, green, blue = rng.integers(0, 256, 3).tolist()
            painted.add(rgb8, face, (red, green, blue))
    cover, response = painted.shown["eyes"].solve()
    spread = np.std(eyes, axis=0).mean(-1)
    weights = np.clip((cover - 0.2) / 0.4, 0, 1) / (spread**2 + _SPREAD)
    bare = np.percentile(eyes, _LIGHTER, axis=0)
    maps = [*np.moveaxis(bare, -1, 0), cover, response, weights / weights.max()]
    np.save(out / "bare_eyes.npy", np.stack(maps, -1).astype(np.float16))
    known = cheeks[..., 3:] > _LEAST_COUNT
    blurred = cv2.GaussianBlur(
        np.where(known, cheeks, 0) / np.maximum(cheeks[..., 3:], 1), (0, 0), 1
    )
    blurred[..., :3] /= np.maximum(blurred[..., 3:], 1e-3)
    np.save(out / "bare_cheeks.npy", blurred.astype(np.float16))
    list_hashes(out)
    print(f"{len(eyes)} faces; lips {np.median(lips, axis=0).round(3).tolist()}")
    for name in ("blush", "lips"):
        print(
            name,
            "cover, response:",
            *(float(each.round(3)) for each in painted.shown[name].solve()),
        )


def _splat(cheeks: np.ndarray, seen: Cheeks) -> None:
    """Add the nodes of a face to the map (32, 32, 4): sums of roots, and numbers of nodes."""
    x, y = (np.rint(part).astype(int) for part in seen.cells())
    inside = (x >= 0) & (x < SIDE) & (y >= 0) & (y < SIDE) & (seen.skin > _SURELY_SKIN)
    counted = np.concatenate([seen.roots, np.ones_like(seen.roots[..., :1])], -1)[inside]
    np.add.at(cheeks, (y[inside], x[inside]), counted)


class Painted:
    """How products show on bare faces, by where they are worn."""

    def __init__(self) -> None:
        self.shown = {name: Response() for name in ("eyes", "blush", "lips")}
        self._paint = PaintPictures()

    def add(self, rgb8: np.ndarray, face: Face, rgb: tuple[float, float, float]) -> None:
        """Paint a bare face in one colour, and compare."""
        before = neutral_of(rgb8, face)
        root = np.sqrt(to_linear(np.array(rgb) / 255, SRGB) / before.skin)

        def wearing(part: str, shapes: Sequence[Mapping[str, float]], opacity: float) -> Colours:
            coat = replace(product(rgb, "matte", part), opacity=opacity)
            look = Look([Layer(PARTS[part].name, coat, dict(shape)) for shape in shapes])
            return Colours.of(neutral_of(self._paint(rgb8, look, [face]), face))

        bare, eyes = Colours.of(before), wearing("eyes", _ALL_AROUND, 1.0).eyes
        if bare.eyes is not None and eyes is not None:
            self.shown["eyes"].add(bare.eyes, eyes, np.broadcast_to(root, eyes.shape))
        worn = wearing("lips", [{}], _LIPS)
        if bare.lips is not None and worn.lips is not None:
            shown = (shown_by_lips(one.neutral, one.lips) for one in (bare, worn))
            self._add_shares("lips", *shown, np.array(_LIPS), root)
        cheeks = wearing("blush", [{}], _BLUSH).cheeks
        if bare.cheeks is not None and cheeks is not None:
            dense = _BLUSH * density(bare.cheeks, {}) * bare.cheeks.skin
            at = dense > _LEAST_DENSE
            rows3 = bare.cheeks.roots[at], cheeks.roots[at]
            self._add_shares("blush", *rows3, dense[at][:, None], root)

    def _add_shares(
        self, name: str, bare: np.ndarray, painted: np.ndarray, share: np.ndarray, root: np.ndarray
    ) -> None:
        """Add places that the product covers only in part, all to one sum."""
        covered = bare * share
        added = np.broadcast_to(root * share, covered.shape)
        self.shown[name].add(covered.ravel(), (painted - bare + covered).ravel(), added.ravel())


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--faces", type=existing, required=True)
    parser.add_argument("--out", type=Path, required=True)
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    measure(options.faces, options.out)
