"""Tests of pipeline/reference/read_makeup.py: probabilities of what is worn."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from makeup_video.pipeline.reference.read_makeup import WORN_FROM, in_company, probability

ODDS = st.floats(-1e3, 1e3)
SHARE = st.floats(1e-6, 1 - 1e-6)


@given(st.sampled_from(sorted(WORN_FROM)), ODDS, ODDS)
def test_a_probability_is_never_quite_certain(kind, by_net, by_colours):
    assert 0 < probability(kind, by_net, by_colours) < 1


@given(ODDS, ODDS, st.floats(0, 50))
def test_lips_unlike_bare_ones_are_never_less_likely_made_up(by_net, by_colours, away):
    near, far = (probability("lipstick", by_net, by_colours, each) for each in (0.0, away))
    assert near <= far
    if by_net <= 0:  # the net sees no lipstick: a strange light does not make one
        assert near == far


@given(st.floats(1.5, 10), st.floats(-20, -4))
def test_a_sure_net_outweighs_lips_that_lack_red(by_net, by_colours):
    assert probability("lipstick", by_net, by_colours - 4) > WORN_FROM["lipstick"]
    assert probability("lipstick", 0.5, by_colours) < WORN_FROM["lipstick"]


COMPANY = [
    ("eyeshadow", "lipstick"),
    ("eyeshadow", "blush"),
    ("blush", "lipstick"),
    ("blush", "eyeshadow"),
]


@given(
    st.fixed_dictionaries(dict.fromkeys(WORN_FROM, SHARE)),
    st.sampled_from(["lipstick", "eyeshadow", "blush"]),
    st.sampled_from(sorted(WORN_FROM)),
)
def test_a_kind_is_the_likelier_the_more_is_worn(worn, kind, other):
    more = {**worn, other: (1 + worn[other]) / 2}
    assert 0 < in_company(kind, worn) <= in_company(kind, more) < 1


@pytest.mark.parametrize(("kind", "other"), COMPANY)
def test_company_turns_doubtful_makeup_into_worn_one(kind, other):
    doubtful = 2 * WORN_FROM[kind]
    alone = dict.fromkeys(WORN_FROM, 0.001) | {kind: doubtful}
    assert in_company(kind, alone) < WORN_FROM[kind]
    assert in_company(kind, alone) < in_company(kind, {**alone, other: 0.95})


@pytest.mark.parametrize("kind", ["eyeshadow", "blush"])
def test_beside_a_whole_look_doubtful_makeup_is_worn(kind):
    beside = dict.fromkeys(WORN_FROM, 0.95) | {kind: WORN_FROM[kind]}
    assert in_company(kind, beside) > WORN_FROM[kind]


@given(SHARE)
def test_only_sure_eyeshadow_tells_a_pale_lipstick(probability):
    alone = dict.fromkeys(WORN_FROM, 0.001) | {"lipstick": probability}
    beside = [in_company("lipstick", {**alone, "eyeshadow": eyes}) for eyes in (0.001, 0.5, 0.99)]
    assert beside[0] == pytest.approx(probability, rel=1e-3)
    assert beside[1] == pytest.approx(probability, rel=0.02)
    assert beside[2] > min(WORN_FROM["lipstick"], 10 * probability)
