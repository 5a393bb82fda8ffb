"""Looks that come with the package: they read, name themselves, and give way to files."""

import json
import re
from pathlib import Path

import pytest
from makeup_video.pipeline import KINDS, Look, LookError, ready_look, ready_looks
from makeup_video.pipeline.look.ready import is_file, load_look
from refusals import refused

DOCS = Path(__file__).parents[3] / "docs"
NAMES = [one.name for one in ready_looks()]
PROMISED = [
    "natural", "smoky-brown", "smoky-black", "cat-eye", "sunset", "berry", "k-beauty", "glam",
    "festival-blue", "nude-matte", "red-lip-classic", "clown",
]  # fmt: skip


def test_the_promised_looks_are_there_in_order():
    assert set(PROMISED) <= set(NAMES) and sorted(NAMES) == NAMES


@pytest.mark.parametrize("one", ready_looks(), ids=lambda one: one.name)
def test_a_ready_look_is_whole(one):
    assert set(json.loads(one.path.read_text())) == {"words", "look"}
    assert 10 < len(one.words) < 90 and one.words.isprintable() and one.words[-1] != "."
    assert set(one.look.kinds) >= {"lipstick", "eyeshadow", "eyeliner", "blush"}
    assert one.look.strength == 1 and len(one.look.painted) == len(one.look.layers)
    assert Look.from_dict(one.look.to_dict()) == one.look


def test_no_two_ready_looks_are_the_same():
    assert len({one.look for one in ready_looks()}) == len({one.words for one in ready_looks()})
    assert len({one.look for one in ready_looks()}) == len(NAMES)


def test_ready_looks_show_what_a_look_can_be():
    layers = [layer for one in ready_looks() for layer in one.look.layers]
    slots = {layer.whole_shape.get("slot") for layer in layers}
    assert slots >= {"lid", "crease", "brow_bone", "outer", "under", "full"}
    given = {name for layer in layers for name in layer.shape}
    assert given >= {
        "gradient",
        "rim",
        "rim_color",
        "wing",
        "wing_angle",
        "lower",
        "across",
        "lift",
    }
    assert max(len(one.look.of("eyeshadow")) for one in ready_looks()) == KINDS["eyeshadow"].most


def test_the_manual_lists_the_looks_and_its_examples_read():
    page, table = ((DOCS / name).read_text(encoding="utf-8") for name in ("looks.md", "ready.md"))
    rows = re.findall(r"^\| `([\w-]+)` \| (.*) \|$", table, re.MULTILINE)
    listed = [(one.name, one.words) for one in ready_looks()]
    assert rows == listed
    sentence = page.split("Fifteen looks are built in:")[1].split(".\n")[0]
    assert re.findall(r"`([\w-]+)`", sentence) == [name for name, _ in listed]
    assert len(listed) == 15
    examples = re.findall(r"```json\n(.*?)```", page, re.DOTALL)
    kinds = [Look.from_dict(json.loads(text)).kinds for text in examples]
    assert kinds == [("lipstick", "eyeshadow"), ("lipstick",)]


@pytest.mark.parametrize("name", ["cat-eye", "Cat Eye", "CAT_EYE", "cateye"])
def test_a_ready_look_is_found_however_it_is_spelled(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert load_look(name) == ready_look("cat-eye").look and not is_file(name)


@pytest.mark.parametrize("name", ["none", "Bare", "off"])
def test_a_bare_look_has_several_names(name, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert load_look(name) == Look() and not is_file(name)


def test_a_file_of_the_same_name_comes_first(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Look(strength=0.5).save("cat-eye")
    assert load_look("cat-eye") == Look(strength=0.5) and is_file("cat-eye")
    Look().save("none")
    assert load_look("None").is_bare and not is_file("none")


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("caty-eye", "there is no look file and no ready look 'caty-eye': did you mean cat-eye? Ready"),
        ("xyz", "there is no look file and no ready look 'xyz'; ready looks are berry, cat-eye,"),
        ("look.json", "look.json does not exist: give a look file, or the name of a ready look (`makeup-video looks`)"),
        ("", "the name of the look file is empty: give one"),
    ],
)  # fmt: skip
def test_an_unknown_name_lists_the_ready_looks(name, words, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    with pytest.raises(LookError) as caught:
        load_look(name)
    assert words in str(caught.value) and "\n" not in str(caught.value)
    with pytest.raises(LookError, match="there is no ready look"):
        ready_look(name)


def test_a_folder_does_not_hide_a_ready_look(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "glam").mkdir()
    assert load_look("glam") == ready_look("glam").look and not is_file("glam")
    (tmp_path / "mine").mkdir()
    with refused(LookError, "mine is a folder: give a look file in it, or --looks mine where"):
        load_look("mine")


def test_a_photo_in_place_of_a_look_is_said_to_be_one(tmp_path):
    photo = tmp_path / "her.JPG"
    photo.write_bytes(b"\xff\xd8")
    with refused(LookError, f"{photo} is a photo and no look file: use --ref {photo}"):
        load_look(str(photo))


def test_the_beginning_of_one_name_alone_is_understood():
    with refused(LookError, "there is no ready look 'cat': did you mean cat-eye"):
        ready_look("cat")
    with refused(LookError, "there is no ready look 'smo'; ready looks are berry"):
        ready_look("smo")


@pytest.mark.parametrize("name", [5, None, b"cat-eye"])
def test_a_name_that_is_no_text_is_refused(name):
    with pytest.raises(
        TypeError, match="a ready look is given by its name, such as 'cat-eye', got"
    ):
        ready_look(name)
