"""Conversion of frames to layouts and sizes that the encoder accepts."""

import av
import numpy as np
import pytest
from av.video.format import names
from hypothesis import given, settings
from hypothesis import strategies as st
from makeup_video.pipeline import DecodeError
from makeup_video.pipeline.frames.frame import plane_views
from makeup_video.pipeline.media.codecs import CODECS
from makeup_video.pipeline.media.pixel_format import ConvertPixelFormat, bits_of, pick_pix_fmt
from media import picture


@pytest.mark.parametrize("name", list(CODECS))
def test_a_picture_that_fits_passes_as_the_same_object(name):
    codec = CODECS[name]
    for pix_fmt in codec.pix_fmts:
        frame, convert = picture(0, 64, 48, pix_fmt), ConvertPixelFormat(codec, bits_of(pix_fmt))
        assert convert(frame) is frame
        assert convert.conversions == convert.dropped == []


@given(width=st.integers(1, 40), height=st.integers(1, 40),
       pix_fmt=st.sampled_from(
           ["yuv420p", "yuv422p", "yuv444p", "yuv420p10le", "nv12"]))  # fmt: skip
@settings(deadline=None)
def test_padding_repeats_the_edge_and_keeps_every_pixel(width, height, pix_fmt):
    frame = picture(1, width, height, pix_fmt)
    frame.pts = 7
    depth = bits_of(pix_fmt)
    out = ConvertPixelFormat(CODECS["h264"], depth)(frame)
    for old, new in zip(plane_views(frame, depth), plane_views(out, depth), strict=True):
        rows, columns = old.shape[:2]
        assert 0 <= new.shape[0] - rows <= 1 and 0 <= new.shape[1] - columns <= 1
        np.testing.assert_array_equal(new[:rows, :columns], old)
        np.testing.assert_array_equal(new[-1, :columns], old[-1])
        np.testing.assert_array_equal(new[:rows, -1], old[:, -1])
    assert out.pts == 7
    across, down = {"yuv420p": (2, 2), "yuv422p": (2, 1), "yuv444p": (1, 1)}.get(pix_fmt, (2, 2))
    assert (out.width % across, out.height % down) == (0, 0)


@pytest.mark.parametrize(("pix_fmt", "codec"), [("yuvj420p", "vp9"), ("yuvj444p", "ffv1")])
def test_a_full_range_layout_keeps_its_numbers(pix_fmt, codec):
    frame, convert = picture(2, 64, 48, pix_fmt), ConvertPixelFormat(CODECS[codec])
    out = convert(frame)
    assert convert.conversions == convert.unasked == []
    assert out.color_range == 2 and not out.format.name.startswith("yuvj")
    for old, new in zip(plane_views(frame, 8), plane_views(out, 8), strict=True):
        np.testing.assert_array_equal(new, old)


@pytest.mark.parametrize("pix_fmt", ["yuv420p", "yuvj420p", "yuv422p10le", "yuv444p12le"])
def test_prores_gets_full_range_as_limited(pix_fmt):
    frame, convert = picture(2, 64, 48, pix_fmt), ConvertPixelFormat(CODECS["prores"])
    depth = bits_of(pix_fmt)
    old = plane_views(frame, depth)[0] / 2 ** (depth - 8)
    frame.color_range = 2
    out = convert(frame)
    assert out.color_range == 1
    assert [line[:21] for line in convert.unasked][-1] == "range full -> limited"
    new = plane_views(out, 10)[0] / 4
    assert np.abs(new - (16 + old * 219 / 255)).max() < 1


def test_prores_keeps_the_numbers_of_limited_range():
    frame, convert = picture(2, 64, 48, "yuv422p10le"), ConvertPixelFormat(CODECS["prores"])
    frame.color_range = 1
    assert convert(frame) is frame and convert.conversions == []


