"""Looks: reading and writing look files of version 2, checking every value, bare looks."""

import copy
import json
import math
import os
import pickle
import re
import stat
from dataclasses import asdict
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from looks import SEVEN, SPECS, layer_of, look_objects
from makeup_video.pipeline import (
    KINDS,
    GraphicsParams,
    Layer,
    Look,
    LookError,
    OutputError,
    product,
)
from makeup_video.pipeline.look.kinds import PAINTED

LIPS = {"red": 180, "green": 0, "blue": 46, "opacity": 0.8, "gloss": 0.6, "gloss_roughness": 0.4,
        "reflection": 0.2}  # fmt: skip
LAYER = {"kind": "lipstick", "product": LIPS}
SHORT = {"version": 2, "layers": [LAYER]}
WING = {"kind": "eyeliner", "product": LIPS, "shape": {"wing": 0.3}}


def with_layer(**changes):
    return {**SHORT, "layers": [LAYER, {**WING, **changes}]}


def test_the_papers_seven_parameters_come_first_of_seventeen():
    assert len(SPECS) == 17
    assert list(SPECS)[:7] == list(SEVEN)


@given(look_objects())
def test_every_look_in_range_survives_the_file(tmp_path_factory, values):
    look = Look.from_dict(values)
    path = tmp_path_factory.mktemp("look") / "look.json"
    look.save(path)
    assert Look.load(path) == look
    assert Look.from_dict(look.to_dict()) == look
    assert hash(Look.load(path)) == hash(look)


def test_numbers_of_numpy_become_numbers_of_python(tmp_path):
    half = np.float32(0.5)
    layer = Layer("eyeliner", GraphicsParams(**{**LIPS, "gloss": half}), {"wing": half}, half)
    look = Look([layer], half)
    look.save(tmp_path / "look.json")
    assert Look.load(tmp_path / "look.json") == look
    values = look.strength, layer.strength, layer.shape["wing"], layer.product.gloss
    assert [type(value) for value in values] == [float] * 4


def test_a_single_layer_is_not_a_list():
    layer = Layer("lipstick", product("#B4002E", "gloss"))
    for make in (Look, lambda one: Look().with_kind("lipstick", one)):
        with pytest.raises(TypeError, match=r"list of Layer, got Layer: put layers in \[\]"):
            make(layer)


@given(look_objects())
def test_layers_are_painted_in_one_order_whatever_the_file(values):
    look = Look.from_dict(values)
    kinds = [layer.kind for layer in look.layers]
    assert kinds == sorted(kinds, key=PAINTED.index)
    for kind in KINDS:
        given_layers = [one for one in values["layers"] if one["kind"] == kind]
        assert [layer.product.red for layer in look.of(kind)] == [
            one["product"]["red"] for one in given_layers
        ]


@given(name=st.sampled_from(sorted(SPECS)), value=st.floats() | st.integers())
def test_numbers_out_of_range_are_refused_by_name_and_range(name, value):
    low, high = SPECS[name]["low"], SPECS[name]["high"]
    values = {**SHORT, "layers": [{**LAYER, "product": {**LIPS, name: value}}]}
    if low <= value <= high:
        assert getattr(Look.from_dict(values).lips, name) == value
    else:
        with pytest.raises(LookError, match=rf"^layers\[0\]\.product\.{name} must be .*{low:g}"):
            Look.from_dict(values)


DIALS = [(kind, dial) for kind in KINDS.values() for dial in kind.dials]


@pytest.mark.parametrize(("kind", "dial"), DIALS, ids=lambda one: one.name)
@pytest.mark.parametrize("value", [None, True, [1], {}, math.nan, math.inf, 10**400, 1e9, "nose"])
def test_a_shape_out_of_range_is_refused_by_its_name(kind, dial, value):
    layer = {"kind": kind.name, "product": LIPS, "shape": {dial.name: value}}
    where = (
        rf"^layers\[0\]\.shape\.{dial.name} must be (a number in|one of|a colour such as|27 rows)"
    )
    with pytest.raises(LookError, match=where) as caught:
        Look.from_dict({**SHORT, "layers": [layer]})
    assert "\n" not in str(caught.value) and len(str(caught.value)) < 250


