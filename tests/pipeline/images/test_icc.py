"""Profiles are recognised by their colorants, whatever else they hold or lack."""

import pytest
from hypothesis import given
from hypothesis import strategies as st
from icc_profiles import ADOBE_RGB, DISPLAY_P3, SRGB_COLORANTS, SRGB_CURVE, profile
from makeup_video.pipeline.images.icc import is_display_p3

P3 = profile(DISPLAY_P3, SRGB_CURVE)


@pytest.mark.parametrize(
    ("colorants", "is_wide"), [(DISPLAY_P3, True), (SRGB_COLORANTS, False), (ADOBE_RGB, False)]
)
def test_display_p3_is_told_by_its_colorants(colorants, is_wide):
    assert is_display_p3(profile(colorants, SRGB_CURVE, name="any name")) is is_wide


@given(st.integers(0, len(P3)), st.binary(max_size=8))
def test_a_damaged_profile_is_none_of_display_p3(cut, noise):
    damaged = P3[:cut] + noise
    assert is_display_p3(damaged) in (True, False)
    assert cut > 250 or not is_display_p3(damaged)
