"""Hostile look files: each is refused at once in one short line, without filling memory."""

import json
import os

import pytest
from hypothesis import given
from hypothesis import strategies as st
from looks import layer_of
from makeup_video.pipeline import Look, LookError, OutputError
from makeup_video.pipeline.look.strict_json import whole_number
from makeup_video.web.messages import read_message

LIPS = '"red": 180, "green": 0, "blue": 46, "opacity": 0.8, "gloss_roughness": 0.4, "reflection": 0'
MANY = "9" * 5000  # Python reads and writes no whole number of more than 4300 digits
LONG = "k" * 100_000
GLOSS = "layers[0].product.gloss must be a finite number of at least 0, got"
OLD = '"version": 1, "lips": null, "eyes": null'


def text(gloss="0.6", more="", version="2", layer=""):
    product = f'{{{LIPS}, "gloss": {gloss}}}'
    return (
        f'{{"version": {version}, "layers": [{{"kind": "eyeshadow", "product": {product}{layer}}}]'
        f"{more}}}"
    )


ODD = [
    (text(MANY), f"{GLOSS} Infinity"),
    (text("-" + MANY), f"{GLOSS} -Infinity"),
    (text("1e400"), f"{GLOSS} Infinity"),
    (text("9" * 4000), f"{GLOSS} Infinity"),
    (text(version=MANY), "version must be 1 or 2, got Infinity"),
    (text(more=f', "strength": {MANY}'), "strength must be a number in 0..1, got Infinity"),
    (text(layer=f', "shape": {{"slot": {MANY}}}'), "layers[0].shape.slot must be one of lid, crease"),
    (text(layer=f', "shape": {{"low": {MANY}}}'), "layers[0].shape.low must be a number in -1.3..2"),
    (text(layer=f', "shape": {{"{LONG}": 1}}'), "layers[0].shape has an unknown key 'kkkk"),
    (text(layer=f', "kind": "{LONG}"'), "'kind' is given twice: keep one"),
    (text(more=f', "{LONG}": 1'), "unknown key 'kkkk"),
    (text(more=f', "{LONG}": 1, "{LONG}": 2'), "kkk... is given twice: keep one"),
    (text(layer=f', "shape": {{"slot": "{LONG}"}}'), 'got "kkkk'),
    (text(more=r', "a\ud800b": 1'), r"unknown key 'a\ud800b'"),
    (text(more=r', "a\u0000\n\u2028b": 1'), r"unknown key 'a\x00\n\u2028b'"),
    (text(more=r', "\n": 1, "\n": 2'), r"'\n' is given twice"),
    (text(layer=r', "shape": {"slot": "\ud800\u0000"}'), r'got "\ud800\u0000"'),
    (text(layer=', "shape": {"slot": "grün 日本"}'), 'got "grün 日本"'),
    (text("[" * 500 + "]" * 500), f"{GLOSS} [[["),
    (text('{"a": ' * 500 + "1" + "}" * 500), GLOSS),
    (f'{{{OLD}, "zone": {MANY}}}', "zone must be one of lid, crease, full, outer, got Infinity"),
    (f'{{{OLD}, "intensity": {MANY}}}', "intensity must be a number in 0..1, got Infinity"),
]  # fmt: skip


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
        ({"version": 10**5000}, "version must be 1 or 2, got something of type int"),
        ({"version": 2, "layers": [{"kind": 10**5000}]}, "product is missing"),
        ({"version": 2, "layers": [{"kind": 10**5000, "product": 1}]}, "kind must be one of"),
        ({"version": 2, "layers": [], "strength": 10**5000}, "strength must be"),
        ({"version": 2, "layers": [], 10**5000: 1}, "unknown key something of type"),
        ({"version": 2, "layers": {(1, 2): {(3,): 4}}}, "layers must be a list, got something of"),
        ({"version": {(1, 2): 3}}, "got something of type dict"),
        ({"version": 1, "lips": None, "eyes": None, "zone": 10**5000}, "zone must be one of"),
        ({"version": 1, "lips": {"red": -(10**5000)}}, "is missing"),
    ],
)
def test_values_too_odd_to_print_are_refused_by_name(values, words):
    with pytest.raises(LookError, match=words) as caught:
        Look.from_dict(values)
    assert len(str(caught.value)) < 250


def test_a_list_that_holds_itself_is_refused():
    nested = []
    nested.append(nested)
    with pytest.raises(
        LookError, match=r"layers\[0\] must be an object, got something of type list"
    ):
        Look.from_dict({"version": 2, "layers": nested})


@given(st.integers())
def test_a_whole_number_is_read_exactly(number):
    assert whole_number(str(number)) == number


@pytest.mark.parametrize(
    ("content", "match"),
    [
        ("{", "not JSON at line 1"),
        ('{"version": 2,\n "layers" []}', "line 2"),
        ('{"version": 2, "version": 2, "layers": []}', "'version' is given twice"),
        ('{"version": 2, "layers": [], "strength": NaN}', "strength must be a number in 0..1, got NaN"),
        ("[" * 100000, "nests too deep"),
        ("", "not JSON"),
    ],
)  # fmt: skip
def test_a_file_that_is_no_look_is_refused_in_one_line(tmp_path, content, match):
    path = tmp_path / "look.json"
    path.write_text(content)
    with pytest.raises(LookError, match=match) as caught:
        Look.load(path)
    assert str(caught.value).startswith(str(path)) and "\n" not in str(caught.value)


@pytest.mark.parametrize("content", [None, b"\xff\xfe\x00"])
def test_a_file_that_cannot_be_read_is_refused(tmp_path, content):
    path = tmp_path / "look.json"
    if content is not None:
        path.write_bytes(content)
    with pytest.raises(LookError, match="cannot be read"):
        Look.load(path)


@pytest.mark.parametrize(
    ("name", "words"),
    [("pipe", "it is no ordinary file"), ("/dev/zero", "it is no ordinary file"),
     (".", "Is a directory"), ("hole.json", "it has more than 1 MB"), ("a\0b", "no file has such")],
)  # fmt: skip
def test_anything_but_a_small_file_is_refused_at_once(tmp_path, name, words):
    os.mkfifo(tmp_path / "pipe")
    with (tmp_path / "hole.json").open("wb") as file:
        file.truncate(3_000_000_000)
    with pytest.raises(LookError, match=f"cannot be read as a look file: {words}"):
        Look.load(tmp_path / name)


def test_byte_order_mark_and_white_space_are_no_fault(tmp_path):
    look = Look([layer_of("blush")])
    written = json.dumps(look.to_dict()).encode()
    (tmp_path / "look.json").write_bytes(b"\xef\xbb\xbf" + written + b" " * 900_000)
    assert Look.load(tmp_path / "look.json") == look


def test_a_name_that_is_empty_or_a_circle_is_refused(tmp_path):
    (tmp_path / "a").symlink_to("b")
    (tmp_path / "b").symlink_to("a")
    with pytest.raises(OutputError, match="a cannot be written: Too many levels"):
        Look().save(tmp_path / "a")
    assert (tmp_path / "a").is_symlink()
    for use in (Look.load, Look().save):
        with pytest.raises((LookError, OutputError), match="name of the look file is empty"):
            use("")
