"""Whole HDR videos converted to SDR: frames, tags, times and what the run reports."""

from fractions import Fraction

import av
import numpy as np
import pytest
from makeup_video.kernels.colour import (
    HLG,
    PQ,
    SRGB,
    Coding,
    encode,
    from_srgb_primaries,
    matrices,
    rounded,
)
from makeup_video.pipeline import OutputError, Settings, UsageError, process_video
from makeup_video.pipeline.frames.frame import plane_views
from makeup_video.pipeline.media.codecs import CODECS
from makeup_video.pipeline.media.pixel_format import ConvertPixelFormat
from makeup_video.pipeline.media.to_sdr import ToSdr
from makeup_video.pipeline.media.tone_map import to_sdr
from media import decoded, make_clip, picture, times_of

PEAK = 1000 / 203


def hdr_frame(rgb, transfer, pix_fmt="yuv444p10le", *, full_range=False):
    """Make a BT.2020 frame of (H, W, 3) linear light in sRGB primaries, where 1 is white.

    Returns the frame, its (H, W, 3) codes and their coding.
    """
    coding = Coding(9, full_range, transfer, 9, 10)
    codes = rounded(encode(rgb @ from_srgb_primaries(9).T, coding), coding)
    frame = picture(0, rgb.shape[1], rgb.shape[0], pix_fmt)
    for plane, values in zip(plane_views(frame, 10), np.moveaxis(codes, 2, 0), strict=True):
        plane[:] = values[: plane.shape[0], : plane.shape[1]]
    frame.colorspace, frame.color_primaries, frame.color_trc = 9, 9, transfer
    frame.color_range = 2 if full_range else 1
    frame.pts, frame.time_base = 7, Fraction(1, 25)
    return frame, codes, coding


@pytest.mark.parametrize("transfer", [PQ, HLG])
@pytest.mark.parametrize("full_range", [False, True])
def test_pixels_are_what_the_curve_makes_of_them(transfer, full_range):
    rgb = np.random.default_rng(4).uniform(0.02, 2.0, (48, 64, 3))
    frame, codes, coding = hdr_frame(rgb, transfer, full_range=full_range)
    out = ToSdr(frame, "yuv444p")(frame)
    to_rgb = matrices(coding)[0]
    rgb_encoded = np.clip(codes @ to_rgb[:, :3].T + to_rgb[:, 3], 0, 1)
    sdr = matrices(Coding(1, False, SRGB, 1, 8))[1]
    want = to_sdr(rgb_encoded, transfer, 9, PEAK) @ sdr[:, :3].T + sdr[:, 3]
    got = np.stack([plane.astype(float) for plane in plane_views(out, 8)], -1)
    # tolerance: a table of 65 entries per axis, 10 bits in between, and a dither
    assert np.abs(got - want).mean() < 0.8 and np.percentile(np.abs(got - want), 99) <= 4


def test_the_sdr_frame_is_tagged_bt709_and_keeps_its_time():
    frame, *_ = hdr_frame(np.full((48, 64, 3), 0.5), PQ)
    out = ToSdr(frame, "yuv420p")(frame)
    assert out.format.name == "yuv420p" and (out.pts, out.time_base) == (7, Fraction(1, 25))
    assert (out.colorspace, out.color_trc, out.color_primaries, out.color_range) == (1, 1, 1, 1)


def test_no_room_for_the_table_is_one_line(monkeypatch, tmp_path):
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path / "gone"))
    frame, *_ = hdr_frame(np.full((48, 64, 3), 0.5), PQ)
    with pytest.raises(OutputError, match="takes no temporary file"):
        ToSdr(frame, "yuv420p")


