"""Codes, light and primaries follow the standards, and every code survives a round trip."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from makeup_video.kernels.colour import (
    HLG,
    LUMA_WEIGHTS,
    PQ,
    PQ_LARGEST,
    PRIMARIES,
    SRGB,
    Coding,
    decode,
    encode,
    from_srgb_primaries,
    matrices,
    product_linear,
    rounded,
    to_encoded,
    to_linear,
    to_xyz,
)

TRANSFERS = (SRGB, PQ, HLG)
CODINGS = st.builds(
    Coding,
    st.sampled_from(sorted(LUMA_WEIGHTS)),
    st.booleans(),
    st.sampled_from(TRANSFERS),
    st.sampled_from(sorted(PRIMARIES)),
    st.sampled_from([8, 10, 12]),
)
BARS = np.array([
    [1, 1, 1], [1, 1, 0], [0, 1, 1], [0, 1, 0], [1, 0, 1], [1, 0, 0], [0, 0, 1], [0, 0, 0],
])  # fmt: skip


def bars(coding):
    """The codes of full colour bars."""
    return rounded(encode(to_linear(BARS.astype(float), coding.transfer), coding), coding).tolist()


def test_full_bars_have_the_codes_of_bt_709():
    assert bars(Coding(1)) == [
        [235, 128, 128], [219, 16, 138], [188, 154, 16], [173, 42, 26],
        [78, 214, 230], [63, 102, 240], [32, 240, 118], [16, 128, 128],
    ]  # fmt: skip


@pytest.mark.parametrize("matrix", [5, 6])
def test_full_bars_have_the_codes_of_bt_601(matrix):
    assert bars(Coding(matrix)) == [
        [235, 128, 128], [210, 16, 146], [170, 166, 16], [145, 54, 34],
        [106, 202, 222], [81, 90, 240], [41, 240, 110], [16, 128, 128],
    ]  # fmt: skip


def test_a_jpeg_has_the_codes_of_jfif():
    # JFIF 1.02: Cb = -0.1687 R - 0.3313 G + 0.5 B + 128, Cr = 0.5 R - 0.4187 G - 0.0813 B + 128
    _, to_codes = matrices(Coding(5, full_range=True))
    want = [[0.299, 0.587, 0.114], [-0.1687, -0.3313, 0.5], [0.5, -0.4187, -0.0813]]
    np.testing.assert_allclose(to_codes[:, :3] / 255, want, atol=5e-5)
    np.testing.assert_array_equal(to_codes[:, 3], [0, 128, 128])


def test_bt_2020_in_ten_bits_is_as_its_tables_4_and_5_say():
    # C'B = (B' - Y') / 1.8814, C'R = (R' - Y') / 1.4746; codes 876 Y' + 64 and 896 C + 512
    rgb = np.array([0.8, 0.3, 0.6])
    luma = rgb @ [0.2627, 0.6780, 0.0593]
    want = [876 * luma + 64, 896 * (0.6 - luma) / 1.8814 + 512, 896 * (0.8 - luma) / 1.4746 + 512]
    _, to_codes = matrices(Coding(9, bit_depth=10))
    np.testing.assert_allclose(to_codes[:, :3] @ rgb + to_codes[:, 3], want, atol=1e-2)


def test_the_srgb_curve_is_that_of_iec_61966_2_1():
    np.testing.assert_allclose(to_linear(np.array([0.5]), SRGB), 0.214041, atol=1e-6)
    np.testing.assert_allclose(to_linear(np.array([0.04045]), SRGB), 0.0031308, atol=1e-7)
    np.testing.assert_allclose(to_encoded(np.array([0.18]), SRGB), 0.461356, atol=1e-6)


def test_pq_is_that_of_st_2084_with_203_as_one():
    light = np.array([100, 1000, 10000]) / 203
    np.testing.assert_allclose(to_encoded(light, PQ), [0.508078, 0.751827, 1], atol=1e-6)
    np.testing.assert_allclose(to_linear(np.array([0.5]), PQ) * 203, 92.2457, atol=1e-4)


def test_hlg_is_that_of_bt_2100():
    # scene light is 1/12 at half the signal and 1 at full signal, where a display has 1000 cd/m2
    light = to_linear(np.array([[0.5] * 3, [1] * 3, [0.75] * 3]), HLG)[:, 0]
    np.testing.assert_allclose(light[1] * 203, 1000, rtol=2e-3)  # 75 % is 203.2, not 203
    np.testing.assert_allclose(light[0] / light[1], (1 / 12) ** 1.2, rtol=1e-6)
    # colours keep their scene ratios: the three channels share one gain
    colour = to_linear(np.array([0.5, np.sqrt(0.5) * 0.5, 0]), HLG)
    np.testing.assert_allclose(colour[1] / colour[0], 0.5, rtol=1e-9)


def test_white_and_the_grey_card_have_the_levels_of_bt_2408():
    # table 1: HDR reference white 58 % PQ and 75 % HLG; 18 % grey 26 cd/m2, 38 % of either
    for transfer, white in ((PQ, 0.58), (HLG, 0.75)):
        np.testing.assert_allclose(to_encoded(np.ones(3), transfer), white, atol=5e-3)
        np.testing.assert_allclose(to_linear(np.full(3, 0.38), transfer) * 203, 26, atol=1)


def test_primaries_are_those_of_the_standards():
    srgb_xyz = [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]]
    np.testing.assert_allclose(to_xyz(1), srgb_xyz, atol=1e-4)  # IEC 61966-2-1
    bt_2087 = [[0.6274, 0.3293, 0.0433], [0.0691, 0.9195, 0.0114], [0.0164, 0.0880, 0.8956]]
    np.testing.assert_allclose(from_srgb_primaries(9), bt_2087, atol=5e-5)  # ITU-R BT.2087
    p3 = [[0.8225, 0.1775, 0], [0.0332, 0.9668, 0], [0.0171, 0.0724, 0.9105]]
    np.testing.assert_allclose(from_srgb_primaries(12), p3, atol=1e-4)
    for primaries in PRIMARIES:
        np.testing.assert_allclose(from_srgb_primaries(primaries).sum(axis=1), 1, atol=1e-9)
    np.testing.assert_array_equal(from_srgb_primaries(1), np.eye(3))  # black channels stay black


@given(st.tuples(*[st.integers(0, 255)] * 3), CODINGS)
def test_a_product_colour_is_that_colour_in_every_coding(rgb, coding):
    linear = product_linear(rgb, coding)
    back = to_encoded(np.linalg.inv(from_srgb_primaries(coding.primaries)) @ linear, SRGB)
    np.testing.assert_allclose(back * 255, rgb, atol=1e-6)
    if coding.transfer == SRGB and coding.primaries == 1:  # players show the given colour
        _, to_codes = matrices(coding)
        want = to_codes[:, :3] @ (np.array(rgb) / 255) + to_codes[:, 3]
        np.testing.assert_allclose(encode(linear, coding), want, atol=1e-6)


@given(CODINGS)
def test_every_grey_code_returns_to_itself(coding):
    luma = np.arange(coding.max_code + 1)
    codes = np.stack([luma, *[np.full_like(luma, 2 ** (coding.bit_depth - 1))] * 2], axis=1)
    np.testing.assert_array_equal(rounded(encode(decode(codes, coding), coding), coding), codes)


@given(CODINGS, st.integers(0, 2**32 - 1))
def test_codes_survive_a_round_trip_even_outside_the_gamut(coding, seed):
    codes = np.random.default_rng(seed).integers(0, coding.max_code + 1, (500, 3))
    if coding.transfer == PQ:  # clipped below the pole of the curve
        to_rgb, _ = matrices(coding)
        codes = codes[np.abs(codes @ to_rgb[:, :3].T + to_rgb[:, 3]).max(axis=1) < PQ_LARGEST]
    np.testing.assert_array_equal(rounded(encode(decode(codes, coding), coding), coding), codes)


@pytest.mark.parametrize("transfer", TRANSFERS)
def test_more_signal_is_more_light(transfer):
    signal = np.linspace(-1, 1.2, 3000)[:, None].repeat(3, axis=1)
    assert (np.diff(to_linear(signal, transfer)[:, 0]) >= 0).all()
    assert (np.diff(to_encoded(signal, transfer)[:, 0]) >= 0).all()


@pytest.mark.parametrize(
    "wrong", [{"matrix": 2}, {"transfer": 1}, {"primaries": 2}, {"bit_depth": 7}]
)
def test_an_open_coding_is_refused(wrong):
    with pytest.raises(ValueError, match="must be one of"):
        Coding(**wrong)
