"""Triplets to measure by: who wears a look, another person who is bare, and that one with the look.

All three are whole portraits. R paints the look with all of its 17 numbers.
"""

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np
from makeup_video.pipeline.faces.face import Face, FrameFaces
from makeup_video.pipeline.look.look import Look
from makeup_video.pipeline.look.regions import REGIONS
from makeup_video.pipeline.look.regions.eyes import ZONES
from makeup_video.pipeline.reference.crops import NUMBERS
from makeup_video.pipeline.render.build_scene import BuildScene
from makeup_video.pipeline.render.composite import Composite
from makeup_video.pipeline.render.regions.eyes_reference import lid_surfaces
from makeup_video.pipeline.render.regions.lips_reference import lips_surface
from makeup_video.training.reference.augment import jpeg
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

LEAST_PX = 20  # eyes almost shut and lips that are a thin line are left out
_HALF = 0.5  # weight and edge of what counts as painted

# Colours that shops hardly sell, and that learned transfer is known to miss.
EXTREMES = {
    "blue": (20, 50, 200), "green": (30, 140, 50), "black": (16, 16, 18),
    "white": (242, 238, 234), "yellow": (240, 205, 30),
}  # fmt: skip
_EXTREME_SPREAD = 12.0  # code values of 255, one sigma
_EXTREME_OPACITY = 0.6, 1.0  # worn to be seen


class OfColour:
    """Products of one colour, otherwise as they come."""

    def __init__(self, products: Draws, rgb: tuple[int, int, int]) -> None:
        self._products, self._rgb = products, rgb

    def draw(self, n: int, rng: np.random.Generator) -> np.ndarray:
        """(n, 7)."""
        values = self._products.draw(n, rng)
        colour = self._rgb + rng.normal(0, _EXTREME_SPREAD, (n, 3))
        at = NUMBERS.index("red")
        values[:, at : at + 3] = colour.clip(0, 255)
        values[:, NUMBERS.index("opacity")] = rng.uniform(*_EXTREME_OPACITY, n)
        return values


@dataclass(frozen=True, slots=True, eq=False)
class Triplet:
    """photo: (H, W, 3) uint8, the wearer as saved.  truth: the bare person with the same look.

    wearer, bare: whole portraits, not painted.  where: (H, W) bool, px of `truth` that are made up.
    person, tone: of the wearer, a place in People and in TONE_NAMES.
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
    codes = to_codes(rgb8)
    scene = BuildScene()(FrameFaces(frame_of(codes), (face,)))
    return Shot(codes, scene)


def weight_of(face: Face, region: str, zone: str, size_wh: tuple[int, int]) -> np.ndarray:
    """(H, W) float32: how much of a product of medium edge there is at each px of a picture."""
    mouth = lips_surface(face)
    parts = lid_surfaces(face) if region == "eyes" else [mouth] if mouth else []
    total = np.zeros(size_wh[::-1], np.float32)
    for part in parts:
        weight = np.empty_like(total)
        part.weigh(weight, (0, 0), _HALF, {"zone": zone})
        np.maximum(total, weight, out=total)
    return total


def halves(people: People) -> tuple[np.ndarray, np.ndarray]:
    """Places of those who wear looks and of those who are bare, none in both; tones alike."""
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
    """wearers, others: places in people, drawn as often as `share` says; never the same twice in
    a triplet.  products: by region, of each of them one is worn. The same seed gives the same."""
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
    parts = {}
    for region, draws in products.items():
        values = draws.draw(1, rng)[0]
        one = look_of(values, draw_settings(values, region, rng), region)
        parts[region] = getattr(one, region)
    return Look(**parts, zone=zone)


def _where(shot: Shot, look: Look) -> np.ndarray:
    face, size_wh = shot.scene.faces[0].face, (shot.codes.shape[1], shot.codes.shape[0])
    made_up = np.zeros(shot.codes.shape[:2], bool)
    for region in worn(look):
        made_up |= weight_of(face, region, look.zone, size_wh) >= _HALF
    return made_up


def worn(look: Look) -> list[str]:
    """The regions that wear something."""
    return [region for region in REGIONS if getattr(look, region) is not None]


def numbers_of(look: Look, region: str) -> np.ndarray:
    """(7,) of a region, as NUMBERS."""
    return np.array([getattr(getattr(look, region), name) for name in NUMBERS])
