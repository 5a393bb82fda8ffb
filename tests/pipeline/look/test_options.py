"""A look from the options: properties of every combination, and one line for each mistake."""

from dataclasses import fields, replace

import pytest
from hypothesis import given
from hypothesis import strategies as st
from makeup_video.pipeline import FINISHES, GraphicsParams, Look, UsageError, product
from makeup_video.pipeline.look.look import ZONES
from makeup_video.pipeline.look.options import (
    DEFAULT_FINISH,
    Choice,
    choose_look,
    parse_color,
    parse_parts,
)
from refusals import refused

REGIONS = ("lips", "eyes")
UNIT = st.floats(0, 1)
PRODUCTS = st.builds(
    GraphicsParams,
    **{spec.name: UNIT for spec in fields(GraphicsParams) if spec.name not in ("gloss",)},
    gloss=st.floats(0, 4),
)
LOOKS = st.builds(
    Look,
    lips=st.none() | PRODUCTS, eyes=st.none() | PRODUCTS,
    strength=UNIT, zone=st.sampled_from(ZONES), intensity=UNIT,
)  # fmt: skip
COLOURS = st.tuples(*[st.integers(0, 255)] * 3)
FINISH = st.sampled_from(list(FINISHES))
PARTS = st.sampled_from(["lips", "eyes", "lips,eyes", "eyes, lips", "lips,lips"])


def spelled(rgb):
    return "#" + bytes(rgb).hex()


def colour_of(params):
    return params.red, params.green, params.blue


def rest_of(params):
    return {name: getattr(params, name) for name in FINISHES["matte"]["lips"]}


@given(COLOURS, st.booleans(), st.booleans())
def test_a_colour_is_read_back_from_its_digits(rgb, hashed, upper):
    text = spelled(rgb).removeprefix("" if hashed else "#")
    assert parse_color(text.upper() if upper else text) == rgb


@given(st.tuples(*[st.integers(0, 15)] * 3))
def test_three_digits_are_each_doubled(nibbles):
    assert parse_color("".join(f"{n:x}" for n in nibbles)) == tuple(17 * n for n in nibbles)


@pytest.mark.parametrize(
    "text",
    [
        "",
        "#",
        "12345",
        "#1234567",
        "red",
        "#GGG",
        " B02",
        "##B02",
        "0xB02",
        "B4002E\n",
        "\uff11\uff12\uff13",
    ],
)
def test_an_invalid_colour_is_refused_with_an_example(text):
    with refused(UsageError, "--color must be 3 or 6 hex digits such as '#B4002E'"):
        parse_color(text)


@pytest.mark.parametrize("text", ["", "nose", "lips,", "lips eyes", ",", "Lips"])
def test_an_unknown_part_is_refused(text):
    with refused(UsageError, "--parts must be lips, eyes or lips,eyes"):
        parse_parts(text)


@given(COLOURS, st.none() | FINISH, st.none() | PARTS)
def test_a_colour_alone_paints_the_lips_or_the_parts(rgb, finish, parts):
    look = choose_look(Choice(color=spelled(rgb), finish=finish, parts=parts))
    for name in REGIONS:
        wanted = name in (parts or "lips")
        expected = product(rgb, finish or DEFAULT_FINISH, name) if wanted else None
        assert getattr(look, name) == expected
    assert replace(look, lips=None, eyes=None) == Look()


@given(LOOKS)
def test_a_look_alone_is_painted_as_it_is(base):
    assert choose_look(Choice(base=base)) == base


@given(LOOKS, COLOURS, st.none() | FINISH)
def test_a_colour_and_a_finish_override_those_of_a_look(base, rgb, finish):
    look = choose_look(Choice(base=base, color=spelled(rgb), finish=finish))
    for name in REGIONS:
        old, new = getattr(base, name), getattr(look, name)
        if old is not None:
            assert colour_of(new) == rgb
            assert rest_of(new) == (rest_of(old) if finish is None else FINISHES[finish][name])
        elif base.lips or base.eyes:
            assert new is None
        else:
            assert (new is None) == (name == "eyes")  # a colour on top of `none`: the lips


@given(LOOKS.filter(lambda look: look.lips or look.eyes), FINISH)
def test_a_finish_keeps_the_colours_of_the_look(base, finish):
    look = choose_look(Choice(base=base, finish=finish))
    for name in REGIONS:
        old, new = getattr(base, name), getattr(look, name)
        assert new == (None if old is None else product(colour_of(old), finish, name))


@given(LOOKS, PARTS, st.none() | COLOURS)
def test_parts_are_painted_and_no_others(base, parts, rgb):
    choice = Choice(base=base, parts=parts, color=None if rgb is None else spelled(rgb))
    missing = [name for name in REGIONS if name in parts and getattr(base, name) is None]
    if missing and rgb is None:
        with refused(UsageError, f"names the {missing[0]}.* leaves bare: add --color"):
            choose_look(choice)
        return
    look = choose_look(choice)
    for name in REGIONS:
        assert (getattr(look, name) is not None) == (name in parts)
        if name in missing:
            assert getattr(look, name) == product(rgb, DEFAULT_FINISH, name)


@given(LOOKS, st.none() | UNIT, st.none() | UNIT, st.none() | st.sampled_from(ZONES))
def test_dials_that_are_given_replace_those_of_the_look(base, strength, intensity, zone):
    base = replace(base, eyes=product((1, 2, 3), "matte", "eyes"))
    look = choose_look(Choice(base=base, strength=strength, intensity=intensity, zone=zone))
    assert look.strength == (base.strength if strength is None else strength)
    assert look.intensity == (base.intensity if intensity is None else intensity)
    assert look.zone == (base.zone if zone is None else zone)
    assert (look.lips, look.eyes) == (base.lips, base.eyes)


@pytest.mark.parametrize(
    ("choice", "words"),
    [
        ({}, "no look given: add --look FILE.json, --color '#B4002E', --ref PHOTO, or --look none"),
        ({"parts": "lips"}, "no look given"),
        ({"strength": 0.5}, "no look given"),
        ({"finish": "gloss"}, "--finish gloss needs a colour: add --color"),
        ({"finish": "gloss", "parts": "lips"}, "--finish gloss needs a colour"),
        ({"base": Look(), "finish": "gloss"}, "--finish gloss needs a colour"),
        ({"color": "B02", "finish": "shiny"}, "--finish must be one of matte, .* got 'shiny'"),
        ({"color": "B02", "zone": "lid"}, "--zone is for eye-shadow, and no eyes are painted"),
        ({"color": "B02", "intensity": 1.0}, "--intensity is for eye-shadow"),
        ({"color": "B02", "parts": "eyes", "zone": "brow"}, "--zone must be one of lid, crease"),
        ({"color": "B02", "parts": "eyes", "intensity": 1.5}, "--intensity must be a number in"),
        ({"color": "B02", "strength": -1.0}, "--strength must be a number in 0..1, got -1.0"),
        ({"color": "B02", "strength": float("nan")}, "--strength must be a number in 0..1"),
    ],
)
def test_each_mistake_is_one_line_that_names_the_option(choice, words):
    with refused(UsageError, words):
        choose_look(Choice(**choice))


def test_look_none_paints_nothing():
    assert choose_look(Choice(base=Look())).is_bare
