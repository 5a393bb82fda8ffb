from fractions import Fraction

import av
import numpy as np
import pytest
from makeup_video.pipeline import ColourTags, Frame
from makeup_video.pipeline.frames.frame import coding_of
from media import decoded, make_clip, picture

TICK = Fraction(1, 30)


def frame_of(pix_fmt, size_wh=(34, 18)):
    return Frame(picture(3, *size_wh, pix_fmt), 0, TICK, ColourTags())


@pytest.mark.parametrize(
    ("pix_fmt", "chroma", "bit_depth", "shapes"),
    [
        ("yuv420p", (2, 2), 8, [(18, 34), (9, 17), (9, 17)]),
        ("yuvj420p", (2, 2), 8, [(18, 34), (9, 17), (9, 17)]),
        ("yuv422p", (2, 1), 8, [(18, 34), (18, 17), (18, 17)]),
        ("yuv444p", (1, 1), 8, [(18, 34)] * 3),
        ("nv12", (2, 2), 8, [(18, 34), (9, 17, 2)]),
        ("yuv420p10le", (2, 2), 10, [(18, 34), (9, 17), (9, 17)]),
        ("yuv422p12le", (2, 1), 12, [(18, 34), (18, 17), (18, 17)]),
        ("yuva420p", (2, 2), 8, [(18, 34), (9, 17), (9, 17), (18, 34)]),
    ],
)
def test_planes_have_the_shape_and_depth_of_their_layout(pix_fmt, chroma, bit_depth, shapes):
    frame = frame_of(pix_fmt)
    assert (frame.chroma, frame.bit_depth) == (chroma, bit_depth)
    assert [plane.shape for plane in frame.planes] == shapes
    dtype = np.uint8 if bit_depth == 8 else np.uint16
    assert all(plane.dtype == dtype for plane in frame.planes)
    assert max(int(plane.max()) for plane in frame.planes) < 2**bit_depth


def test_a_frame_has_a_picture_of_ffmpeg():
    with pytest.raises(TypeError, match=r"must be an av\.VideoFrame, got ndarray: .*from_ndarray"):
        Frame(np.zeros((18, 34, 3), np.uint8), 0, TICK, ColourTags())


@pytest.mark.parametrize("size_wh", [(1, 1), (3, 5), (33, 17)])
def test_odd_sizes_keep_their_last_chroma_sample(size_wh):
    width, height = size_wh
    shapes = [plane.shape for plane in frame_of("yuv420p", size_wh).planes]
    half = (-(-height // 2), -(-width // 2))
    assert shapes == [(height, width), half, half]


def test_planes_share_the_pictures_memory_read_only():
    frame = frame_of("yuv420p")
    want = frame.picture.to_ndarray()
    np.testing.assert_array_equal(frame.planes[0], want[:18])
    with pytest.raises(ValueError, match="read-only"):
        frame.planes[0][0, 0] = 1


def test_painting_leaves_the_decoders_reference_alone(tmp_path):
    """Later frames are predicted from earlier ones: painting must not change them."""
    src = make_clip(tmp_path / "in.mp4", frames=12)
    clean = [frame.to_ndarray() for frame in decoded(src)]
    with av.open(str(src)) as container:
        for index, shown in enumerate(container.decode(video=0)):
            frame = Frame(shown, index, TICK, ColourTags())
            np.testing.assert_array_equal(shown.to_ndarray(), clean[index])
            frame.writable_planes()[0][10:30, 10:30] = 255
            assert (frame.planes[0][10:30, 10:30] == 255).all()
            assert (shown.to_ndarray()[10:30, 10:30] == 255).all()


@pytest.mark.parametrize("pts", [0, 1001, -7, 10**12 + 1])
def test_seconds_are_those_of_the_fraction(pts):
    base = Fraction(1001, 90000)
    frame = Frame(picture(0, 8, 8), pts, base, ColourTags())
    assert frame.seconds == float(pts * base)


def test_a_frame_prints_its_shape_not_its_pixels():
    text = repr(frame_of("yuv420p"))
    assert "yuv420p 34x18" in text and "pts=0" in text and len(text) < 250


def test_a_wrong_rotation_is_refused():
    with pytest.raises(ValueError, match="0, 90, 180 or 270 degrees, got 45"):
        Frame(picture(0, 8, 8), 0, TICK, ColourTags(), 45)


@pytest.mark.parametrize(
    ("transfer", "hdr"), [(1, False), (2, False), (13, False), (16, True), (18, True)]
)
def test_pq_and_hlg_are_hdr(transfer, hdr):
    assert ColourTags(transfer=transfer).is_hdr is hdr


def test_the_numbers_of_the_tags_are_those_of_h273_in_ffmpeg():
    from av.video.reformatter import ColorPrimaries, ColorRange, Colorspace, ColorTrc

    assert (Colorspace.ITU709, Colorspace.ITU601) == (1, 5)
    assert (ColorRange.MPEG, ColorRange.JPEG) == (1, 2)
    assert (ColorTrc.IEC61966_2_1, ColorTrc.SMPTE2084, ColorTrc.ARIB_STD_B67) == (13, 16, 18)
    assert (ColorPrimaries.BT709, ColorPrimaries.BT2020, ColorPrimaries.SMPTE432) == (1, 9, 12)


def test_frames_can_be_compared_with_or_without_planes_read():
    one = picture(0, 64, 48)
    first, second = (Frame(one, 0, Fraction(1, 30), ColourTags()) for _ in range(2))
    assert first == second and first.planes and second.planes
    assert first == second != Frame(one, 1, Fraction(1, 30), ColourTags())


@pytest.mark.parametrize(
    "pix_fmt",
    [
        "nv21",
        "nv24",
        "p010le",
        "p210le",
        "p416le",
        "yuv444p10msble",
        "yuv420p10be",
        "yuyv422",
        "uyvy422",
        "v30xle",
        "vuya",
        "ya8",
        "rgb24",
        "rgba",
        "gbrp",
        "gbrp10le",
        "pal8",
        "monow",
        "gray32le",
        "grayf32le",
        "grayf16le",
        "xyz12le",
    ],
)
def test_only_planes_of_luma_and_chroma_are_a_frame(pix_fmt):
    with pytest.raises(ValueError, match=f"a frame must have planes .* got {pix_fmt}"):
        Frame(av.VideoFrame(34, 18, pix_fmt), 0, TICK, ColourTags())


@pytest.mark.parametrize("range_", [0, 1, 2])
@pytest.mark.parametrize("pix_fmt", ["yuvj420p", "yuv420p"])
def test_the_name_of_a_format_may_tell_the_range(pix_fmt, range_):
    frame = Frame(picture(3, 34, 18, pix_fmt), 0, TICK, ColourTags(1, range_, 1, 1))
    is_full = range_ == 2 or (range_ == 0 and pix_fmt == "yuvj420p")
    assert coding_of(frame).full_range is is_full
    assert frame.tags == ColourTags(1, 2 if is_full else range_, 1, 1)


@pytest.mark.parametrize(
    ("time_base", "tags", "words"),
    [(1 / 30, ColourTags(), "time_base must be a Fraction"), (TICK, None, "tags must be Colour")],
)
def test_a_time_base_or_tags_of_another_type_are_refused(time_base, tags, words):
    with pytest.raises(TypeError, match=words):
        Frame(picture(3, 34, 18, "yuv420p"), 0, time_base, tags)
