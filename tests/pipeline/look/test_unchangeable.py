"""Looks, layers, products and settings refuse to be changed in words that say what to do."""

from dataclasses import FrozenInstanceError, replace

import pytest
from makeup_video.pipeline import Layer, LookError, Settings, product, ready_look

LOOK = ready_look("cat-eye").look


@pytest.mark.parametrize(
    ("thing", "name"),
    [
        (LOOK, "lips"),
        (LOOK, "strength"),
        (LOOK, "lipps"),
        (LOOK.layers[0], "strength"),
        (LOOK.layers[0].product, "red"),
        (Settings(), "crf"),
        (Settings(), "crff"),
    ],
)
def test_a_set_attribute_is_refused_with_what_to_do(thing, name):
    kind = type(thing).__name__
    with pytest.raises(FrozenInstanceError, match=f"{name} of a {kind} cannot be set: .*replace"):
        setattr(thing, name, 1)


def test_another_one_is_made_by_replace():
    assert replace(LOOK, strength=0.5).strength == 0.5 and LOOK.strength == 1
    assert replace(Settings(), crf=20).crf == 20
    assert replace(LOOK.layers[0].product, red=9).red == 9


@pytest.mark.parametrize("word", ["lips", "eyes", "", "mascara", None])
def test_layers_of_a_word_that_is_no_kind_are_an_error(word):
    with pytest.raises(LookError, match="kind must be one of lipstick, eyeshadow"):
        LOOK.of(word)


@pytest.mark.parametrize("colour", [{180, 0, 46}, {"red": 180}, {1: 1, 2: 2, 3: 3}, 7])
def test_colours_without_an_order_are_refused(colour):
    with pytest.raises(TypeError, match="a colour is"):
        product(colour, "gloss")


def test_a_layer_takes_the_products_that_product_makes():
    assert Layer("lipstick", product((180, 0, 46), "gloss")).product.red == 180
