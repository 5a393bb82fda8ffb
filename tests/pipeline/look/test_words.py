"""Words for colours, finishes, parts and places: each means one thing, whatever its spelling."""

import re

import pytest
from hypothesis import given
from hypothesis import strategies as st
from makeup_video.pipeline import FINISHES, KINDS, UsageError
from makeup_video.pipeline.look import words
from makeup_video.pipeline.look.kinds import PARTS
from makeup_video.pipeline.look.part_options import parse_color
from PIL import ImageColor
from refusals import refused

SHADOW = KINDS["eyeshadow"]


@given(st.tuples(*[st.integers(0, 15)] * 3))
def test_three_digits_are_each_doubled(nibbles):
    assert words.rgb_of("".join(f"{n:x}" for n in nibbles)) == tuple(17 * n for n in nibbles)


@pytest.mark.parametrize("name", sorted(ImageColor.colormap))
def test_every_colour_of_css_is_known(name):
    assert words.rgb_of(name.title()) == ImageColor.getrgb(name)


def test_shades_of_lipstick_are_colours_that_css_lacks():
    assert not set(words.SHADES) & set(ImageColor.colormap)
    for name, code in words.SHADES.items():
        assert name == words.plain(name)
        assert parse_color(f" {name.title()} ") == parse_color(code)
    with refused(UsageError, "got 'wien': did you mean wine?"):
        parse_color("wien")


@pytest.mark.parametrize(
    ("text", "rgb"),
    [("red", (255, 0, 0)), ("Dark Red", (139, 0, 0)), ("rebecca-purple", (102, 51, 153)),
     ("rgb(180, 0, 46)", (180, 0, 46)), ("RGB(100%,0%,0%)", (255, 0, 0)),
     ("hsl(120, 100%, 50%)", (0, 255, 0)), (" B02 ", (187, 0, 34))],
)  # fmt: skip
def test_colours_have_the_spellings_of_css(text, rgb):
    assert parse_color(text) == rgb


@pytest.mark.parametrize(
    "text",
    ["#", "12345", "#1234567", "#FFFF", "#GGG", "##B02", "0xB02", "\uff11\uff12\uff13", "rgb(300,0,0)",
     "rgba(1,2,3,4)", "hsl(0, 100%, 900%)", "rgb(1,2)", "crimsn!", "x" * 200, "hsl(1" + "0" * 80 + ",1%,1%)"],
)  # fmt: skip
def test_an_invalid_colour_is_refused_with_examples(text):
    if words.rgb_of(text) is None:
        with refused(UsageError, "--color must be a colour such as '#B4002E', B4002E, darkred or"):
            parse_color(text)
    else:
        assert max(words.rgb_of(text)) <= 255 and text.startswith("hsl(1")


def test_every_finish_has_words_and_no_word_means_two():
    assert list(words.FINISH_WORDS) == list(FINISHES)
    names = [words.plain(word) for word in words.finish_names()]
    assert len(names) == len(set(names))
    for finish, others in words.FINISH_WORDS.items():
        assert {words.finish_of(word.upper()) for word in (finish, *others)} == {finish}


def test_every_part_has_words_and_no_word_means_two():
    for part, kind in PARTS.items():
        known = (part, kind.name, kind.title, kind.product, *kind.words)
        assert {words.part_of(word) for word in known} == {part}


def test_no_word_is_both_a_finish_and_a_place():
    for word in words.finish_names():
        assert all(words.slot_named(word, kind) is None for kind in KINDS.values())


@pytest.mark.parametrize(
    ("find", "word", "meaning"),
    [
        (words.finish_of, "Glossy", "gloss"), (words.finish_of, "shiny", "gloss"),
        (words.finish_of, "matt", "matte"), (words.finish_of, "velvet", "matte"),
        (words.finish_of, "natural", "satin"), (words.finish_of, "metal", "metallic"),
        (words.finish_of, "GLITTER", "shimmer"), (words.finish_of, "dull", None),
        (words.part_of, "lipstick", "lips"), (words.part_of, "Eye-Shadow", "eyes"),
        (words.part_of, "lids", "eyes"), (words.part_of, "eyeliner", "liner"),
        (words.part_of, "rouge", "blush"), (words.part_of, "cheeks", "blush"),
        (words.part_of, "nose", None),
        (lambda word: words.slot_named(word, SHADOW), "outer corner", "outer"),
        (lambda word: words.slot_named(word, KINDS["lipstick"]), "lid", None),
    ],
)  # fmt: skip
def test_usual_words_are_understood(find, word, meaning):
    assert find(word) == meaning


@pytest.mark.parametrize(
    ("text", "number"),
    [("80%", 0.8), ("-30", -30), ("+.5", 0.5), ("1.", 1), ("", None), ("%", None), ("nan", None),
     ("inf", None), ("1e3", None), ("1_0", None), ("\u0661", None), ("8 0", None), ("9" * 400, None)],
)  # fmt: skip
def test_numbers_are_plain_ones(text, number):
    assert words.number_of(text) == number


@given(st.text(max_size=30))
def test_no_text_breaks_a_look_up(text):
    assert words.rgb_of(text) is None or len(words.rgb_of(text)) == 3
    assert words.finish_of(text) in (None, *FINISHES) and words.part_of(text) in (None, *PARTS)
    assert re.fullmatch(r"(: did you mean .*\?)?", words.did_you_mean(text, ["matte", "gloss"]))
