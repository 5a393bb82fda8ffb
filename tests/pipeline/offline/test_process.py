"""Whole files through the whole pipeline: everything in the input reaches the output."""

import os
from fractions import Fraction
from itertools import pairwise

import av
import numpy as np
import pytest
from av.video.reformatter import ColorPrimaries, ColorRange, Colorspace, ColorTrc
from makeup_video.pipeline import Settings, UsageError, process_video
from media import add_video, decoded, encode_frames, make_clip, packets_of, times_of
from whole_files import HALF_TICK_MKV, through

QUICK = {"h264": "ultrafast", "hevc": "ultrafast", "av1": "13", "vp9": "8"}


def assert_same_times(src, dst):
    want, got = times_of(src), times_of(dst)
    if dst.suffix in (".mkv", ".webm"):
        assert all(abs(a - b) <= HALF_TICK_MKV for a, b in zip(want, got, strict=True))
        assert all(a < b for a, b in pairwise(got))
    else:
        assert got == want


@pytest.mark.parametrize("end", [".mp4", ".mkv", ".mov", ".webm"])
@pytest.mark.parametrize(
    ("codec", "name"),
    [
        ("h264", "in.mp4"), ("h264", "in.mov"), ("h264", "in.mkv"), ("h264", "in.avi"),
        ("hevc", "in.mp4"), ("hevc", "in.mkv"), ("vp9", "in.webm"), ("vp9", "in.mkv"),
        ("av1", "in.webm"), ("av1", "in.mp4"), ("mpeg4", "in.avi"), ("mpeg4", "in.mp4"),
    ],
)  # fmt: skip
def test_every_codec_and_container_keeps_its_times(tmp_path, codec, name, end):
    src = make_clip(tmp_path / name, codec)
    through(src, tmp_path / f"out{end}")
    assert_same_times(src, tmp_path / f"out{end}")


@pytest.mark.parametrize(
    ("codec", "end"),
    [("h264", ".mp4"), ("hevc", ".mp4"), ("av1", ".mp4"), ("vp9", ".mp4"), ("av1", ".webm"),
     ("ffv1", ".mkv"), ("prores", ".mov"), ("prores", ".mkv"), ("h264", ".m4v")],
)  # fmt: skip
def test_every_output_codec_is_what_was_asked_for(tmp_path, codec, end):
    src, dst = make_clip(tmp_path / "in.mp4"), tmp_path / f"out{end}"
    report = through(src, dst, codec=codec, preset=QUICK.get(codec))
    assert_same_times(src, dst)
    decoder = {"av1": "libdav1d"}.get(codec, codec)
    with av.open(str(dst)) as container:
        assert container.streams.video[0].codec_context.name == decoder
    assert report.codec == codec


@pytest.mark.parametrize("end", [".mp4", ".mov", ".mkv", ".webm"])
@pytest.mark.parametrize("first", [0, 1, 50017, 9_000_000])
def test_variable_frame_rate_and_any_start_keep_every_time(tmp_path, end, first):
    rng = np.random.default_rng(first)
    pts = (first + np.cumsum(rng.integers(1, 4000, 20))).tolist()
    pts[0] = first
    src = make_clip(
        tmp_path / "in.mp4",
        pts=pts,
        time_base=Fraction(1, 90000),
        options={"bf": "2"},
        container_options={"movie_timescale": "90000"},
    )
    assert times_of(src)[0] == Fraction(first, 90000)
    report = through(src, tmp_path / f"out{end}")
    if end in (".mp4", ".mov"):
        assert_same_times(src, tmp_path / f"out{end}")
        assert report.max_pts_error_seconds == 0
    else:
        got = times_of(tmp_path / f"out{end}")
        assert all(a < b for a, b in pairwise(got))


@pytest.mark.parametrize("end", [".mp4", ".mov", ".mkv", ".webm"])
@pytest.mark.parametrize("rate", [(24000, 1001), (30000, 1001), (60000, 1001), (25, 1)])
@pytest.mark.parametrize("b_frames", ["0", "3"])
def test_broadcast_rates_and_b_frames_are_exact(tmp_path, end, rate, b_frames):
    src = make_clip(tmp_path / "in.mp4", rate=Fraction(*rate), options={"bf": b_frames})
    dst = tmp_path / f"out{end}"
    through(src, dst)
    assert_same_times(src, dst)
    with av.open(str(dst)) as container:
        assert float(container.streams.video[0].average_rate) == pytest.approx(
            rate[0] / rate[1], rel=0.04
        )