@pytest.mark.parametrize("where", ["look", "layer"])
@pytest.mark.parametrize(
    "value", ["1", None, True, [1], {}, math.nan, math.inf, -math.inf, 10**400, -0.1, 1.1]
)
def test_a_strength_is_a_number_in_its_range(where, value):
    values = {**SHORT, "strength": value} if where == "look" else with_layer(strength=value)
    name = "strength" if where == "look" else r"layers\[1\]\.strength"
    with pytest.raises(LookError, match=rf"^{name} must be a number in 0\.\.1, got"):
        Look.from_dict(values)


@pytest.mark.parametrize("name", SEVEN)
def test_a_missing_parameter_is_named_with_its_range(name):
    lips = {key: value for key, value in LIPS.items() if key != name}
    with pytest.raises(LookError, match=rf"layers\[0\]\.product\.{name} is missing: give a"):
        Look.from_dict({**SHORT, "layers": [{**LAYER, "product": lips}]})


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({**SHORT, "colour": 1}, "the look has an unknown key 'colour'; known are version, strength"),
        ({**SHORT, "lips": LIPS}, "the look has an unknown key 'lips'"),
        ({**SHORT, "version": 3}, "version must be 1 or 2, got 3"),
        ({**SHORT, "version": 2.0}, "version must be 1 or 2, got 2.0"),
        ({**SHORT, "version": True}, "version must be 1 or 2, got true"),
        ({"layers": []}, "version is missing: give 2"),
        ({"version": 2}, "layers is missing: give a list"),
        ({**SHORT, "layers": {"0": LAYER}}, "layers must be a list, got {"),
        ({**SHORT, "layers": [LAYER, 1]}, "layers[1] must be an object, got 1"),
        ({**SHORT, "layers": [{"product": LIPS}]}, "layers[0].kind is missing: give one of lipstick"),
        ({**SHORT, "layers": [{"kind": "lipstick"}]}, "layers[0].product is missing: give an object"),
        (with_layer(kind="mascara"), 'layers[1].kind must be one of lipstick, eyeshadow'),
        (with_layer(kind=["eyeliner"]), 'layers[1].kind must be one of lipstick, eyeshadow'),
        (with_layer(product=None), "layers[1].product must be an object"),
        (with_layer(product=[1]), "layers[1].product must be an object"),
        (with_layer(colour=1), "layers[1] has an unknown key 'colour'; known are kind, strength"),
        (with_layer(product={**LIPS, "glos": 1}), "layers[1].product has an unknown key 'glos'"),
        (with_layer(shape=[]), "layers[1].shape must be an object, got []"),
        (with_layer(shape={"wing": 7}), "layers[1].shape.wing must be a number in 0..1, got 7"),
        (with_layer(shape={"slot": "lid"}), "layers[1].shape has an unknown key 'slot'; known are thick"),
        (with_layer(shape={1: 2}), "layers[1].shape has an unknown key 1; known are thickness"),
        ({**SHORT, "layers": [{"kind": "eyeshadow", "product": LIPS, "shape": {"slot": "brow"}}]},
         "layers[0].shape.slot must be one of lid, crease, brow_bone, outer, under, inner, full, got"),
        ({**SHORT, "layers": [{"kind": "lipstick", "product": LIPS, "shape": {"rim_color": "red"}}]},
         "layers[0].shape.rim_color must be a colour such as '#B4002E', got \"red\""),
        ({**SHORT, "layers": [LAYER] * 20}, "a look has at most 1 layer of lipstick, got 20"),
        ({**SHORT, "layers": [{**LAYER, "kind": "eyeshadow"}] * 5},
         "a look has at most 4 layers of eyeshadow, got 5"),
        ({**SHORT, "layers": [1] * 20}, "layers[0] must be an object, got 1"),
        ([], "a look must be a JSON object, got []"),
        (None, "a look must be a JSON object, got null"),
    ],
)  # fmt: skip
def test_every_mistake_is_one_line_that_names_it(values, words):
    with pytest.raises(LookError) as caught:
        Look.from_dict(values)
    assert str(caught.value).startswith(words)
    assert "\n" not in str(caught.value) and len(str(caught.value)) < 300


