"""Templates of output names: known fields, safe names, one line for each mistake."""

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from makeup_video.pipeline import UsageError
from makeup_video.pipeline.files.template import FIELDS, Origin, Template, field_between, in_name

VALUES = {"name": "talk", "look": "cat-eye", "brand": "A/B", "shade": "No. 5?", "ext": "mp4",
          "folder": "clips", "product": "Velvet"}  # fmt: skip
TALK = Origin(VALUES, "clips/talk.mp4", "shades.csv, line 3")


@pytest.mark.parametrize(
    ("text", "path"),
    [
        ("out/{name}-{look}.mp4", "out/talk-cat-eye.mp4"),
        ("{brand}/{product}/{shade}.{ext}", "A-B/Velvet/No. 5-.mp4"),
        ("a{{b}}/{folder}.mkv", "a{b}/clips.mkv"),
        ("plain.mp4", "plain.mp4"),
    ],
)
def test_fields_are_filled_in(text, path):
    assert Template(text).fill(TALK) == Path(path)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("{nmae}.mp4", "has {nmae}: the fields are {name}, "),
        ("{name!r}.mp4", "has {name!r}: "),
        ("{name:>9}.mp4", "has {name:>9}: "),
        ("{}.mp4", "has {}: "),
        ("{name.mp4", "a brace without its partner"),
        ("name}.mp4", "a brace without its partner"),
        ("", "is empty"),
    ],
)
def test_what_is_no_field_is_refused(text, message):
    with pytest.raises(UsageError) as caught:
        Template(text)
    assert message in str(caught.value) and "\n" not in str(caught.value)


@pytest.mark.parametrize("field", FIELDS)
def test_a_field_without_a_value_is_named_and_whose_it_is(field):
    """Also where names of files would spell it otherwise, as "Maison É/" of a catalogue."""
    template = Template(f"out/{{{field}}}.mp4")
    whose = TALK.source if field in ("name", "folder", "ext") else TALK.look
    rest = {name: value for name, value in VALUES.items() if name != field}
    for values in (rest, rest | {field: " .. "}):
        with pytest.raises(UsageError) as caught:
            template.fill(TALK._replace(values=values))
        assert f"{{{field}}}, {FIELDS[field]}, and {whose} has none: choose" in str(caught.value)
    with pytest.raises(UsageError, match=r"and the look has none|and clips/talk\.mp4 has none"):
        template.fill(Origin({}, TALK.source, ""))


def test_the_field_to_add_is_the_first_that_differs():
    def between(**changed):
        return field_between(TALK, TALK._replace(values=VALUES | changed))

    assert between(folder="more", ext="mov") == "folder"
    assert between(look="nude", shade="3") == "look"
    assert between() is between(folder="CLIPS") is between(folder="") is None


@given(st.text(min_size=1))
def test_no_value_leads_to_another_folder(text):
    name = in_name(text)
    assert not set(name) & set('/\\:*?"<>|\0\n') and name not in (".", "..")
    assert in_name(name) == name
    if name:
        path = Template("out/{name}.mp4").fill(Origin({"name": text}, "in.mp4", ""))
        assert path.parent == Path("out")


@given(st.lists(st.sampled_from([*FIELDS, "text"]), min_size=1), st.integers(0, 3))
def test_the_fixed_folder_is_above_every_output(words, folders):
    parts = ["fixed"] * folders + ["-".join(f"{{{w}}}" if w in FIELDS else w for w in words)]
    template = Template("/".join(parts) + ".mp4")
    filled = template.fill(TALK)
    assert template.folder == Path("/".join(parts[:-1]) or ".") == filled.parent


def test_the_fixed_folder_ends_before_the_first_field():
    assert Template("a/b{look}/c/{name}.mp4").folder == Path("a")
    assert Template("x}}/y{{1}}/{name}.mp4").folder == Path("x}/y{1}")