def test_the_last_frame_keeps_its_length(tmp_path):
    src, dst = make_clip(tmp_path / "in.mp4", frames=10), tmp_path / "out.mp4"
    through(src, dst)
    with av.open(str(src)) as source, av.open(str(dst)) as output:
        a, b = source.streams.video[0], output.streams.video[0]
        assert a.duration * a.time_base == b.duration * b.time_base == Fraction(10, 30)


@pytest.mark.parametrize("end", [".mp4", ".mov", ".mkv", ".webm"])
@pytest.mark.parametrize("tick", [Fraction(1, 10), Fraction(1, 30), Fraction(1, 90000)])
def test_the_length_of_the_file_is_the_length_of_the_source(tmp_path, end, tick):
    pts = [
        round(seconds / tick)
        for seconds in (0, Fraction(1, 10), Fraction(1, 5), Fraction(3, 10), 5)
    ]
    src = make_clip(tmp_path / "in.mp4", pts=pts, time_base=tick)
    process_video(src, tmp_path / f"out{end}")
    with av.open(str(src)) as source, av.open(str(tmp_path / f"out{end}")) as output:
        assert output.duration == pytest.approx(source.duration, abs=2000)  # microseconds


def test_every_frame_keeps_its_picture_in_order(tmp_path):
    src, dst = make_clip(tmp_path / "in.mp4", frames=30), tmp_path / "out.mkv"
    through(src, dst, codec="ffv1")
    for old, new in zip(decoded(src), decoded(dst), strict=True):
        np.testing.assert_array_equal(old.to_ndarray(), new.to_ndarray())


@pytest.mark.parametrize("end", [".mp4", ".mov", ".mkv"])
@pytest.mark.parametrize("degrees", [90, 180, 270])
def test_rotation_is_kept_and_the_picture_is_not_turned(tmp_path, end, degrees):
    src = make_clip(tmp_path / "in.mp4", rotation_degrees=degrees)
    through(src, tmp_path / f"out{end}")
    old, new = decoded(src)[0], decoded(tmp_path / f"out{end}")[0]
    assert new.rotation % 360 == old.rotation % 360 == degrees
    assert (new.width, new.height) == (old.width, old.height)


@pytest.mark.parametrize("end", [".mp4", ".mov", ".mkv", ".webm"])
@pytest.mark.parametrize("aspect", [Fraction(4, 3), Fraction(8, 9), Fraction(64, 45)])
def test_sample_aspect_ratio_is_kept(tmp_path, end, aspect):
    src = make_clip(tmp_path / "in.mp4", sample_aspect_ratio=aspect)
    through(src, tmp_path / f"out{end}")
    with av.open(str(tmp_path / f"out{end}")) as container:
        # webm and mkv store the display size in whole pixels
        assert float(container.streams.video[0].sample_aspect_ratio) == pytest.approx(
            float(aspect), rel=0.01
        )


@pytest.mark.parametrize(
    "codec_end", [("h264", ".mp4"), ("hevc", ".mp4"), ("av1", ".mp4"), ("vp9", ".webm"),
                  ("ffv1", ".mkv"), ("prores", ".mov")],
)  # fmt: skip
@pytest.mark.parametrize(
    "tags",
    [
        (Colorspace.ITU709, ColorRange.MPEG, ColorTrc.BT709, ColorPrimaries.BT709),
        (Colorspace.SMPTE170M, ColorRange.MPEG, ColorTrc.SMPTE170M, ColorPrimaries.SMPTE170M),
        (9, ColorRange.MPEG, 14, 9),  # BT.2020
        (Colorspace.ITU709, ColorRange.JPEG, ColorTrc.BT709, ColorPrimaries.BT709),
    ],
    ids=["bt709", "bt601", "bt2020", "full-range"],
)
def test_colour_tags_are_kept_and_numbers_are_not_converted(tmp_path, tags, codec_end):
    matrix, span, transfer, primaries = (int(tag) for tag in tags)
    src = make_clip(
        tmp_path / "in.mkv", "ffv1", frames=3,
        colorspace=matrix, color_range=span, color_trc=transfer, color_primaries=primaries,
    )  # fmt: skip
    codec, end = codec_end
    report = through(src, tmp_path / f"out{end}", codec=codec)
    old, new = decoded(src)[0], decoded(tmp_path / f"out{end}")[0]
    got = (new.colorspace, new.color_range, new.color_trc, new.color_primaries)
    mean_old = np.frombuffer(old.planes[0], np.uint8).reshape(64, -1)[:, :96].mean()
    if codec == "prores" and span == ColorRange.JPEG:
        assert any(line.startswith("range full -> limited") for line in report.conversions)
        span, mean_old = ColorRange.MPEG, 16 + mean_old * 219 / 255
    assert got == (matrix, span, transfer, primaries)
    shift = 2 if codec == "prores" else 0
    dtype = np.uint16 if codec == "prores" else np.uint8
    plane = np.frombuffer(new.planes[0], dtype).reshape(64, -1)[:, :96]
    assert abs(plane.mean() / 2**shift - mean_old) < 2


