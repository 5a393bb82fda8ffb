"""Preview JPEGs of planes: a browser shows the colours of the renderer's own conversion."""

import cv2
import numpy as np
import pytest
import simplejpeg
from hypothesis import given
from hypothesis import strategies as st
from makeup_video.kernels.colour import (
    HLG,
    LUMA_WEIGHTS,
    PQ,
    SRGB,
    Coding,
    encode,
    from_srgb_primaries,
    matrices,
    rounded,
    to_linear,
)
from makeup_video.pipeline import UsageError
from makeup_video.pipeline.frames.colour_tags import ColourTags
from makeup_video.pipeline.images.jpeg import PreviewJpeg

LAYOUTS = [(1, 1), (2, 1), (2, 2), (1, 2), (4, 1), (4, 4)]


def planes_of(rgb: np.ndarray, coding: Coding, chroma: tuple[int, int]) -> list[np.ndarray]:
    """Return the planes of R'G'B' (H, W, 3) in 0..1, with chroma in the middle of its block."""
    _, to_codes = matrices(coding)
    codes = rgb @ to_codes[:, :3].T + to_codes[:, 3]
    dtype = np.uint8 if coding.bit_depth == 8 else np.uint16
    luma, *rest = np.moveaxis(rounded(codes, coding).astype(dtype), -1, 0)
    across, down = chroma
    size = -(-rgb.shape[1] // across), -(-rgb.shape[0] // down)
    small = [
        cv2.resize(np.ascontiguousarray(plane), size, interpolation=cv2.INTER_AREA)
        for plane in rest
    ]
    return [np.ascontiguousarray(luma), *small]


def tags_of(coding: Coding) -> ColourTags:
    return ColourTags(coding.matrix, 2 if coding.full_range else 1)


def smooth(width: int, height: int) -> np.ndarray:
    """Return a smooth gradient of R'G'B' (H, W, 3) in 0..1."""
    y, x = np.mgrid[:height, :width] / max(width, height)
    return np.stack([0.25 + 0.5 * x, 0.7 - 0.4 * y, 0.3 + 0.3 * x * y], -1)


def decoded(jpeg: bytes) -> np.ndarray:
    """Decode a JPEG to R'G'B' (H, W, 3), float64, 0..255."""
    return simplejpeg.decode_jpeg(jpeg).astype(float)


@pytest.mark.parametrize("chroma", LAYOUTS)
@pytest.mark.parametrize("matrix", LUMA_WEIGHTS)
@pytest.mark.parametrize("full_range", [False, True])
@pytest.mark.parametrize("bit_depth", [8, 10, 12])
def test_a_browser_sees_what_the_renderer_painted(chroma, matrix, full_range, bit_depth):
    coding = Coding(matrix, full_range, bit_depth=bit_depth)
    rgb = smooth(160, 96)
    jpeg = PreviewJpeg(95)(planes_of(rgb, coding, chroma), chroma, bit_depth, tags_of(coding))
    error = np.abs(decoded(jpeg) - rgb * 255)
    assert error.mean() < 1.5
    assert error.max() < 8


@given(
    colour=st.tuples(*[st.integers(0, 255)] * 3),
    size_wh=st.tuples(st.integers(1, 40), st.integers(1, 40)),
    chroma=st.sampled_from(LAYOUTS),
    matrix=st.sampled_from(sorted(LUMA_WEIGHTS)),
    full_range=st.booleans(),
    bit_depth=st.sampled_from([8, 10]),
)
def test_any_flat_colour_of_any_size_keeps_its_codes(
    colour, size_wh, chroma, matrix, full_range, bit_depth
):
    coding = Coding(matrix, full_range, bit_depth=bit_depth)
    rgb = np.broadcast_to(np.array(colour) / 255, (*size_wh[::-1], 3))
    planes = planes_of(rgb, coding, chroma)
    before = [plane.copy() for plane in planes]
    for plane in planes:
        plane.flags.writeable = False
    got = decoded(PreviewJpeg(100)(planes, chroma, bit_depth, tags_of(coding)))
    assert got.shape == rgb.shape
    assert np.abs(got - colour).max() <= 5
    assert all(np.array_equal(now, was) for now, was in zip(planes, before, strict=True))


def test_what_a_camera_sends_as_mjpeg_is_encoded_as_it_is():
    coding = Coding(5, True)
    planes = planes_of(smooth(64, 48), coding, (2, 1))
    jpeg = PreviewJpeg(85)(planes, (2, 1), 8, tags_of(coding))
    assert jpeg == simplejpeg.encode_jpeg_yuv_planes(*planes, quality=85)
    assert simplejpeg.decode_jpeg_header(jpeg) == (48, 64, "YCbCr", "422")


@pytest.mark.parametrize("full_range", [False, True])
def test_interleaved_chroma_gives_the_same_jpeg_as_planar(full_range):
    coding = Coding(1, full_range)
    luma, cb, cr = planes_of(smooth(66, 50), coding, (2, 2))
    planar = PreviewJpeg(85)([luma, cb, cr], (2, 2), 8, tags_of(coding))
    assert PreviewJpeg(85)([luma, np.dstack([cb, cr])], (2, 2), 8, tags_of(coding)) == planar


@pytest.mark.parametrize(("range_", "codes"), [(2, (0, 255)), (1, (16, 235)), (0, (16, 235))])
def test_a_grey_frame_spans_black_to_white(range_, codes):
    luma = np.repeat(np.array(codes, np.uint8), 32)[None].repeat(64, 0)
    got = decoded(PreviewJpeg(95)([luma], (1, 1), 8, ColourTags(range=range_)))
    assert got[:, 0].max() <= 1 and got[:, -1].min() >= 254


def test_missing_tags_are_resolved_as_the_renderer_does():
    for width, matrix in ((640, 6), (1280, 1)):
        planes = planes_of(smooth(width, 360), Coding(matrix), (2, 2))
        tagged = PreviewJpeg(85)(planes, (2, 2), 8, ColourTags(matrix, 1))
        assert PreviewJpeg(85)(planes, (2, 2), 8, ColourTags()) == tagged


def test_an_alpha_plane_and_padding_do_not_matter():
    planes = planes_of(smooth(64, 48), Coding(1), (2, 2))
    want = PreviewJpeg(85)(planes, (2, 2), 8, ColourTags(1, 1))
    padded = [np.pad(plane, ((0, 0), (0, 32)))[:, : plane.shape[1]] for plane in planes]
    assert PreviewJpeg(85)([*padded, planes[0]], (2, 2), 8, ColourTags(1, 1)) == want


@pytest.mark.parametrize("chroma", [(1, 1), (2, 1), (2, 2), (4, 1)])
@pytest.mark.parametrize(
    ("size_wh", "want"),
    [
        ((400, 224), (200, 112)),
        ((202, 330), (100, 164)),
        ((201, 90), (100, 44)),
        ((801, 90), (200, 22)),
    ],
)
def test_long_sides_are_halved_until_they_fit(chroma, size_wh, want):
    rgb = smooth(*size_wh)
    planes = planes_of(rgb, Coding(1), chroma)
    got = decoded(PreviewJpeg(95, limit_px=200)(planes, chroma, 8, ColourTags(1, 1)))
    assert abs(got.shape[1] - want[0]) <= 2 and abs(got.shape[0] - want[1]) <= 2
    halved = cv2.resize(rgb, got.shape[1::-1], interpolation=cv2.INTER_AREA) * 255
    assert np.abs(got - halved).mean() < 2.5


@pytest.mark.parametrize("transfer", [PQ, HLG])
@pytest.mark.parametrize("bit_depth", [8, 10])
@pytest.mark.parametrize(
    ("colour", "within"),
    [((128, 128, 128), 3), ((16, 16, 16), 4), ((90, 56, 40), 12), ((180, 130, 112), 12)],
)
def test_hdr_looks_as_it_would_in_srgb(transfer, bit_depth, colour, within):
    coding = Coding(9, False, transfer, 9, bit_depth)
    linear = from_srgb_primaries(9) @ to_linear(np.array(colour) / 255, SRGB)
    codes = rounded(encode(linear, coding), coding).astype(
        np.uint8 if bit_depth == 8 else np.uint16
    )
    planes = [
        np.full((32 // by, 32 // by), code) for by, code in zip((1, 2, 2), codes, strict=True)
    ]
    got = decoded(PreviewJpeg(100)(planes, (2, 2), bit_depth, ColourTags(9, 1, transfer, 9)))
    assert np.abs(got - colour).max() <= within


@pytest.mark.parametrize("transfer", [PQ, HLG])
def test_hdr_highlights_roll_off_and_never_turn_back(transfer):
    luma = np.arange(1024, dtype=np.uint16)[None].repeat(16, 0)
    got = decoded(PreviewJpeg(100)([luma], (1, 1), 10, ColourTags(9, 1, transfer, 9)))[8, :, 1]
    assert (np.diff(got[::16]) >= -1).all()
    assert got[0] <= 1 and got[-1] >= 250


def test_matrices_that_do_not_encode_rgb_are_refused():
    planes = planes_of(smooth(32, 32), Coding(1), (2, 2))
    with pytest.raises(UsageError, match="matrix 14"):
        PreviewJpeg(85)(planes, (2, 2), 8, ColourTags(matrix=14))
