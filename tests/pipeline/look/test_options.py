"""A look from the options: properties of every combination, and one line for each mistake."""

from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st
from looks import PRODUCTS, layer_of, looks
from makeup_video.pipeline import FINISHES, KINDS, Layer, Look, UsageError, product
from makeup_video.pipeline.look.kinds import PARTS
from makeup_video.pipeline.look.options import Choice, choose_look, parse_parts, parse_zone
from refusals import refused

FOLLOW = [part for part, kind in PARTS.items() if kind.follows_color]
COLOURS = st.tuples(*[st.integers(0, 255)] * 3)
FINISH = st.sampled_from(list(FINISHES))
NAMED = ["lips", "eyes", "lips,eyes", "eyes, Lips", "lips,lipstick", "blush,liner", "shadow"]
SHARE = st.integers(0, 100).map(lambda n: (f"{n}%", n / 100))
ZONES = st.sampled_from(list(KINDS["eyeshadow"].slots))
PLAIN = st.sampled_from(list(PARTS)).flatmap(lambda part: st.tuples(st.just(part), COLOURS))


def spelled(rgb):
    return "#" + bytes(rgb).hex()


def colour_of(layer):
    return layer.product.red, layer.product.green, layer.product.blue


def finished(layer, part, finish):
    """A layer's numbers in this finish, without its colour; a density map keeps its opacity."""
    if finish is None:
        return rest_of(layer)
    kept = {"opacity": layer.product.opacity} if layer.shape.get("map") else {}
    return FINISHES[finish][part] | kept


def rest_of(layer):
    return {name: getattr(layer.product, name) for name in FINISHES["matte"]["lips"]}


def new(part, rgb, finish=None):
    kind = PARTS[part]
    return Layer(kind.name, product(rgb, finish or kind.first_finish, part))


@given(COLOURS, st.none() | FINISH, st.none() | st.sampled_from(NAMED))
def test_a_colour_alone_paints_the_lips_or_the_parts(rgb, finish, parts):
    look = choose_look(Choice(color=spelled(rgb), finish=finish, parts=parts))
    assert look == Look([new(part, rgb, finish) for part in parse_parts(parts or "lips")])


@given(looks())
def test_a_look_alone_is_painted_as_it_is(base):
    assert choose_look(Choice(base=base)) == base


@given(looks(), COLOURS, st.none() | FINISH)
def test_a_colour_and_a_finish_override_those_of_a_look(base, rgb, finish):
    look = choose_look(Choice(base=base, color=spelled(rgb), finish=finish))
    coloured = [part for part in FOLLOW if base.of(PARTS[part].name)]
    for part, kind in PARTS.items():
        old = base.of(kind.name)
        if part in coloured:
            for before, after in zip(old, look.of(kind.name), strict=True):
                assert colour_of(after) == rgb and after.shape == before.shape
                assert rest_of(after) == finished(before, part, finish)
        elif part == "lips" and not coloured:
            assert look.of(kind.name) == (new(part, rgb, finish),)
        else:
            assert look.of(kind.name) == old


@given(looks().filter(lambda look: look.lips or look.eyes), FINISH)
def test_a_finish_keeps_the_colours_of_the_look(base, finish):
    look = choose_look(Choice(base=base, finish=finish))
    assert [colour_of(layer) for layer in look.layers] == [colour_of(one) for one in base.layers]
    for part in FOLLOW:
        name = PARTS[part].name
        for before, after in zip(base.of(name), look.of(name), strict=True):
            assert rest_of(after) == finished(before, part, finish)


@given(looks(), st.sampled_from(NAMED), st.none() | COLOURS)
def test_parts_are_painted_and_no_others(base, parts, rgb):
    choice = Choice(base=base, parts=parts, color=None if rgb is None else spelled(rgb))
    missing = [part for part in parse_parts(parts) if not base.of(PARTS[part].name)]
    if missing and rgb is None:
        with refused(UsageError, f"names the {missing[0]}.* leaves bare: add --color"):
            choose_look(choice)
        return
    look = choose_look(choice)
    assert set(look.kinds) == {PARTS[part].name for part in parse_parts(parts)}
    for part in missing:
        assert look.of(PARTS[part].name) == (new(part, rgb),)


@given(looks(), PLAIN)
def test_a_part_is_replaced_and_the_others_stay(base, worn):
    part, rgb = worn
    look = choose_look(Choice(base=base, worn={part: spelled(rgb)}))
    assert look == base.with_kind(PARTS[part].name, [new(part, rgb)])


@given(looks(), st.sampled_from(list(PARTS)))
def test_none_takes_a_part_off(base, part):
    look = choose_look(Choice(base=base, worn={part: "None"}))
    assert look == base.with_kind(PARTS[part].name, [])


@given(st.dictionaries(st.sampled_from(list(PARTS)), COLOURS, min_size=1), st.none() | FINISH)
def test_parts_make_a_look_by_themselves(worn, finish):
    texts = {part: spelled(rgb) for part, rgb in worn.items()}
    look = choose_look(Choice(worn=texts, finish=finish))
    assert look == Look([new(part, rgb, finish) for part, rgb in worn.items()])


def test_a_colour_leaves_the_parts_that_have_one_of_their_own():
    base = Look([layer_of("lipstick"), layer_of("eyeshadow"), layer_of("blush")])
    look = choose_look(
        Choice(base=base, color="red", worn={"eyes": "navy:matte", "liner": "black"})
    )
    assert [layer.product.hex for layer in look.layers] == [
        "#B4002E",
        "#000080",
        "#000000",
        "#FF0000",
    ]
    look = choose_look(Choice(base=base, parts="lips", worn={"eyes": "navy"}))
    assert look.kinds == ("lipstick", "eyeshadow")
    look = choose_look(Choice(color="red", worn={"eyes": "navy"}))
    assert look == Look([new("lips", (255, 0, 0)), new("eyes", (0, 0, 128))])