def test_a_full_disk_keeps_no_piece_of_the_table(monkeypatch, tmp_path):
    resource = pytest.importorskip("resource")
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    frame, *_ = hdr_frame(np.full((48, 64, 3), 0.5), PQ)
    allowed = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (1_000_000, allowed[1]))
    try:
        with pytest.raises(OutputError, match="takes no temporary file"):
            ToSdr(frame, "yuv420p")
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, allowed)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("name", ["a:b", "it's", "a,b;[c]", "a\\b", "a=b %d"])
def test_the_folder_of_temporary_files_may_have_any_name(monkeypatch, tmp_path, name):
    (tmp_path / name).mkdir()
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path / name))
    frame, *_ = hdr_frame(np.full((48, 64, 3), 0.5), PQ)
    assert ToSdr(frame, "yuv420p")(frame).color_trc == 1
    assert not list((tmp_path / name).iterdir())


def hdr_clip(path, **more):
    return make_clip(
        path, "hevc", pix_fmt="yuv420p10le", colorspace=9, color_range=1, color_trc=16,
        color_primaries=9, frames=8, pts=(0, 1, 2, 5, 6, 9, 10, 11), **more,
    )  # fmt: skip


MASTER = (
    "log-level=none:master-display=G(13250,34500)B(7500,3000)R(34000,16000)WP(15635,16450)"
    "L(40000000,50):max-cll=0,0"
)


@pytest.mark.parametrize("end", [".mp4", ".mov", ".mkv", ".webm"])
def test_a_video_becomes_eight_bit_sdr_with_all_its_times(tmp_path, end):
    src = hdr_clip(tmp_path / "in.mp4", options={"x265-params": MASTER})
    dst = tmp_path / f"out{end}"
    report = process_video(src, dst, None, Settings(sdr=True))
    assert report.codec == ("vp9" if end == ".webm" else "h264")
    frame = decoded(dst)[0]
    assert frame.format.name == "yuv420p"
    assert (frame.colorspace, frame.color_trc, frame.color_primaries) == (1, 1, 1)
    kinds = {data.type.name for data in frame.side_data}
    assert not kinds & {"MASTERING_DISPLAY_METADATA", "CONTENT_LIGHT_LEVEL"}
    tone_maps = [text for text in report.conversions if "BT.2390" in text]
    assert len(tone_maps) == 1 and "PQ" in tone_maps[0] and "4000 cd/m2" in tone_maps[0]
    assert [round(t * 1000) for t in times_of(dst)] == [round(t * 1000) for t in times_of(src)]


def test_rotation_is_kept(tmp_path):
    src = hdr_clip(tmp_path / "in.mp4", rotation_degrees=90)
    process_video(src, tmp_path / "out.mp4", None, Settings(sdr=True))
    assert decoded(tmp_path / "out.mp4")[0].rotation == decoded(src)[0].rotation == 90


def test_sdr_in_ten_bits_where_they_are_asked_for(tmp_path):
    src = hdr_clip(tmp_path / "in.mp4")
    report = process_video(src, tmp_path / "out.mp4", None, Settings(sdr=True, bit_depth=10))
    frame = decoded(tmp_path / "out.mp4")[0]
    assert report.codec == "hevc" and frame.format.name == "yuv420p10le" and frame.color_trc == 1


def test_a_video_that_is_sdr_already_passes_untouched(tmp_path):
    src = make_clip(tmp_path / "in.mp4", color_trc=1)
    report = process_video(src, tmp_path / "out.mkv", None, Settings(sdr=True, codec="ffv1"))
    assert report.conversions == []
    for old, new in zip(decoded(src), decoded(tmp_path / "out.mkv"), strict=True):
        np.testing.assert_array_equal(old.to_ndarray(), new.to_ndarray())


# -- depth ----------------------------------------------------------------------------------------


def test_h264_has_eight_bits_and_reports_it(tmp_path):
    src = make_clip(tmp_path / "in.mp4", "hevc", pix_fmt="yuv420p10le")
    report = process_video(src, tmp_path / "out.mp4", None, Settings(codec="h264"))
    assert decoded(tmp_path / "out.mp4")[0].format.name == "yuv420p"
    assert len(report.conversions) == 1
    assert "yuv420p10le -> yuv420p" in report.conversions[0]
    assert "10 keeps them" in report.conversions[0]


