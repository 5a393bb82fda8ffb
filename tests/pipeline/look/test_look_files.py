"""Hostile look files: each is refused at once in one short line, without filling memory."""

import json
import os

import pytest
from hypothesis import given
from hypothesis import strategies as st
from makeup_video.pipeline import Look, LookError
from makeup_video.pipeline.look.look import whole_number
from makeup_video.web.messages import read_message

LIPS = '"red": 180, "green": 0, "blue": 46, "opacity": 0.8, "gloss_roughness": 0.4, "reflection": 0'
MANY = "9" * 5000  # Python reads and writes no whole number of more than 4300 digits
LONG = "k" * 100_000


def text(gloss="0.6", more="", version="1"):
    return f'{{"version": {version}, "lips": {{{LIPS}, "gloss": {gloss}}}, "eyes": null{more}}}'


ODD = [
    (text(MANY), "lips.gloss must be a finite number of at least 0, got Infinity"),
    (text("-" + MANY), "lips.gloss must be a finite number of at least 0, got -Infinity"),
    (text("1e400"), "lips.gloss must be a finite number of at least 0, got Infinity"),
    (text("9" * 4000), "lips.gloss must be a finite number of at least 0, got Infinity"),
    (text(version=MANY), "version must be 1, got Infinity"),
    (text(more=f', "strength": {MANY}'), "strength must be a number in 0..1, got Infinity"),
    (text(more=f', "zone": {MANY}'), "zone must be one of lid, crease, full, outer, got Infinity"),
    (text(more=f', "{LONG}": 1'), "unknown key 'kkkk"),
    (text(more=f', "{LONG}": 1, "{LONG}": 2'), "kkk... is given twice: keep one"),
    (text(more=f', "zone": "{LONG}"'), 'got "kkkk'),
    (text(more=r', "a\ud800b": 1'), r"unknown key 'a\ud800b'"),
    (text(more=r', "a\u0000\n\u2028b": 1'), r"unknown key 'a\x00\n\u2028b'"),
    (text(more=r', "\n": 1, "\n": 2'), r"'\n' is given twice"),
    (text(more=r', "zone": "\ud800\u0000"'), r'got "\ud800\u0000"'),
    (text("[" * 500 + "]" * 500), "lips.gloss must be a finite number of at least 0, got [[["),
    (text('{"a": ' * 500 + "1" + "}" * 500), "lips.gloss must be a finite number"),
]


@pytest.mark.parametrize(("content", "words"), ODD)
def test_an_odd_file_is_one_short_line(tmp_path, content, words):
    path = tmp_path / "look.json"
    path.write_text(content)
    with pytest.raises(LookError) as caught:
        Look.load(path)
    message = str(caught.value).removeprefix(str(path))
    assert words in message and message.isprintable() and len(message) < 250


@pytest.mark.parametrize(("content", "words"), [pair for pair in ODD if "twice" not in pair[1]])
def test_an_odd_look_from_a_page_is_the_same_line(content, words):
    with pytest.raises(LookError) as caught:
        _ = read_message(f'{{"type": "look", "look": {content}}}').look
    message = str(caught.value)
    assert words in message and message.isprintable() and len(message) < 250


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({"version": 10**5000}, "version must be 1, got something of type int"),
        ({"version": 1, "lips": {"red": -(10**5000)}}, "is missing"),
        ({"version": 1, "lips": None, "eyes": None, "strength": 10**5000}, "strength must be"),
        ({"version": 1, "lips": None, "eyes": None, 10**5000: 1}, "unknown key something of type"),
        ({"version": 1, "lips": {(1, 2): {(3,): 4}}}, "unknown key|eyes is missing"),
        ({"version": {(1, 2): 3}}, "got something of type dict"),
        ({"version": 1, "lips": None, "eyes": None, "zone": 10**5000}, "zone must be one of"),
    ],
)
def test_values_too_odd_to_print_are_refused_by_name(values, words):
    with pytest.raises(LookError, match=words) as caught:
        Look.from_dict(values)
    assert len(str(caught.value)) < 250


def test_a_list_that_holds_itself_is_refused():
    nested = []
    nested.append(nested)
    with pytest.raises(LookError, match="lips must be an object or null, got something of type"):
        Look.from_dict({"version": 1, "lips": nested, "eyes": None})


@given(st.integers())
def test_a_whole_number_is_read_exactly(number):
    assert whole_number(str(number)) == number


@pytest.mark.parametrize(
    ("name", "words"),
    [("pipe", "it is no ordinary file"), ("/dev/zero", "it is no ordinary file"),
     (".", "Is a directory"), ("hole.json", "it has more than 1 MB"), ("a\0b", "no file has such")],
)  # fmt: skip
def test_anything_but_a_small_file_is_refused_at_once(tmp_path, name, words):
    os.mkfifo(tmp_path / "pipe")
    with (tmp_path / "hole.json").open("wb") as file:
        file.truncate(3_000_000_000)
    with pytest.raises(LookError, match=f"a look file cannot be read: {words}"):
        Look.load(tmp_path / name)


def test_a_look_may_be_followed_by_much_white_space(tmp_path):
    (tmp_path / "look.json").write_text(json.dumps(Look().to_dict()) + " " * 900_000)
    assert Look.load(tmp_path / "look.json") == Look()