@pytest.mark.parametrize("end", [".mp4", ".mkv", ".mov"])
def test_full_range_yuvj_stays_full_range(tmp_path, end):
    src = make_clip(tmp_path / "in.mp4", pix_fmt="yuvj420p", color_range=2)
    report = through(src, tmp_path / f"out{end}")
    assert decoded(tmp_path / f"out{end}")[0].color_range == ColorRange.JPEG
    assert report.conversions == []


@pytest.mark.parametrize(
    ("pix_fmt", "end"),
    [("yuv420p10le", ".mp4"), ("yuv422p10le", ".mov"), ("yuv444p10le", ".mkv"),
     ("yuv422p", ".mp4"), ("yuv444p", ".mkv"), ("yuv420p12le", ".mkv")],
)  # fmt: skip
def test_depth_and_chroma_are_kept_without_conversion(tmp_path, pix_fmt, end):
    src = make_clip(tmp_path / "in.mkv", "ffv1", pix_fmt=pix_fmt)
    report = through(src, tmp_path / f"out{end}")
    assert decoded(tmp_path / f"out{end}")[0].format.name == pix_fmt
    assert report.conversions == []
    assert report.codec == ("hevc" if "10" in pix_fmt or "12" in pix_fmt else "h264")


def test_ten_bit_into_webm_becomes_ten_bit_av1(tmp_path):
    src = make_clip(tmp_path / "in.mkv", "ffv1", pix_fmt="yuv420p10le")
    assert through(src, tmp_path / "out.webm").codec == "av1"
    assert decoded(tmp_path / "out.webm")[0].format.name == "yuv420p10le"


@pytest.mark.parametrize("codec", ["vp9", "av1", "h264", "hevc"])
def test_layouts_that_do_not_fit_are_converted_and_reported(tmp_path, codec):
    src = make_clip(tmp_path / "in.mkv", "ffv1", pix_fmt="yuv444p16le")
    report = through(src, tmp_path / "out.mkv", codec=codec)
    new = decoded(tmp_path / "out.mkv")[0].format.name
    (conversion,) = report.conversions
    assert conversion.startswith(f"pixels yuv444p16le -> {new}")
    assert ("a bit depth of 10 keeps more" in conversion) == (codec == "h264")


@pytest.mark.parametrize("pix_fmt", ["bgra", "gbrp10le", "gray", "ya8", "yuv410p", "yuv411p"])
def test_unusual_layouts_come_out_looking_the_same(tmp_path, pix_fmt):
    src = make_clip(tmp_path / "in.mkv", "ffv1", pix_fmt=pix_fmt, size_wh=(128, 64))
    report = through(src, tmp_path / "out.mp4", crf=1)
    assert len(report.conversions) == 1
    old = decoded(src)[5].reformat(format="rgb24").to_ndarray().astype(int)
    new = decoded(tmp_path / "out.mp4")[5].reformat(format="rgb24").to_ndarray().astype(int)
    assert np.abs(old - new).mean() < 6


