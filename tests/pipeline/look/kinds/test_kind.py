"""How much of the highlights of bare skin the products of a kind keep."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from makeup import params
from makeup_video.pipeline import KINDS, product


@given(params(), st.sampled_from(sorted(KINDS)))
def test_kept_highlights_are_a_share_of_the_kinds_own(worn, name):
    kind = KINDS[name]
    assert kind.keep_matte * kind.keep_highlights <= kind.kept_highlights(worn)
    assert kind.kept_highlights(worn) <= kind.keep_highlights + 1e-9


@pytest.mark.parametrize(
    ("finish", "share"), [("matte", 0.2), ("satin", 1), ("gloss", 1), ("metallic", 1)]
)
def test_matte_lipstick_scatters_the_shine_of_bare_lips(finish, share):
    kind = KINDS["lipstick"]
    worn = product((58, 8, 24), finish, kind.part)
    assert kind.kept_highlights(worn) == pytest.approx(share)
