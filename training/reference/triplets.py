"""Triplets for evaluation: a wearer of a look, a bare person, and that person with the look.

All three are whole portraits. The renderer paints the look with all of its 17 parameters.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from makeup_video.pipeline.faces.face import Face, FrameFaces
from makeup_video.pipeline.look.finishes import product
from makeup_video.pipeline.look.kinds import PARTS
from makeup_video.pipeline.look.look import ZONES, Look
from makeup_video.pipeline.reference.crops import CROPPED, NUMBERS
from makeup_video.pipeline.render.build_scene import BuildScene
from makeup_video.pipeline.render.composite import Composite
from makeup_video.pipeline.render.surfaces.eyes_twin import lid_surfaces
from makeup_video.pipeline.render.surfaces.lips_twin import lips_surface
from makeup_video.pipeline.render.surfaces.surface import Edge, Surface
from makeup_video.training.faces.augment import jpeg
from makeup_video.training.reference.draw_products import draw_settings, look_of
from makeup_video.training.reference.people import People
from makeup_video.training.reference.rendered_crops import (
    TEST_QUALITY,
    Draws,
    Shot,
    frame_of,
    paint,
    to_codes,
)

LEAST_PX = 20  # least px of makeup: leaves out eyes that are almost shut and very thin lips
_HALF = 0.5  # edge softness, and least weight of px that count as painted

# Colours that shops hardly sell, and that learned makeup transfer is known to miss.
EXTREMES = {
    "blue": (20, 50, 200), "green": (30, 140, 50), "black": (16, 16, 18),
    "white": (242, 238, 234), "yellow": (240, 205, 30),
}  # fmt: skip
_EXTREME_SPREAD = 12.0  # code values of 255, one sigma
_EXTREME_OPACITY = 0.6, 1.0  # range: worn to be seen


class OfColour:
    """Draws products of about one colour and high opacity; their other numbers are as drawn."""

    def __init__(self, products: Draws, rgb: tuple[int, int, int]) -> None:
        self._products, self._rgb = products, rgb

    def draw(self, n: int, rng: np.random.Generator) -> np.ndarray:
        """(n, 7) numbers."""
        values = self._products.draw(n, rng)
        colour = self._rgb + rng.normal(0, _EXTREME_SPREAD, (n, 3))
        red = NUMBERS.index("red")
        values[:, red : red + 3] = colour.clip(0, 255)
        values[:, NUMBERS.index("opacity")] = rng.uniform(*_EXTREME_OPACITY, n)
        return values


@dataclass(frozen=True, slots=True, eq=False)
class Triplet:
    """A wearer of a look, a bare person, and the bare person with the same look.

    photo: (H, W, 3) uint8, the wearer with the look, after compression.
    truth: (H, W, 3) uint8, the bare person with the look.
    wearer, bare: whole portraits, not painted.
    where: (H, W) bool, px of `truth` with makeup.
    person, tone: of the wearer, indices into People and TONE_NAMES.
    """

    photo: np.ndarray
    look: Look
    wearer: Shot
    bare: Shot
    truth: np.ndarray
    where: np.ndarray
    person: int
    tone: int


def whole(people: People, person: int) -> Shot:
    """A portrait as it is, in its own light."""
    return shot_of(people.rgb8(person), people.face(person))


def shot_of(rgb8: np.ndarray, face: Face) -> Shot:
    """A whole picture with one face, in its own light."""
    codes = to_codes(rgb8)
    scene = BuildScene()(FrameFaces(frame_of(codes), (face,)))
    return Shot(codes, scene)


def weight_of(face: Face, region: str, zone: str, size_wh: tuple[int, int]) -> np.ndarray:
    """(H, W) float32: the weight at each px of a product with a medium soft edge."""
    mouth = lips_surface(face)
    surfaces: list[Surface] = [mouth] if mouth else []
    if region == "eyes":
        surfaces = [*lid_surfaces(face)]
    kind = PARTS[region]
    shape = kind.whole_shape({"slot": zone} if region == "eyes" else {})
    medium = replace(product((0, 0, 0), "matte", region), edge_softness=_HALF)
    total = np.zeros(size_wh[::-1], np.float32)
    for side in (side for surface in surfaces for side in surface.sides()):
        for coat in kind.coats(side.fields(), medium, shape):
            weight = np.empty_like(total)
            density = None if coat.density is None else coat.density[side.number]
            side.weigh(weight, (0, 0), Edge(_HALF), density)
            np.maximum(total, weight, out=total)
    return total


def halves(people: People) -> tuple[np.ndarray, np.ndarray]:
    """Indices of wearers and of bare people, nobody in both, with the same mix of skin tones."""
    order = np.argsort(people.tone, kind="stable")
    return order[::2], order[1::2]


def triplets(
    people: People,
    wearers: np.ndarray,
    others: np.ndarray,
    products: Mapping[str, Draws],
    count: int,
    seed: int,
) -> Iterator[Triplet]:
    """Draws triplets; the same seed gives the same triplets.

    wearers, others: indices into people, drawn with the probabilities `share`; a triplet has two
    different people. products: by region; a look wears one product of each.
    """
    rng, composite = np.random.default_rng(seed), Composite(Look())
    while count:
        person = _drawn(people, wearers, rng)
        other = _drawn(people, others[others != person], rng)
        look = _look(products, rng)
        wearer, bare = whole(people, person), whole(people, other)
        where, seen = (_where(shot, look) for shot in (bare, wearer))
        if min(where.sum(), seen.sum()) < LEAST_PX:
            continue
        photo = jpeg(paint(composite, wearer, look), TEST_QUALITY)
        truth = paint(composite, bare, look)
        yield Triplet(photo, look, wearer, bare, truth, where, person, int(people.tone[person]))
        count -= 1


def _drawn(people: People, among: np.ndarray, rng: np.random.Generator) -> int:
    share = people.share[among]
    return int(rng.choice(among, p=share / share.sum()))


def _look(products: Mapping[str, Draws], rng: np.random.Generator) -> Look:
    zone = ZONES[rng.integers(len(ZONES))]
    parts: dict[str, Any] = {}
    for region, draws in products.items():
        values = draws.draw(1, rng)[0]
        one = look_of(values, draw_settings(values, region, rng), region)
        parts[region] = getattr(one, region)
    return Look(**parts, zone=zone) if "eyes" in parts else Look(**parts)


def _where(shot: Shot, look: Look) -> np.ndarray:
    face, size_wh = shot.scene.faces[0].face, (shot.codes.shape[1], shot.codes.shape[0])
    made_up = np.zeros(shot.codes.shape[:2], bool)
    for region in worn(look):
        made_up |= weight_of(face, region, look.zone, size_wh) >= _HALF
    return made_up


def worn(look: Look) -> list[str]:
    """The regions of a look that wear something."""
    return [region for region in CROPPED if getattr(look, region) is not None]


def numbers_of(look: Look, region: str) -> np.ndarray:
    """The NUMBERS (7,) of a look's product in a region."""
    return np.array([getattr(getattr(look, region), name) for name in NUMBERS])