@given(looks(), PRODUCTS, st.none() | SHARE, st.none() | SHARE, st.none() | ZONES)
def test_dials_that_are_given_replace_those_of_the_look(base, eyes, strength, intensity, zone):
    base = base.with_kind("eyeshadow", [Layer("eyeshadow", eyes, {"slot": "under"}, 0.7)])
    dials = {"strength": strength and strength[0], "intensity": intensity and intensity[0]}
    look = choose_look(Choice(base=base, zone=zone, **dials))
    assert look.strength == (base.strength if strength is None else strength[1])
    (shadow,) = look.of("eyeshadow")
    assert shadow.strength == (0.7 if intensity is None else intensity[1])
    assert shadow.shape["slot"] == (zone or "under") and shadow.product == eyes
    others = [layer for layer in base.layers if layer.kind != "eyeshadow"]
    assert [layer for layer in look.layers if layer.kind != "eyeshadow"] == others


def test_the_strongest_of_several_shadows_gets_the_intensity():
    shadows = [layer_of("eyeshadow", strength=strength) for strength in (0.4, 0.8, 0.0)]
    look = choose_look(Choice(base=Look(shadows), intensity="60%"))
    assert [one.strength for one in look.of("eyeshadow")] == pytest.approx([0.3, 0.6, 0.0])
    unseen = Look([replace(shadow, strength=0.0) for shadow in shadows])
    look = choose_look(Choice(base=unseen, intensity="0.5"))
    assert [one.strength for one in look.of("eyeshadow")] == [0.5] * 3


@pytest.mark.parametrize("text", ["", "nose", "lips,", "lips eyes", ",", "lips;eyes"])
def test_an_unknown_part_is_refused(text):
    with refused(UsageError, "--parts must be lips, eyes, liner, blush.*, such as lips,eyes, got"):
        parse_parts(text)


def test_places_have_their_usual_names():
    assert [parse_zone(word) for word in ("LID", "brow bone", "outer corner", "lower lid")] == [
        "lid", "brow_bone", "outer", "under"]  # fmt: skip


BLUSHED = Look([layer_of("blush")])
TWO = Look([layer_of("eyeshadow"), layer_of("eyeshadow")])


@pytest.mark.parametrize(
    ("choice", "words"),
    [
        ({}, "no look given: add --ref PHOTO, --look NAME, --lips '#B4002E', or --look none to"),
        ({"parts": "lips"}, "no look given"),
        ({"strength": "0.5"}, "no look given"),
        ({"finish": "gloss"}, "--finish gloss needs a colour: add --color '#B4002E', --ref PHOTO"),
        ({"finish": "gloss", "parts": "lips"}, "--finish gloss needs a colour"),
        ({"base": BLUSHED, "finish": "satin"}, "--finish satin is for lips and eyes, and the look has neither: add --parts blush"),
        ({"base": Look(), "finish": "shiny"}, "--finish gloss needs a colour"),
        ({"color": "B02", "finish": "glos"}, "--finish must be one of matte, .* got 'glos': did you mean gloss"),
        ({"color": "B02", "finish": "xyz"}, "--finish must be one of matte, .* got 'xyz'$"),
        ({"color": "B02", "zone": "lid"}, "--zone is for eyeshadow, and no eyes are painted"),
        ({"color": "B02", "intensity": "1"}, "--intensity is for eyeshadow"),
        ({"color": "B02", "parts": "eyes", "zone": "nose"}, "--zone must be one of lid, crease"),
        ({"color": "B02", "parts": "eyes", "zone": "creese"}, "got 'creese': did you mean crease?"),
        ({"base": TWO, "zone": "lid"}, "--zone is for one eyeshadow, and the look has 2"),
        ({"color": "B02", "parts": "eyes", "intensity": "1.5"}, "--intensity must be a number in"),
        ({"color": "B02", "strength": "-1.0"}, "--strength must be a number in 0..1.*, got '-1.0'"),
        ({"color": "B02", "strength": "80"}, "got '80': did you mean 80%?"),
        ({"color": "B02", "strength": "nan"}, "--strength must be a number in 0..1"),
        ({"color": "B02", "strength": "120%"}, "--strength must be a number in 0..1"),
        ({"color": "B02", "strength": ""}, "--strength must be a number in 0..1"),
        ({"color": "B02", "parts": "lps"}, "got 'lps': did you mean lips?"),
        ({"color": "B02", "worn": {"lips": "red"}}, "--color is for the lips, and so is --lips"),
        ({"color": "B02", "worn": {"lips": "none"}}, "--color is for the lips, and so is --lips"),
        ({"base": Look(), "worn": {"eyes": "reed"}}, "--eyes must be a colour.* did you mean red"),
    ],
)  # fmt: skip
def test_each_mistake_is_one_line_that_names_the_option(choice, words):
    with refused(UsageError, words):
        choose_look(Choice(**choice))


def test_look_none_paints_nothing():
    assert choose_look(Choice(base=Look())).is_bare


def test_a_zone_keeps_the_eye_that_a_shadow_is_for():
    shadow = Layer("eyeshadow", product("#5A3A2E", "matte", "eyes"), {"slot": "lid", "eye": "left"})
    (layer,) = choose_look(Choice(base=Look([shadow]), zone="outer")).layers
    assert layer.shape == {"slot": "outer", "eye": "left"}
