"""Looks of every kind for hypothesis, made from the registry."""

import math
from dataclasses import fields

import numpy as np
from hypothesis import strategies as st
from makeup_video.pipeline import KINDS, GraphicsParams, Layer, Look, product
from makeup_video.pipeline.look.kinds.density_map import HW, to_text

SPECS = {spec.name: spec.metadata for spec in fields(GraphicsParams)}
SEVEN = ("red", "green", "blue", "opacity", "gloss", "gloss_roughness", "reflection")
UNIT = st.floats(0, 1)


def numbers(low, high):
    """Floats and integers of a range."""
    return st.floats(low, high) | st.integers(math.ceil(low), math.floor(min(high, 10**6)))


def products():
    """JSON objects of products."""

    def values(name):
        return numbers(SPECS[name]["low"], SPECS[name]["high"])

    return st.fixed_dictionaries(
        {name: values(name) for name in SEVEN},
        optional={name: values(name) for name in SPECS if name not in SEVEN},
    )


def dial_values(dial):
    """The values that a dial may have."""
    if dial.choices:
        return st.sampled_from(dial.choices)
    if dial.is_colour:
        return st.from_regex(r"#[0-9a-fA-F]{6}", fullmatch=True)
    if dial.is_map:
        return st.just("") | density_maps().map(to_text)
    return numbers(dial.low, dial.high)


def density_maps():
    """Densities of a layer around the eye, (27, 24) float32, 0..1."""
    return st.integers(0, 2**32 - 1).map(
        lambda seed: np.random.default_rng(seed).random(HW, np.float32)
    )


def shapes(kind):
    """JSON objects of shapes of a kind."""
    return st.fixed_dictionaries({}, optional={dial.name: dial_values(dial) for dial in kind.dials})


def layers(kind):
    """JSON objects of layers of one kind."""
    return st.fixed_dictionaries(
        {"kind": st.just(kind.name), "product": products()},
        optional={"strength": UNIT, "shape": shapes(kind)},
    )


@st.composite
def look_objects(draw):
    """JSON objects of looks of version 2, with as many layers of each kind as may be."""
    found = [
        layer
        for kind in KINDS.values()
        for layer in draw(st.lists(layers(kind), max_size=kind.most))
    ]
    look = {"version": 2, "layers": draw(st.permutations(found))}
    if draw(st.booleans()):
        look["strength"] = draw(UNIT)
    return look


PRODUCTS = products().map(lambda values: GraphicsParams.from_dict(values))


@st.composite
def looks(draw):
    """Looks of any kinds."""
    return Look.from_dict(draw(look_objects()))


def layer_of(kind, hexed="#B4002E", finish="matte", **changes):
    """A layer of a kind in a colour and a finish."""
    return Layer(kind, product(bytes.fromhex(hexed[1:]), finish, KINDS[kind].part), **changes)