@pytest.mark.parametrize(
    ("make", "words"),
    [
        (lambda: Layer("nose", GraphicsParams(**LIPS)), "kind must be one of"),
        (lambda: layer_of("eyeliner", shape={"wing": 2}), "shape.wing must be a number in 0..1"),
        (lambda: layer_of("blush", strength=math.nan), "strength must be a number in 0..1"),
        (lambda: Look([layer_of("blush")] * 2), "a look has at most 1 layer of blush, got 2"),
        (lambda: Look(strength=2), "strength must be a number in 0..1, got 2"),
        (lambda: Look(zone="outer"), "zone and intensity belong to eyeshadow: give eyes"),
        (lambda: Look(intensity=-1), "intensity must be a number in 0..1, got -1"),
        (lambda: Look(zone="nose"), "zone must be one of lid, crease,"),
    ],
)
def test_looks_made_in_python_are_checked_alike(make, words):
    with pytest.raises(LookError) as caught:
        make()
    assert str(caught.value).startswith(words)


def test_lips_and_eyes_are_the_short_way_to_two_layers():
    lips, eyes = (GraphicsParams(**{**LIPS, "red": red}) for red in (1, 2))
    look = Look(lips=lips, eyes=eyes, zone="outer", intensity=0.5)
    assert look == Look([Layer("lipstick", lips), Layer("eyeshadow", eyes, {"slot": "outer"}, 0.5)])
    assert (look.lips, look.eyes, look.zone) == (lips, eyes, "outer")
    assert (Look().lips, Look().eyes, Look().zone) == (None, None, "lid")
    assert look.kinds == ("lipstick", "eyeshadow")


def test_layers_of_one_kind_can_be_replaced_and_taken_off():
    look = Look([layer_of("blush"), layer_of("lipstick"), layer_of("eyeshadow")])
    shadows = [layer_of("eyeshadow", hexed) for hexed in ("#111111", "#222222")]
    two = look.with_kind("eyeshadow", shadows)
    assert two.of("eyeshadow") == tuple(shadows)
    assert two.of("blush") == look.of("blush") and two.lips == look.lips
    assert two.with_kind("eyeshadow", ()).kinds == ("lipstick", "blush")


def test_a_shape_is_whole_from_its_slot_and_defaults():
    for kind in KINDS.values():
        assert set(layer_of(kind.name).whole_shape) == {dial.name for dial in kind.dials}
        for slot, numbers in kind.slots.items():
            assert layer_of(kind.name, shape={"slot": slot}).whole_shape.items() >= numbers.items()
    shape = layer_of("eyeshadow", shape={"slot": "outer", "low": 0.5}).whole_shape
    outer = KINDS["eyeshadow"].slots["outer"]
    assert shape == {**outer, "slot": "outer", "eye": "both", "low": 0.5, "map": ""}


def test_the_example_of_the_documentation_reads():
    import makeup_video.pipeline.look.look as module

    look = Look.from_dict(json.loads(module.__doc__.split("\n\n")[1]))
    assert look.lips.red == 180 and look.of("eyeshadow")[0].strength == 0.8


def test_bare_means_that_nothing_will_be_painted():
    lips = GraphicsParams(**LIPS)
    assert Look().is_bare and Look(lips=lips, strength=0).is_bare
    assert Look(eyes=lips, intensity=0).is_bare
    assert not Look(eyes=lips).is_bare
    assert [layer.strength for layer in Look([Layer("blush", lips, {}, 0.5)], 0.5).painted] == [
        0.25
    ]


def test_a_look_that_cannot_be_saved_names_its_file(tmp_path):
    with pytest.raises(
        OutputError, match=r"no/look\.json cannot be written: No such file.*; choose another"
    ):
        Look().save(tmp_path / "no" / "look.json")


def test_a_look_that_cannot_be_written_leaves_the_old_file(tmp_path, monkeypatch):
    path, (old, new) = tmp_path / "look.json", (Look(), Look(lips=product("red", "matte")))
    old.save(path)
    before = path.read_bytes()

    def full(self, text, **_):
        self.write_bytes(text[:20].encode())
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr(Path, "write_text", full)
        with pytest.raises(OutputError, match="cannot be written: No space left on device; free"):
            new.save(path)
    assert [file.name for file in tmp_path.iterdir()] == ["look.json"]
    assert path.read_bytes() == before
    new.save(path)
    assert Look.load(path) == new


