"""The values of --lips, --eyes and the like: colours, finishes, places, shares, shapes, `none`."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from looks import dial_values
from makeup_video.pipeline import FINISHES, KINDS, Layer, UsageError, product
from makeup_video.pipeline.look.kinds import PARTS
from makeup_video.pipeline.look.part_options import layers_of, parse_color, parse_share
from refusals import refused

COLOURS = st.tuples(*[st.integers(0, 255)] * 3)
RED = 180, 0, 46


@st.composite
def layers(draw, kind):
    """A layer of a kind and its words: the colour first, then the others in any order."""
    rgb = draw(COLOURS)
    finish = draw(st.none() | st.sampled_from(list(FINISHES)))
    percent = draw(st.none() | st.integers(0, 100))
    shape = draw(
        st.fixed_dictionaries(
            {}, optional={dial.name: dial_values(dial) for dial in kind.dials if dial.choices}
        )
    )
    words = [word for word in (finish, *shape.values()) if word is not None]
    words += [] if percent is None else [f"{percent}%"]
    text = ":".join(["#" + bytes(rgb).hex(), *draw(st.permutations(words))])
    worn = product(rgb, finish or kind.first_finish, kind.part)
    return Layer(kind.name, worn, shape, 1.0 if percent is None else percent / 100), text


@given(st.data())
@pytest.mark.parametrize("part", PARTS)
def test_words_after_the_colour_may_come_in_any_order(part, data):
    kind = PARTS[part]
    said = data.draw(st.lists(layers(kind), min_size=1, max_size=kind.most))
    text = ", ".join(text for _, text in said)
    assert layers_of(part, text) == tuple(layer for layer, _ in said)


def number(dial):
    return not (dial.choices or dial.is_colour or dial.is_map)


DIALS = [(kind.part, dial) for kind in KINDS.values() for dial in kind.dials if number(dial)]


@pytest.mark.parametrize(("part", "dial"), DIALS, ids=lambda one: getattr(one, "name", one))
def test_every_number_of_a_shape_can_be_given(part, dial):
    for value in (dial.low, dial.high, dial.default):
        (layer,) = layers_of(part, f"red:{dial.name.replace('_', ' ')}={value}:satin")
        assert layer.shape == {dial.name: value}
    with refused(UsageError, rf"--{part}: {dial.name} must be a number in .*, got 99"):
        layers_of(part, f"red:{dial.name}=99")


def test_choices_and_colours_of_a_shape_can_be_given():
    (layer,) = layers_of("eyes", "red:slot=Brow Bone")
    assert layer.shape == {"slot": "brow_bone"}
    (layer,) = layers_of("lips", "red:rim=40%:rim-color=dark red")
    assert layer.shape == {"rim": 0.4, "rim_color": "#8B0000"}


def test_a_finish_without_one_is_the_given_or_the_kinds_first():
    (first,), (given_one,), (own,) = (
        layers_of("liner", text, finish)
        for text, finish in (("red", None), ("red", "gloss"), ("red:metal", "gloss"))
    )
    red = 255, 0, 0
    assert first.product == product(red, KINDS["eyeliner"].first_finish, "liner")
    assert given_one.product == product(red, "gloss", "liner")
    assert own.product == product(red, "metallic", "liner")


@pytest.mark.parametrize("text", ["none", "None", " NONE ", "bare", "off"])
def test_none_is_no_layer(text):
    assert layers_of("eyes", text) == ()


def test_commas_within_a_colour_do_not_separate_layers():
    shadows = layers_of("eyes", "rgb(180, 0, 46):outer,hsl(0, 100%, 50%):lid")
    assert [layer.product.hex for layer in shadows] == ["#B4002E", "#FF0000"]


@pytest.mark.parametrize("text", ["B4002E,000000", "red,001", "000000,B4002E", "000,111,222"])
def test_colours_that_could_be_shares_are_colours(text):
    shadows = layers_of("eyes", text)
    assert [layer.product.hex for layer in shadows] == [
        "#" + (one if len(one) == 6 else "".join(digit * 2 for digit in one))
        for one in text.replace("red", "FF0000").split(",")
    ]
    assert all(layer.strength == 1 for layer in shadows)


@pytest.mark.parametrize(
    ("part", "text", "words"),
    [
        ("lips", "", "--lips has no colour: quote one that begins with #, as in --lips '#B4002E'"),
        ("lips", " ", "--lips has no colour: quote one"),
        ("lips", ":gloss", "--lips has no colour: quote one"),
        ("eyes", "red,", "--eyes has no colour: quote one"),
        ("lips", "gloss", "--lips begins with a colour, as in '#B4002E:gloss', got 'gloss'"),
        ("lips", "matte:red", "--lips begins with a colour"),
        ("blush", "50%", "--blush begins with a colour, as in '#B4002E:50%', got '50%'"),
        ("eyes", "outer:red", "--eyes begins with a colour, as in '#B4002E:outer'"),
        ("lips", "drakred", "--lips must be a colour such as .*, got 'drakred': did you mean darkred?"),
        ("lips", "red:", "--lips: '' is no finish"),
        ("lips", "red:mate", "--lips: 'mate' is no finish .*: did you mean matte?"),
        ("lips", "red:outer", "--lips: 'outer' is no finish"),
        ("eyes", "red:outr", r"--eyes: 'outr' is no finish \(.*\), a zone \(lid, .*mean outer?"),
        ("lips", "red:gloss:matt", "--lips gives the finish twice: 'red:gloss:matt'"),
        ("eyes", "red:80%:.5", "--eyes gives the strength twice"),
        ("eyes", "red:lid:slot=outer", "--eyes gives the zone twice: .*; leave one out"),
        ("lips", "red:50", "--lips: the strength must be a number in 0..1 or a .*: did you mean 50%?"),
        ("lips", "red:120%", "--lips: the strength must be a number in 0..1"),
        ("liner", "black:wng=.3", "--liner has no 'wng'; its shape has .*: did you mean wing?"),
        ("liner", "black:wing=", "--liner: wing must be a number in 0..1, got \"\""),
        ("liner", "black:wing=far", "--liner: wing must be a number in 0..1, got \"far\""),
        ("eyes", "red:slot=nose", "--eyes: slot must be one of lid, .*, got \"nose\""),
        ("lips", "red:rim_color=rde", "--lips: rim_color must be a colour such as '#B4002E', got"),
        ("lips", "red,matte", "--lips takes one colour, got 2: 'red,matte': did you mean 'red:matte'"),
        ("eyes", "red,matte", "put words after colons: did you mean 'red:matte'"),
        ("lips", "300,0,999", "--lips takes one colour, got 3: '300,0,999'$"),
        ("eyes", "red:map", "'map' is no finish"),
        ("lips", "180,0,46", "got 3: '180,0,46': did you mean 'rgb"),
        ("lips", "dark red matte", "put words after colons: did you mean 'dark red:matte'"),
        ("liner", "black:wing", "--liner: wing needs a value, as in wing=0.5"),
        ("lips", "red:rim color", "--lips: rim color needs a value, as in rim_color=maroon"),
        ("liner", "red,blue", "--liner takes one colour, got 2: 'red,blue'"),
        ("eyes", ",".join(["red"] * 20), "--eyes takes at most 4 layers, got 20"),
    ],
)  # fmt: skip
def test_each_mistake_is_one_line_that_names_the_option(part, text, words):
    with refused(UsageError, words):
        layers_of(part, text)


@given(COLOURS, st.booleans(), st.booleans())
def test_a_colour_is_read_back_from_its_digits(rgb, hashed, upper):
    text = ("#" if hashed else "") + bytes(rgb).hex()
    assert parse_color(text.upper() if upper else text) == rgb


@pytest.mark.parametrize(
    ("text", "share"),
    [("0.8", 0.8), ("80%", 0.8), (" 80 % ", 0.8), (".5", 0.5), ("1", 1), ("0%", 0)],
)
def test_a_share_is_a_number_or_a_percentage(text, share):
    assert parse_share(text, "--strength") == share


@pytest.mark.parametrize(
    ("text", "words"),
    [("10", "did you mean 10%"), ("1.2", r"1 \(100%\) is the most"), ("120%", r"1 \(100%\)")],
)
def test_a_percentage_is_suggested_from_ten_on(text, words):
    with refused(UsageError, f"got '{text}': {words}"):
        parse_share(text, "--strength")
