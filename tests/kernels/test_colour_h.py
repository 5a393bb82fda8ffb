"""colour.h matches its numpy twin to the precision of ten bits, and PoCL vectorises it."""

import itertools

import numpy as np
import pyopencl as cl
import pytest
from kernel_arguments import on_device
from makeup_video.kernels.colour import (
    DEFINITIONS,
    HLG,
    LUMA_WEIGHTS,
    PQ,
    SRGB,
    Coding,
    coding_argument,
    decode,
    encode,
    rounded,
)
from makeup_video.kernels.program import Device, source_of

TRANSFERS = (SRGB, PQ, HLG)
SOURCE = """
__kernel void test_decode(__global const float *restrict codes, __global float *restrict linear,
                          const colour_coding coding, const int count) {
    int i = get_global_id(0);
    if (i >= count) return;
    colour_rgb rgb = colour_decode(codes[3 * i], codes[3 * i + 1], codes[3 * i + 2], &coding);
    linear[3 * i] = rgb.red; linear[3 * i + 1] = rgb.green; linear[3 * i + 2] = rgb.blue;
}
__kernel void test_encode(__global float *restrict codes, __global const float *restrict linear,
                          const colour_coding coding, const int count) {
    int i = get_global_id(0);
    if (i >= count) return;
    colour_rgb rgb = {linear[3 * i], linear[3 * i + 1], linear[3 * i + 2]};
    colour_codes out = colour_encode(rgb, &coding);
    codes[3 * i] = out.luma; codes[3 * i + 1] = out.cb; codes[3 * i + 2] = out.cr;
}
#define TEST_DIM(name, sample) \\
__kernel void name(__global sample *restrict luma, __global sample *restrict cb, \\
                   __global sample *restrict cr, const int stride, const int width, \\
                   const colour_coding coding, const float gain) { \\
    int x = get_global_id(0); \\
    if (x >= width) return; \\
    int i = get_global_id(1) * stride + x; \\
    colour_rgb rgb = colour_decode(luma[i], cb[i], cr[i], &coding); \\
    rgb.red *= gain; rgb.green *= gain; rgb.blue *= gain; \\
    colour_codes out = colour_encode(rgb, &coding); \\
    luma[i] = (sample)colour_round(out.luma, &coding); \\
    cb[i] = (sample)colour_round(out.cb, &coding); \\
    cr[i] = (sample)colour_round(out.cr, &coding); \\
}
TEST_DIM(test_dim_8, uchar)
TEST_DIM(test_dim_16, ushort)
"""


@pytest.fixture(scope="module")
def device():
    return Device()


@pytest.fixture(scope="module")
def kernel(device):
    """(name, transfer) -> kernel, each program built once."""
    source = source_of("colour.h") + SOURCE
    programs = {
        transfer: device.build(source, transfer, definitions=DEFINITIONS) for transfer in TRANSFERS
    }
    return lambda name, transfer: cl.Kernel(programs[transfer], name)


def codings(depths=(8, 10, 12)):
    for values in itertools.product(sorted(LUMA_WEIGHTS), (False, True), TRANSFERS, depths):
        yield Coding(values[0], values[1], values[2], 9 if values[0] == 9 else 1, values[3])


def all_codes(coding, count=4000):
    """Every grey code, the corners of the code cube, and random colours, (N, 3)."""
    luma = np.arange(coding.max_code + 1)
    grey = np.stack([luma, *[np.full_like(luma, 2 ** (coding.bit_depth - 1))] * 2], axis=1)
    corners = list(itertools.product((0, coding.max_code), repeat=3))
    any_codes = np.random.default_rng(1).integers(0, coding.max_code + 1, (count, 3))
    return np.concatenate([grey, corners, any_codes])


def run(device, kernel, codes, linear, coding):
    with on_device(device, codes, linear) as buffers:
        count = len(codes)
        arguments = [*buffers, coding_argument(coding), np.int32(count)]
        device.launch(kernel, (count, 1), arguments)


