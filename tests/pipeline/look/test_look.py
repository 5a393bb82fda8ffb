"""Looks: reading and writing look files, checking every value, bare looks."""

import json
import math
from dataclasses import fields

import pytest
from hypothesis import given
from hypothesis import strategies as st
from makeup_video.pipeline import GraphicsParams, Look, LookError
from makeup_video.pipeline.look.look import ZONES

SPECS = {spec.name: spec.metadata for spec in fields(GraphicsParams)}
SEVEN = ("red", "green", "blue", "opacity", "gloss", "gloss_roughness", "reflection")
LIPS = {"red": 180, "green": 0, "blue": 46, "opacity": 0.8, "gloss": 0.6, "gloss_roughness": 0.4,
        "reflection": 0.2}  # fmt: skip
SHORT = {"version": 1, "lips": LIPS, "eyes": None}


def numbers(name):
    low, high = SPECS[name]["low"], SPECS[name]["high"]
    return st.floats(low, high) | st.integers(math.ceil(low), math.floor(min(high, 10**6)))


def regions():
    required = {name: numbers(name) for name in SEVEN}
    optional = {name: numbers(name) for name in SPECS if name not in SEVEN}
    return st.fixed_dictionaries(required, optional=optional)


LOOKS = st.fixed_dictionaries(
    {"version": st.just(1), "lips": st.none() | regions(), "eyes": st.none() | regions()},
    optional={
        "strength": st.floats(0, 1),
        "zone": st.sampled_from(ZONES),
        "intensity": st.floats(0, 1),
    },
)


def test_the_papers_seven_parameters_come_first_of_seventeen():
    assert len(SPECS) == 17
    assert list(SPECS)[:7] == list(SEVEN)


@given(LOOKS)
def test_every_look_in_range_survives_the_file(tmp_path_factory, values):
    look = Look.from_dict(values)
    path = tmp_path_factory.mktemp("look") / "look.json"
    look.save(path)
    assert Look.load(path) == look
    assert Look.from_dict(look.to_dict()) == look


@given(name=st.sampled_from(sorted(SPECS)), value=st.floats() | st.integers())
def test_numbers_out_of_range_are_refused_by_name_and_range(name, value):
    low, high = SPECS[name]["low"], SPECS[name]["high"]
    values = {**SHORT, "lips": {**LIPS, name: value}}
    if low <= value <= high:
        assert getattr(Look.from_dict(values).lips, name) == value
    else:
        with pytest.raises(LookError, match=rf"lips\.{name} must be .*{low:g}"):
            Look.from_dict(values)


@pytest.mark.parametrize("name", [*SPECS, "strength", "intensity"])
@pytest.mark.parametrize(
    "value", ["1", None, True, [1], {}, math.nan, math.inf, -math.inf, 10**400]
)
def test_anything_but_a_finite_number_is_refused_by_name(name, value):
    values = (
        {**SHORT, name: value} if name not in SPECS else {**SHORT, "lips": {**LIPS, name: value}}
    )
    with pytest.raises(LookError, match=name) as caught:
        Look.from_dict(values)
    assert "\n" not in str(caught.value) and len(str(caught.value)) < 200


@pytest.mark.parametrize("name", SEVEN)
def test_a_missing_parameter_is_named_with_its_range(name):
    lips = {key: value for key, value in LIPS.items() if key != name}
    with pytest.raises(LookError, match=rf"lips\.{name} is missing: give a"):
        Look.from_dict({**SHORT, "lips": lips})


@pytest.mark.parametrize(
    ("values", "match"),
    [
        ({**SHORT, "colour": 1}, "unknown key 'colour'"),
        ({**SHORT, "lips": {**LIPS, "glos": 1}}, "unknown key 'glos'"),
        ({**SHORT, "version": 2}, "version must be 1, got 2"),
        ({**SHORT, "version": True}, "version must be 1"),
        ({"lips": None, "eyes": None}, "version must be 1, got null"),
        ({"version": 1, "eyes": None}, "lips is missing"),
        ({"version": 1, "lips": None}, "eyes is missing"),
        ({**SHORT, "lips": [1]}, "lips must be an object or null"),
        ({**SHORT, "zone": "cheek"}, "zone must be one of lid, crease, full, outer"),
        ({**SHORT, "zone": []}, "zone must be one of"),
        ([], "must be a JSON object"),
        (None, "must be a JSON object"),
    ],
)
def test_other_mistakes_are_named(values, match):
    with pytest.raises(LookError, match=match) as caught:
        Look.from_dict(values)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("text", "match"),
    [
        ("{", "not JSON at line 1"),
        ('{"version": 1,\n "lips" null}', "line 2"),
        ('{"version": 1, "version": 1, "lips": null, "eyes": null}', "'version' is given twice"),
        ('{"version": 1, "lips": null, "eyes": null, "strength": NaN}', "strength"),
        ("[" * 100000, "nests too deep"),
        ("", "not JSON"),
    ],
)
def test_a_file_that_is_no_look_is_refused_in_one_line(tmp_path, text, match):
    path = tmp_path / "look.json"
    path.write_text(text)
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


def test_a_byte_order_mark_is_no_fault(tmp_path):
    path = tmp_path / "look.json"
    path.write_bytes(b"\xef\xbb\xbf" + json.dumps(SHORT).encode())
    assert Look.load(path) == Look.from_dict(SHORT)


def test_the_example_of_the_documentation_reads():
    import makeup_video.pipeline.look.look as module

    text = module.__doc__.split("\n\n")[1]
    assert Look.from_dict(json.loads(text)).lips.red == 180


def test_bare_means_that_nothing_will_be_painted():
    lips = GraphicsParams(**LIPS)
    assert Look().is_bare and Look(lips=lips, strength=0).is_bare
    assert Look(eyes=lips, intensity=0).is_bare
    assert not Look(lips=lips, intensity=0).is_bare
    assert not Look(eyes=lips).is_bare
