"""Look files of version 1 are read for ever: a product for lips and one for eyes."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from looks import UNIT, products
from makeup_video.pipeline import GraphicsParams, Look, LookError
from makeup_video.pipeline.look.look import ZONES

LIPS = {"red": 180, "green": 0, "blue": 46, "opacity": 0.8, "gloss": 0.6, "gloss_roughness": 0.4,
        "reflection": 0.2}  # fmt: skip
SHORT = {"version": 1, "lips": LIPS, "eyes": None}
LOOKS = st.fixed_dictionaries(
    {"version": st.just(1), "lips": st.none() | products(), "eyes": st.none() | products()},
    optional={"strength": UNIT, "zone": st.sampled_from(ZONES), "intensity": UNIT},
)


@given(LOOKS)
def test_every_field_becomes_that_of_a_layer(values):
    look = Look.from_dict(values)
    assert look.strength == values.get("strength", 1.0)
    for name, kind in (("lips", "lipstick"), ("eyes", "eyeshadow")):
        if values[name] is None:
            assert look.of(kind) == ()
        else:
            (layer,) = look.of(kind)
            assert layer.product == GraphicsParams.from_dict(values[name])
    for shadow in look.of("eyeshadow"):
        assert shadow.shape == {"slot": values.get("zone", "lid")}
        assert shadow.strength == values.get("intensity", 1.0)
    assert len(look.layers) == sum(values[name] is not None for name in ("lips", "eyes"))


@given(LOOKS)
def test_an_old_look_is_written_as_version_2(values):
    look = Look.from_dict(values)
    assert look.to_dict()["version"] == 2
    assert Look.from_dict(look.to_dict()) == look


@pytest.mark.parametrize(
    ("values", "match"),
    [
        ({**SHORT, "colour": 1}, "unknown key 'colour'"),
        ({**SHORT, "layers": []}, "unknown key 'layers'"),
        ({**SHORT, "lips": {**LIPS, "glos": 1}}, "lips has an unknown key 'glos'"),
        ({**SHORT, "lips": {**LIPS, "red": 256}}, r"lips\.red must be a number in 0\.\.255, got 256"),
        ({**SHORT, "strength": 2}, r"^strength must be a number in 0\.\.1, got 2"),
        ({**SHORT, "intensity": None}, r"^intensity must be a number in 0\.\.1, got null"),
        ({"version": 1, "eyes": None}, "lips is missing"),
        ({"version": 1, "lips": None}, "eyes is missing"),
        ({**SHORT, "lips": [1]}, "lips must be an object"),
        ({**SHORT, "zone": "cheek"}, "zone must be one of lid, crease, full, outer, got"),
        ({**SHORT, "zone": "under"}, "zone must be one of lid, crease, full, outer, got"),
        ({**SHORT, "zone": []}, "zone must be one of"),
    ],
)  # fmt: skip
def test_mistakes_are_named_as_the_file_spells_them(values, match):
    with pytest.raises(LookError, match=match) as caught:
        Look.from_dict(values)
    assert "\n" not in str(caught.value)