def test_decoding_is_right_to_a_tenth_of_a_code_of_ten_bits(device, kernel):
    for coding in codings(depths=(8, 10)):
        codes = all_codes(coding)
        got = np.zeros(codes.shape, np.float32)
        run(device, kernel("test_decode", coding.transfer), codes.astype(np.float32), got, coding)
        # compare codes: linear light has no natural scale for an error
        off = np.abs(encode(got.astype(float), coding) - encode(decode(codes, coding), coding))
        assert off.max() < 0.1, coding


def test_encoding_is_right_to_a_tenth_of_a_code_of_ten_bits(device, kernel):
    for coding in codings(depths=(8, 10)):
        linear = decode(all_codes(coding), coding).astype(np.float32)
        got = np.zeros(linear.shape, np.float32)
        run(device, kernel("test_encode", coding.transfer), got, linear, coding)
        assert np.abs(got - encode(linear.astype(float), coding)).max() < 0.1, coding


@pytest.mark.parametrize("transfer", TRANSFERS)
def test_any_light_gives_finite_codes_in_order(device, kernel, transfer):
    coding = Coding(transfer=transfer)
    light = np.concatenate([[0], np.geomspace(1e-30, 1e4, 3000)]).astype(np.float32)
    light = np.concatenate([-light[:0:-1], light])
    linear = np.repeat(light[:, None], 3, axis=1)
    got = np.zeros_like(linear)
    run(device, kernel("test_encode", transfer), got, linear, coding)
    assert np.isfinite(got).all()
    assert (np.diff(got[:, 0]) > -0.01).all()  # rounding of float32


def dim(device, kernel, planes, coding, gain, hw=None):
    """Run test_dim over the first rows and columns of three planes, by default all."""
    height, width = hw or planes[0].shape
    name = "test_dim_8" if planes[0].dtype == np.uint8 else "test_dim_16"
    with on_device(device, *planes) as buffers:
        arguments = [
            *buffers, np.int32(planes[0].shape[1]), np.int32(width), coding_argument(coding),
            np.float32(gain),
        ]  # fmt: skip
        device.launch(kernel(name, coding.transfer), (width, height), arguments)


def test_every_code_returns_to_itself_in_every_coding(device, kernel):
    for coding in codings():
        codes = all_codes(coding)
        # PQ is clipped above 1.25: see test_colour.py
        codes = codes[: coding.max_code + 1] if coding.transfer == PQ else codes
        dtype = np.uint8 if coding.bit_depth == 8 else np.uint16
        planes = [codes[None, :, plane].astype(dtype) for plane in range(3)]
        dim(device, kernel, planes, coding, 1)
        np.testing.assert_array_equal(np.stack(planes, axis=-1)[0], codes, err_msg=str(coding))


@pytest.mark.parametrize("size", [(1, 1), (7, 5), (33, 17)])  # none a multiple of a work-group
def test_matches_numpy_within_one_code_value(device, kernel, size):
    width, height = size
    rng = np.random.default_rng(2)
    for coding in codings():
        dtype = np.uint8 if coding.bit_depth == 8 else np.uint16
        padded = [
            rng.integers(0, coding.max_code + 1, (height + 1, width + 3)).astype(dtype)
            for _ in range(3)
        ]
        before = np.stack(padded, axis=-1).astype(int)
        dim(device, kernel, padded, coding, 0.5, (height, width))
        after = np.stack(padded, axis=-1).astype(int)
        want = before.copy()
        light = decode(before[:height, :width], coding) * np.float32(0.5)
        want[:height, :width] = rounded(encode(light, coding), coding)
        # both round once, but from floats of different widths
        assert np.abs(after - want)[:height, :width].max() <= 1, coding
        after[:height, :width] = before[:height, :width]
        np.testing.assert_array_equal(after, before)  # the gaps between rows stay untouched