def test_hdr_in_eight_bits_gives_a_warning(tmp_path):
    report = process_video(
        hdr_clip(tmp_path / "in.mp4"), tmp_path / "out.mp4", None, Settings(codec="h264")
    )
    assert "shows bands" in report.conversions[0] and "SDR" in report.conversions[0]


@pytest.mark.parametrize("pix_fmt", ["yuv420p10le", "yuv422p10le", "yuv444p10le"])
def test_h264_keeps_ten_bits_where_they_are_asked_for(tmp_path, pix_fmt):
    src = make_clip(tmp_path / "in.mkv", "ffv1", pix_fmt=pix_fmt)
    report = process_video(src, tmp_path / "out.mp4", None, Settings(codec="h264", bit_depth=10))
    assert report.conversions == []
    assert decoded(tmp_path / "out.mp4")[0].format.name == pix_fmt


@pytest.mark.parametrize(("bits", "codec"), [(8, "h264"), (10, "hevc"), (12, "hevc")])
def test_the_default_codec_suits_the_depth_asked_for(tmp_path, bits, codec):
    src = make_clip(tmp_path / "in.mkv", "ffv1", pix_fmt="yuv420p10le")
    report = process_video(src, tmp_path / "out.mp4", None, Settings(bit_depth=bits))
    assert report.codec == codec
    assert decoded(tmp_path / "out.mp4")[0].format.components[0].bits == bits


def test_a_depth_that_the_codec_lacks_is_refused_at_once(tmp_path):
    src = make_clip(tmp_path / "in.mp4")
    with pytest.raises(UsageError, match="must be 8 for vp9, got 10"):
        process_video(src, tmp_path / "out.mp4", None, Settings(codec="vp9", bit_depth=10))
    with pytest.raises(UsageError, match="8, 10, 12"):
        Settings(bit_depth=9)
    assert [path.name for path in tmp_path.iterdir()] == ["in.mp4"]


# -- samples beyond the depth ----------------------------------------------------------------------


@pytest.mark.parametrize(
    ("pix_fmt", "largest"),
    [("yuv420p10le", 1023), ("yuv422p10le", 1023), ("yuv444p12le", 4095), ("yuva420p10le", 1023)],
)
def test_samples_beyond_their_depth_are_clipped_and_counted(pix_fmt, largest):
    frame = picture(3, 64, 48, pix_fmt)
    before = [plane.copy() for plane in plane_views(frame, 16)]
    convert = ConvertPixelFormat(CODECS["ffv1"])
    assert convert(frame) is frame and convert.mended == 0
    for number in range(len(before)):
        odd = picture(3, 64, 48, pix_fmt)
        plane_views(odd, 16)[number][5, 3:9] = 60000
        out = convert(odd)
        assert convert.mended == number + 1
        before[number][5, 3:9] = largest
        for plane, want in zip(plane_views(out, 16), before, strict=True):
            np.testing.assert_array_equal(plane, want)
        before[number][5, 3:9] = plane_views(frame, 16)[number][5, 3:9]


def test_such_a_video_is_painted_and_counts_as_damaged(tmp_path):
    src = tmp_path / "in.nut"
    with av.open(str(src), "w") as out:
        stream = out.add_stream("rawvideo", rate=25)
        stream.width, stream.height, stream.pix_fmt = 64, 48, "yuv420p10le"
        for index in range(6):
            shown = picture(index, 64, 48, "yuv420p10le")
            if index in (2, 4):
                plane_views(shown, 16)[index // 2 - 1][::5] = 65535
            shown.pts = index
            out.mux(stream.encode(shown))
    report = process_video(src, tmp_path / "out.mkv", None, Settings(codec="h264", bit_depth=10))
    assert (report.frames_out, report.corrupt_frames, report.damaged) == (6, 2, True)
    report = process_video(src, tmp_path / "lossless.mkv", None, Settings(codec="ffv1"))
    for frame in decoded(tmp_path / "lossless.mkv"):
        assert all(plane.max() <= 1023 for plane in plane_views(frame, 16))
