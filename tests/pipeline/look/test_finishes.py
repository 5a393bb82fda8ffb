"""Finishes are complete and in range, and differ as their names suggest."""

from dataclasses import fields, replace

import pytest
from hypothesis import given
from hypothesis import strategies as st
from looks import layer_of
from makeup_video.pipeline import FINISHES, GraphicsParams, Look, LookError, UsageError, product
from makeup_video.pipeline.look.finishes import in_words, look_in_words, place_in_words
from makeup_video.pipeline.look.kinds import PARTS

CODES = st.tuples(*[st.integers(0, 255)] * 3)
NAMES = st.sampled_from(list(FINISHES))


def test_there_are_six_finishes_for_every_part():
    assert list(FINISHES) == ["matte", "satin", "sheer", "gloss", "metallic", "shimmer"]
    assert all(list(by_part) == list(PARTS) for by_part in FINISHES.values())


@pytest.mark.parametrize("part", PARTS)
def test_a_finish_sets_everything_but_the_colour(part):
    names = {spec.name for spec in fields(GraphicsParams)} - {"red", "green", "blue"}
    assert len(names) == 14
    for by_part in FINISHES.values():
        assert set(by_part[part]) == names


@given(CODES, NAMES, st.sampled_from(list(PARTS)))
def test_every_colour_in_every_finish_is_a_product(rgb, finish, part):
    params = product(rgb, finish, part)
    assert (params.red, params.green, params.blue) == rgb
    assert all(getattr(params, name) == value for name, value in FINISHES[finish][part].items())


@pytest.mark.parametrize("part", PARTS)
def test_finishes_are_ordered_as_their_names_say(part):
    by_finish = {name: FINISHES[name][part] for name in FINISHES}
    assert by_finish["matte"]["gloss"] == 0 and by_finish["matte"]["reflection"] == 0
    plain = [name for name in FINISHES if not by_finish[name]["shimmer"]]
    assert max(plain, key=lambda name: by_finish[name]["gloss"]) == "gloss"
    assert min(by_finish, key=lambda name: by_finish[name]["opacity"]) == "sheer"
    assert max(by_finish, key=lambda name: by_finish[name]["shimmer"]) == "shimmer"
    assert max(by_finish, key=lambda name: by_finish[name]["shimmer_tint"]) == "metallic"


@pytest.mark.parametrize("finish", FINISHES)
def test_eye_shadow_is_softer_and_broader_than_lipstick(finish):
    lips, eyes = FINISHES[finish]["lips"], FINISHES[finish]["eyes"]
    assert eyes["edge_softness"] > lips["edge_softness"]
    assert eyes["gloss_roughness"] > lips["gloss_roughness"]
    assert eyes["reflection"] <= lips["reflection"]


@pytest.mark.parametrize(
    ("rgb", "finish", "part", "error", "words"),
    [
        ((0, 0, 0), "glosy", "lips", UsageError, "matte, satin, sheer"),
        ((0, 0, 0), "gloss", "nose", UsageError, "lips, eyes"),
        ((0, 0), "gloss", "lips", UsageError, "got 2 numbers"),
        ((0, 256, 0), "gloss", "lips", LookError, "green must be"),
    ],
)
def test_invalid_products_are_refused(rgb, finish, part, error, words):
    with pytest.raises(error, match=words):
        product(rgb, finish, part)


@pytest.mark.parametrize("part", PARTS)
def test_every_finish_has_its_own_word(part):
    words = [in_words(product("red", finish, part), part).split(",")[0] for finish in FINISHES]
    assert words == ["matte", "satin", "sheer", "glossy", "metallic", "shimmering"]


@given(st.floats(0, 1), st.floats(0, 4), st.floats(0, 1), st.sampled_from(list(PARTS)))
def test_words_for_gloss_and_cover_agree_with_the_numbers(opacity, gloss, reflection, part):
    worn = product("red", "matte", part)
    shine, cover = in_words(
        replace(worn, opacity=opacity, gloss=gloss, reflection=reflection), part
    ).split(", ")
    assert shine != "sheer" or "light" in cover
    mirror = in_words(replace(worn, opacity=opacity, gloss=gloss, reflection=0.0), part)
    assert mirror == f"{shine}, {cover}"


def test_a_look_in_words_names_every_layer_and_what_is_bare():
    dark = layer_of("eyeshadow", "#5A3A2E", shape={"slot": "brow_bone"}, strength=0.8)
    light = layer_of("eyeshadow", "#FFDAB9")
    lips = Look([layer_of("lipstick", finish="gloss")])
    assert look_in_words(lips) == "lips #B4002E, glossy, opaque; eyes bare"
    assert look_in_words(Look([dark, light, layer_of("blush", finish="sheer")])) == (
        "lips bare; eyes #5A3A2E (brow bone, 80%), matte, opaque + #FFDAB9 (lid), matte, opaque; "
        "blush #B4002E, sheer, very light coverage"
    )
    assert (place_in_words(light), place_in_words(layer_of("blush"))) == ("", "")


def test_a_look_in_words_may_leave_out_what_is_bare():
    lips = Look([layer_of("lipstick", finish="gloss")], 0.5)
    assert look_in_words(lips, with_bare=False) == "lips #B4002E, glossy, opaque; all at 50%"
    assert look_in_words(Look(strength=0.5), with_bare=False) == "nothing"


@pytest.mark.parametrize(
    ("colour", "finish", "words"),
    [
        (0xB4002E, "gloss", "a colour is '#B4002E', .* got 11796526"),
        (None, "gloss", "a colour is '#B4002E', .* got None"),
        ("red", None, "a finish is a name such as 'gloss', got None"),
        ("red", 5, "a finish is a name such as 'gloss', got 5"),
    ],
)
def test_a_product_of_other_types_says_what_it_takes(colour, finish, words):
    with pytest.raises(TypeError, match=words):
        product(colour, finish)