@pytest.mark.parametrize("size_wh", [(97, 65), (96, 65), (97, 64), (1, 1), (3, 2)])
@pytest.mark.parametrize("codec_end", [("h264", ".mp4"), ("hevc", ".mp4"), ("vp9", ".webm")])
def test_odd_sizes_are_kept(tmp_path, size_wh, codec_end):
    codec, end = codec_end
    if codec == "hevc" and size_wh[0] < 32:
        pytest.skip("x265 refuses sizes under 32 px; test_encode checks that refusal")
    src = make_clip(tmp_path / "in.mkv", "ffv1", size_wh=size_wh)
    report = through(src, tmp_path / f"out{end}", codec=codec, preset=QUICK[codec])
    new = decoded(tmp_path / f"out{end}")[0]
    if codec == "vp9":
        assert (new.width, new.height) == size_wh
        return
    even = tuple(n + n % 2 for n in size_wh)
    assert (new.width, new.height) == even
    if even != size_wh:
        assert len(report.conversions) == 1
        luma = np.frombuffer(new.planes[0], np.uint8).reshape(new.height, -1)[:, : new.width]
        assert np.abs(luma[-1].astype(int) - luma[-1 - size_wh[1] % 2]).max() < 24


@pytest.mark.parametrize(
    ("pix_fmt", "codec", "end"),
    [("yuva420p", None, ".webm"), ("yuva444p10le", None, ".mov"), ("bgra", "ffv1", ".mkv"),
     ("yuva420p", None, ".mkv")],
)  # fmt: skip
def test_alpha_is_kept_where_codec_and_container_can(tmp_path, pix_fmt, codec, end):
    src = make_clip(tmp_path / "in.mkv", "ffv1", pix_fmt=pix_fmt)
    through(src, tmp_path / f"out{end}", codec=codec)
    lossless = through(tmp_path / f"out{end}", tmp_path / "again.mkv", codec="ffv1")
    assert lossless.dropped == []
    assert decoded(tmp_path / "again.mkv")[0].format.name.startswith("yuva")


def test_alpha_that_cannot_be_kept_is_reported(tmp_path):
    src = make_clip(tmp_path / "in.mkv", "ffv1", pix_fmt="yuva420p")
    report = through(src, tmp_path / "out.mp4")
    assert any("transparency" in text for text in report.dropped)


@pytest.mark.parametrize("codec_end", [("h264", ".mp4"), ("prores", ".mov"), ("ffv1", ".mkv")])
@pytest.mark.parametrize("top_first", [True, False])
def test_interlaced_sources_keep_their_field_order(tmp_path, codec_end, top_first):
    codec, end = codec_end
    src = tmp_path / "in.mp4"
    order = "tff=1" if top_first else "bff=1"
    make_clip(src, options={"x264-params": order}, flags=1 << 18 | 1 << 29)
    assert all(frame.interlaced_frame for frame in decoded(src))
    through(src, tmp_path / f"out{end}", codec=codec)
    dst = tmp_path / f"out{end}"
    assert all(frame.interlaced_frame for frame in decoded(dst))
    with av.open(str(src)) as source, av.open(str(dst)) as output:
        next(source.decode(video=0)), next(output.decode(video=0))
        orders = [c.streams.video[0].codec_context.field_order for c in (source, output)]
    assert orders[0] == orders[1] or codec == "ffv1"


@pytest.mark.parametrize("codec", ["hevc", "vp9", "av1"])
def test_codecs_without_fields_refuse_interlaced_videos(tmp_path, codec):
    src = make_clip(tmp_path / "in.mp4", options={"x264-params": "tff=1"}, flags=1 << 18 | 1 << 29)
    with pytest.raises(UsageError, match="interlaced"):
        process_video(src, tmp_path / "out.mp4", None, Settings(codec=codec))
    assert os.listdir(tmp_path) == ["in.mp4"]


def test_a_video_without_audio_is_accepted(tmp_path):
    src = make_clip(tmp_path / "in.mp4")
    through(src, tmp_path / "out.mp4")
    with av.open(str(tmp_path / "out.mp4")) as container:
        assert [s.type for s in container.streams] == ["video"]


def test_a_second_video_stream_is_copied_bit_for_bit(tmp_path):
    src, dst = tmp_path / "in.mp4", tmp_path / "out.mp4"
    with av.open(str(src), "w") as out:
        first, second = add_video(out, size_wh=(128, 96)), add_video(out, size_wh=(64, 48))
        encode_frames(out, first, range(10))
        encode_frames(out, second, range(10))
    through(src, dst)
    assert packets_of(src, "video", 1) == packets_of(dst, "video", 1)
