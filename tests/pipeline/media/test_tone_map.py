"""HDR colours in SDR: the tone curve of ITU-R BT.2390, and colours outside BT.709."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from makeup_video.kernels.colour import HLG, PQ, SRGB, from_srgb_primaries, to_encoded, to_linear
from makeup_video.pipeline.media.tone_map import peak_of, sdr_table, to_sdr, tone_curve

PEAKS = st.floats(0.5, 10000 / 203)


def eetf(signal, peak_nits, white_nits):
    """BT.2390-11, section 5.4, equations of steps 1 to 4, one number at a time; black is 0."""
    to_pq = lambda nits: float(to_encoded(np.array([nits / 203]), PQ)[0])
    e1 = signal / to_pq(peak_nits)
    max_lum = to_pq(white_nits) / to_pq(peak_nits)
    ks = 1.5 * max_lum - 0.5
    if e1 < ks:
        e2 = e1
    else:
        t = (e1 - ks) / (1 - ks)
        e2 = (
            (2 * t**3 - 3 * t**2 + 1) * ks
            + (t**3 - 2 * t**2 + t) * (1 - ks)
            + (-2 * t**3 + 3 * t**2) * max_lum
        )
    return e2 * to_pq(peak_nits)


@pytest.mark.parametrize("peak_nits", [400, 1000, 4000, 10000])
def test_the_curve_is_that_of_the_recommendation(peak_nits):
    for nits in np.geomspace(0.01, peak_nits, 40):
        light = np.array([nits / 203])
        got = to_encoded(tone_curve(light, peak_nits / 203), PQ)[0]
        want = eetf(float(to_encoded(light, PQ)[0]), peak_nits, 203)
        assert got == pytest.approx(want, abs=1e-6)


@given(peak=PEAKS)
def test_black_stays_black_and_the_peak_becomes_white(peak):
    black, white = tone_curve(np.array([0.0, peak]), peak)
    assert black == pytest.approx(0, abs=1e-9)
    assert white == pytest.approx(min(peak, 1), rel=1e-6)


@given(peak=PEAKS)
def test_the_curve_rises_and_makes_nothing_brighter(peak):
    light = np.linspace(0, peak, 500)
    mapped = tone_curve(light, peak)
    assert (np.diff(mapped) >= -1e-9).all()
    assert (mapped <= light + 1e-9).all()


@given(peak=st.floats(1.5, 40))
def test_dark_light_stays_as_it_is(peak):
    top, white = to_encoded(np.array([peak, 1.0]), PQ)
    below_the_knee = max(1.5 * white - 0.5 * top, 0) * 0.99
    light = to_linear(np.linspace(0, below_the_knee, 50), PQ)
    np.testing.assert_allclose(tone_curve(light, peak), light, atol=1e-9)


@given(
    rgb=st.tuples(*[st.floats(0, 1)] * 3),
    transfer=st.sampled_from([PQ, HLG]),
    primaries=st.sampled_from([1, 9, 12]),
    peak=PEAKS,
)
def test_every_colour_comes_out_finite_and_in_range(rgb, transfer, primaries, peak):
    out = to_sdr(np.array([rgb]), transfer, primaries, peak)
    assert out.shape == (1, 3) and np.isfinite(out).all()
    assert (out >= 0).all() and (out <= 1).all()


@given(grey=st.floats(0, 1), transfer=st.sampled_from([PQ, HLG]), primaries=st.sampled_from([1, 9]))
def test_grey_stays_grey(grey, transfer, primaries):
    out = to_sdr(np.full((1, 3), grey), transfer, primaries, 1000 / 203)
    assert np.ptp(out) < 1e-6


@given(srgb=st.tuples(*[st.floats(0, 0.4)] * 3), transfer=st.sampled_from([PQ, HLG]))
def test_a_dark_colour_of_srgb_comes_back_as_it_was(srgb, transfer):
    light = from_srgb_primaries(9) @ to_linear(np.array(srgb), SRGB)
    hdr = to_encoded(np.maximum(light, 0)[None], transfer)
    np.testing.assert_allclose(to_sdr(hdr, transfer, 9, 1000 / 203)[0], srgb, atol=2e-3)


def test_red_varies_fastest_in_the_table():
    table = sdr_table(5, PQ, 9, 1000 / 203).reshape(5, 5, 5, 3)
    axis = np.linspace(0, 1, 5)
    want = to_sdr(np.array([[axis[3], axis[2], axis[1]]]), PQ, 9, 1000 / 203)[0]
    np.testing.assert_allclose(table[1, 2, 3], want, atol=1e-12)


@pytest.mark.parametrize(
    ("content", "display", "nits"),
    [
        (None, None, 1000),
        (0.0, 4000.0, 4000),
        (600.0, 1000.0, 600),
        (100.0, 1000.0, 1000),  # below white: a dark video counts by its display
        (65535.0, 1e9, 1000),  # nonsense
        (None, 600.0, 600),
    ],
)
def test_the_peak_is_the_contents_the_displays_or_1000(content, display, nits):
    assert peak_of(content, display) == pytest.approx(nits / 203)
