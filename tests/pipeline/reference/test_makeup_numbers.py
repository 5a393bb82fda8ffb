"""A look as a vector: what goes in comes out, and only what is worn counts."""

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from makeup_video.pipeline.look.finishes import product
from makeup_video.pipeline.look.kinds import KINDS
from makeup_video.pipeline.look.look import Layer, Look
from makeup_video.pipeline.reference.makeup_numbers import COUNT, LAYERS, from_vector, to_vector


@st.composite
def looks(draw):
    layers, shadows = [], 0
    for kind_name, slot, dials in LAYERS:
        kind = KINDS[kind_name]
        if not draw(st.booleans()) or (kind_name == "eyeshadow" and shadows == kind.most):
            continue
        shadows += kind_name == "eyeshadow"
        shape = {"slot": slot} if slot else {}
        for dial in kind.dials:
            if dial.name in dials:
                shape[dial.name] = draw(st.floats(dial.low, dial.high))
        rgb = draw(st.tuples(*[st.integers(0, 255)] * 3))
        worn = product(rgb, draw(st.sampled_from(["matte", "gloss"])), kind.part)
        layers.append(Layer(kind_name, worn, shape, draw(st.floats(0.1, 1))))
    return Look(layers)


@settings(max_examples=60)
@given(looks())
def test_a_look_is_read_back_from_its_vector(look):
    vector, weights = to_vector(look)
    assert vector.shape == weights.shape == (COUNT,)
    assert (vector >= 0).all() and (vector <= 1).all() and (weights >= 0).all()
    read = {(layer.kind, layer.slot): layer for layer in from_vector(vector)}
    assert len(read) == len(LAYERS)
    for layer in look.layers:
        one = read.pop((layer.kind, layer.shape.get("slot", "")))
        assert abs(one.opacity - layer.product.opacity * layer.strength) < 1e-6
        colour = layer.product.red, layer.product.green, layer.product.blue
        np.testing.assert_allclose(one.rgb, colour, atol=1e-3)
        for name, value in one.shape.items():
            assert abs(value - layer.whole_shape[name]) < 2e-3
    assert all(one.opacity == 0 for one in read.values())


@given(st.lists(st.floats(-3, 4), min_size=COUNT, max_size=COUNT))
def test_any_vector_gives_layers_that_can_be_worn(vector):
    for one in from_vector(np.array(vector)):
        KINDS[one.kind].check_shape(one.shape, "shape")
        assert 0 <= one.opacity <= 1 and all(0 <= code <= 255 for code in one.rgb)


def test_what_is_not_worn_counts_by_its_opacity_alone():
    _, weights = to_vector(Look())
    assert weights.sum() == len(LAYERS)
