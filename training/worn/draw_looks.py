"""Draws looks of several kinds, as people wear them, for the net that reads what is worn."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from makeup_video.pipeline.look.finishes import FINISHES, product
from makeup_video.pipeline.look.kinds import KINDS
from makeup_video.pipeline.look.look import Layer, Look
from makeup_video.pipeline.look.params import rgb_of_hex
from makeup_video.training.worn.table import rows_of

Rgb = tuple[float, float, float]
# How often each kind is worn, and, where eyeshadow is worn, each of its slots.
KIND_SHARE = {"lipstick": 0.5, "eyeshadow": 0.6, "eyeliner": 0.45, "blush": 0.4}
SLOT_SHARE = {
    "lid": 0.8, "crease": 0.55, "outer": 0.4, "under": 0.4, "inner": 0.15, "brow_bone": 0.2,
}  # fmt: skip
_SAME_COLOUR = 0.5  # share of the further slots in the first one's colour, lighter or darker
_FROM_SHOPS = 0.7  # share of the colours of lips and lids that come from shops' products
_PARTS = {kind.name: kind.part for kind in KINDS.values()}


def read_shades(folder: Path) -> dict[str, list[str]]:
    """Hex colours of products, for each part of the face."""
    tables = {"lips": "lip_shades.csv", "eyes": "eyeshadow_shades.csv"}
    return {part: [row["hex"] for row in rows_of(folder / name)] for part, name in tables.items()}


def draw_look(
    rng: np.random.Generator,
    shades: dict[str, list[str]],
    shares: Mapping[str, float] = KIND_SHARE,
) -> Look:
    """A look of some kinds, in colours of shops' products or in random colours.

    shares: how often each kind is worn.
    """
    layers: list[Layer] = []
    for kind, share in shares.items():
        if rng.random() < share:
            draw = {"eyeshadow": _shadows, "eyeliner": _liner, "blush": _blush}.get(kind, _lips)
            layers += draw(rng, shades)
    return Look(layers)


def _shadows(rng: np.random.Generator, shades: dict[str, list[str]]) -> list[Layer]:
    slots = [slot for slot, share in SLOT_SHARE.items() if rng.random() < share][:4]
    first, strength = rgb_from(rng, shades.get("eyes", [])), rng.uniform(0.3, 1)
    layers = []
    for slot in slots or ["lid"]:
        rgb = first
        if layers and rng.random() < _SAME_COLOUR:
            low, high = rng.uniform(0.4, 1.3), rng.normal(0, 10, 3)
            rgb = _clipped(np.array(first) * low + high)
        elif layers:
            rgb = rgb_from(rng, shades.get("eyes", []))
        here = float(np.clip(strength * rng.uniform(0.6, 1.3), 0.2, 1))
        layers.append(_layer(rng, "eyeshadow", rgb, {"slot": slot}, here))
    return layers


def _liner(rng: np.random.Generator, shades: dict[str, list[str]]) -> list[Layer]:
    dark = rng.random() < 0.8
    rgb = _clipped(rng.uniform(5, 55, 3) if dark else rng.uniform(0, 255, 3))
    shape = {
        "thickness": float(rng.uniform(0.05, 0.35)),
        "wing": float(rng.uniform(0.08, 0.5)) if rng.random() < 0.5 else 0.0,
        "wing_angle": float(rng.uniform(5, 55)),
        "lower": float(rng.uniform(0.3, 1)) if rng.random() < 0.4 else 0.0,
        "softness": float(rng.uniform(0, 0.5)),
    }
    return [_layer(rng, "eyeliner", rgb, shape, float(rng.uniform(0.5, 1)))]


def _blush(rng: np.random.Generator, shades: dict[str, list[str]]) -> list[Layer]:
    rgb = _clipped(np.array(KINDS["blush"].first_rgb) + rng.normal(0, 28, 3))
    shape = {name: float(rng.random()) for name in ("height", "reach", "size", "softness")}
    shape["across"] = float(rng.random()) if rng.random() < 0.2 else 0.0
    return [_layer(rng, "blush", rgb, shape, float(rng.uniform(0.4, 1)))]


def _lips(rng: np.random.Generator, shades: dict[str, list[str]]) -> list[Layer]:
    shape = {"gradient": float(rng.uniform(0.3, 1)) if rng.random() < 0.25 else 0.0}
    rgb = rgb_from(rng, shades.get("lips", []))
    return [_layer(rng, "lipstick", rgb, shape, float(rng.uniform(0.3, 1)))]


def _layer(
    rng: np.random.Generator, kind: str, rgb: Rgb, shape: dict[str, object], strength: float
) -> Layer:
    names = list(FINISHES)
    worn = product(rgb, names[rng.integers(len(names))], _PARTS[kind])
    return Layer(kind, worn, shape, strength)


def rgb_from(rng: np.random.Generator, shades: Sequence[str]) -> Rgb:
    """The colour of a shop's product, or a random colour; codes 0..255."""
    if shades and rng.random() < _FROM_SHOPS:
        known = rgb_of_hex(shades[rng.integers(len(shades))])
        if known is not None:
            return known
    return _clipped(rng.uniform(0, 255, 3))


def _clipped(rgb: np.ndarray) -> Rgb:
    red, green, blue = np.clip(rgb, 0, 255).tolist()
    return red, green, blue
