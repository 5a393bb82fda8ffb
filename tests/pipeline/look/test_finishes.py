"""Finishes are complete and in range, and differ as their names suggest."""

from dataclasses import fields

import pytest
from hypothesis import given
from hypothesis import strategies as st
from makeup_video.pipeline import FINISHES, GraphicsParams, LookError, UsageError, product
from makeup_video.pipeline.look.regions import REGIONS

CODES = st.tuples(*[st.integers(0, 255)] * 3)
NAMES = st.sampled_from(list(FINISHES))


def test_there_are_six_finishes_for_both_regions():
    assert list(FINISHES) == ["matte", "satin", "sheer", "gloss", "metallic", "shimmer"]
    assert all(list(by_region) == list(REGIONS) for by_region in FINISHES.values())


@pytest.mark.parametrize("region", REGIONS)
def test_a_finish_sets_everything_but_the_colour(region):
    names = {spec.name for spec in fields(GraphicsParams)} - {"red", "green", "blue"}
    assert len(names) == 14
    for by_region in FINISHES.values():
        assert set(by_region[region]) == names


@given(CODES, NAMES, st.sampled_from(list(REGIONS)))
def test_every_colour_in_every_finish_is_a_product(rgb, finish, region):
    params = product(rgb, finish, region)
    assert (params.red, params.green, params.blue) == rgb
    assert all(getattr(params, name) == value for name, value in FINISHES[finish][region].items())


@pytest.mark.parametrize("region", REGIONS)
def test_finishes_are_ordered_as_their_names_say(region):
    by_finish = {name: FINISHES[name][region] for name in FINISHES}
    assert by_finish["matte"]["gloss"] == 0 and by_finish["matte"]["reflection"] == 0
    assert max(by_finish, key=lambda name: by_finish[name]["gloss"]) == "gloss"
    assert min(by_finish, key=lambda name: by_finish[name]["opacity"]) == "sheer"
    assert max(by_finish, key=lambda name: by_finish[name]["shimmer"]) == "shimmer"
    assert max(by_finish, key=lambda name: by_finish[name]["shimmer_tint"]) == "metallic"


@pytest.mark.parametrize("finish", FINISHES)
def test_eye_shadow_is_softer_and_broader_than_lipstick(finish):
    lips, eyes = FINISHES[finish]["lips"], FINISHES[finish]["eyes"]
    assert eyes["edge_softness"] > lips["edge_softness"]
    assert eyes["gloss_roughness"] > lips["gloss_roughness"]
    assert eyes["reflection"] <= lips["reflection"]


@pytest.mark.parametrize(
    ("rgb", "finish", "region", "error", "words"),
    [
        ((0, 0, 0), "glossy", "lips", UsageError, "matte, satin, sheer"),
        ((0, 0, 0), "gloss", "nose", UsageError, "lips, eyes"),
        ((0, 0), "gloss", "lips", UsageError, "got 2 numbers"),
        ((0, 256, 0), "gloss", "lips", LookError, "green must be"),
    ],
)
def test_invalid_products_are_refused(rgb, finish, region, error, words):
    with pytest.raises(error, match=words):
        product(rgb, finish, region)