@pytest.mark.skipif(os.name == "nt", reason="Windows has no such modes")
def test_saving_again_keeps_the_mode_and_other_files(tmp_path):
    path, other = tmp_path / "look.json", tmp_path / "look.part.json"
    other.write_text("mine")
    Look().save(path)
    path.chmod(0o600)
    Look(lips=product("red", "matte")).save(path)
    assert stat.S_IMODE(path.stat().st_mode) == 0o600 and other.read_text() == "mine"
    assert sorted(file.name for file in tmp_path.iterdir()) == ["look.json", "look.part.json"]


def test_a_layer_keeps_its_shape_when_the_callers_changes():
    red, shape = product("red", "matte"), {"gradient": 0.5}
    layers = (
        Layer("lipstick", red, shape),
        Layer.from_dict(Layer("lipstick", red).to_dict() | {"shape": shape}),
    )
    shape["gradient"] = 7
    assert all(layer.shape == {"gradient": 0.5} for layer in layers)


@pytest.mark.parametrize("kind", KINDS)
def test_nobody_can_change_the_shape_of_a_layer(kind):
    """Ready looks are shared, and checked values must stay within their ranges."""
    layer = layer_of(kind)
    copies = copy.copy(layer), copy.deepcopy(layer), pickle.loads(pickle.dumps(layer))
    for one in (layer, *copies):
        assert one == layer and hash(one) == hash(layer)
        assert asdict(one)["shape"] == one.shape == json.loads(json.dumps(one.shape))
        with pytest.raises(TypeError, match="shape of a layer cannot be changed: dataclasses"):
            one.shape["gradient"] = 7
        with pytest.raises(TypeError):
            one.shape.update(gradient=7)


def test_layers_are_asked_for_by_the_name_of_their_kind():
    look = Look(lips=product("#B4002E", "gloss"))
    with pytest.raises(LookError, match="kind must be one of lipstick"):
        look.with_kind("lips", [])
    with pytest.raises(
        LookError, match="layers must be of the kind eyeshadow, got one of lipstick"
    ):
        look.with_kind("eyeshadow", look.layers)
    for layers in ([look.lips], [look.to_dict()]):
        with pytest.raises(TypeError, match="layers must be Layer, got"):
            Look(layers)


@given(st.tuples(*[st.integers(0, 255)] * 3))
def test_a_colour_may_stand_for_red_green_and_blue(rgb):
    rest = {name: value for name, value in LIPS.items() if name not in ("red", "green", "blue")}
    red, green, blue = rgb
    short = GraphicsParams.from_dict({**rest, "color": f"#{bytes(rgb).hex()}"})
    assert short == GraphicsParams.from_dict({**rest, "red": red, "green": green, "blue": blue})


@pytest.mark.parametrize(
    ("values", "words"),
    [
        ({**LIPS, "color": "#123456"}, "product has color and red: leave one of them out"),
        ({"color": "redd"}, "product.color must be a colour such as '#B4002E', got \"redd\""),
        ({"color": 7}, "product.color must be a colour such as '#B4002E', got 7"),
        ({"color": "#123456"}, "product.opacity is missing: give a number in 0..1"),
    ],
)
def test_a_wrong_colour_is_one_line(values, words):
    with pytest.raises(LookError, match=re.escape(words)):
        GraphicsParams.from_dict(values)


def test_a_layer_of_no_strength_is_not_painted():
    worn, off = (Layer("lipstick", product("#B4002E", "gloss"), strength=n) for n in (1, 0))
    assert Look([off]).painted == Look([worn], strength=0).painted == []


def test_each_eye_may_wear_as_many_shadows_as_a_look():
    shadow, most = product("#5A3A2E", "matte", "eyes"), KINDS["eyeshadow"].most
    left, right = ([Layer("eyeshadow", shadow, {"eye": eye})] * most for eye in ("left", "right"))
    assert len(Look([*left, *right]).layers) == 2 * most
    with pytest.raises(LookError, match=f"got {most + 1} on the left eye"):
        Look([*left, *right, left[0]])