@pytest.mark.parametrize("pix_fmt", ["gbrp", "bgra", "rgb24", "rgb8", "pal8"])
def test_rgb_becomes_the_h264_that_players_take(pix_fmt):
    for depth in (None, 8):
        convert = ConvertPixelFormat(CODECS["h264"], depth)
        assert convert(av.VideoFrame(64, 48, pix_fmt)).format.name == "yuv420p"
        assert convert.conversions == [
            f"pixels {pix_fmt} -> yuv420p (few players can show 4:4:4 in h264)"
        ]
    for codec, depth in (("h264", 10), ("hevc", None), ("ffv1", None)):
        out = ConvertPixelFormat(CODECS[codec], depth)(picture(0, 64, 48, "gbrp"))
        assert out.format.name.startswith("yuv444p")


def test_a_deeper_layout_keeps_its_numbers_scaled():
    frame = picture(2, 64, 48, "yuv422p10le")
    out = ConvertPixelFormat(CODECS["vp9"])(frame)
    for old, new in zip(plane_views(frame, 10), plane_views(out, 8), strict=True):
        assert np.abs(new.astype(float) - old / 4).max() <= 1  # rounding, or a dither


def test_rgb_becomes_bt709_and_is_tagged_so():
    frame = picture(2, 64, 48, "gbrp")
    out = ConvertPixelFormat(CODECS["vp9"])(frame)
    assert (out.format.name, out.colorspace, out.color_range) == ("yuv444p", 1, 1)
    green, blue, red = (plane.astype(float) for plane in plane_views(frame, 8))
    want = 16 + 219 / 255 * (0.2126 * red + 0.7152 * green + 0.0722 * blue)
    assert np.abs(plane_views(out, 8)[0] - want).max() < 1.5


@pytest.mark.parametrize("change", [(64, 50, "yuv420p"), (66, 48, "yuv420p"), (64, 48, "yuv422p")])
def test_a_change_of_size_or_layout_names_both_and_the_place(change):
    convert = ConvertPixelFormat(CODECS["h264"])
    convert(picture(0, 64, 48))
    with pytest.raises(DecodeError, match=r"from 64x48 yuv420p to .* at 47\.12 s: one output"):
        convert(picture(1, *change), 47.1234)
    with pytest.raises(DecodeError, match=r"from 64x48 yuv420p to [^ ]* [^ ]*: one output"):
        convert(picture(1, *change))


@pytest.mark.parametrize("size_wh", [(854, 480), (566, 1006)])
def test_a_picture_gets_the_same_10_bits_each_time(size_wh):
    """With several threads, FFmpeg's converter wrote random pixels; junk in memory made it show."""
    rng, seen = np.random.default_rng(0), set()
    frame = picture(3, *size_wh, "bgr0")
    for _ in range(20):
        junk = [rng.integers(0, 255, n, np.uint8) for n in (1000, 5000, 20000, 100000, 600000)]
        del junk
        out = ConvertPixelFormat(CODECS["ffv1"], 10)(frame)
        seen.add(b"".join(plane.tobytes() for plane in plane_views(out, 10)))
    assert len(seen) == 1


@pytest.mark.parametrize("codec", CODECS.values(), ids=lambda codec: codec.name)
def test_grey_pictures_get_no_chroma_that_they_do_not_need(codec):
    grey = [name for name in names if name.startswith(("gray", "ya8", "ya16", "yaf"))]
    assert {"gray", "gray16le", "grayf32le", "ya8"} <= set(grey)
    colourful = pick_pix_fmt("yuv420p", codec), pick_pix_fmt("yuva420p", codec)
    for name in grey:
        chosen = pick_pix_fmt(name, codec)
        plain = colourful[name.startswith("ya")]
        # ProRes has neither 4:2:0 nor transparency in 4:2:2; deep 4:2:0 has no transparency in FFV1
        assert chosen[:7] == plain[:7] or codec.name in ("prores", "ffv1"), (name, chosen)
        assert not chosen.startswith("yuvj")
