"""The encoder: HDR metadata, options, and what the encoder refuses."""

import struct
from fractions import Fraction

import av
import pytest
from makeup_video.pipeline import EncodeError, Settings, UsageError, process_video
from makeup_video.pipeline.media.codecs import CODECS, encoder_options, pick_codec
from makeup_video.pipeline.media.pixel_format import bits_of, pick_pix_fmt
from media import add_video, decoded, encode_frames, make_clip

MASTER = (
    "master-display=G(13250,34500)B(7500,3000)R(34000,16000)WP(15635,16450)L(10000000,50)"
    ":max-cll=1000,400"
)


def hdr_clip(path):
    """10-bit HEVC, BT.2020, PQ, with static HDR10 metadata."""
    return make_clip(
        path, "hevc", pix_fmt="yuv420p10le", colorspace=9, color_range=1, color_trc=16,
        color_primaries=9, options={"x265-params": f"log-level=none:{MASTER}"},
    )  # fmt: skip


def hdr_of(path):
    side_data = decoded(path)[0].side_data
    return {
        data.type.name: bytes(data)
        for data in side_data
        if data.type.name in ("MASTERING_DISPLAY_METADATA", "CONTENT_LIGHT_LEVEL")
    }


@pytest.mark.parametrize(
    ("codec", "end"),
    [
        (None, ".mp4"),
        (None, ".mov"),
        (None, ".mkv"),
        ("h264", ".mp4"),
        ("av1", ".mp4"),
        (None, ".webm"),
    ],
)
def test_hdr10_static_metadata_and_tags_arrive(tmp_path, codec, end):
    src, dst = hdr_clip(tmp_path / "in.mp4"), tmp_path / f"out{end}"
    report = process_video(src, dst, None, Settings(codec=codec, bit_depth=10))
    frame = decoded(dst)[0]
    assert report.codec == (codec or ("av1" if end == ".webm" else "hevc"))
    assert frame.format.name == "yuv420p10le"
    assert (frame.colorspace, frame.color_trc, frame.color_primaries) == (9, 16, 9)
    assert report.dropped == []
    want, got = hdr_of(src), hdr_of(dst)
    assert set(want) == set(got) == {"MASTERING_DISPLAY_METADATA", "CONTENT_LIGHT_LEVEL"}
    assert struct.unpack("2I", got["CONTENT_LIGHT_LEVEL"][:8]) == (1000, 400)
    numbers = [_fractions(side["MASTERING_DISPLAY_METADATA"]) for side in (want, got)]
    for a, b in zip(*numbers, strict=True):
        assert float(a) == pytest.approx(float(b), abs=3e-4)


def _fractions(data):
    values = struct.unpack("20i", data[:80])
    return [Fraction(a, b) for a, b in zip(values[::2], values[1::2], strict=True)]


@pytest.mark.parametrize("codec_end", [("prores", ".mov"), ("ffv1", ".mkv")])
def test_hdr10_metadata_that_a_codec_cannot_carry_is_reported(tmp_path, codec_end):
    codec, end = codec_end
    report = process_video(
        hdr_clip(tmp_path / "in.mp4"), tmp_path / f"out{end}", None, Settings(codec=codec)
    )
    assert len(report.dropped) == 2 and all("HDR10" in text for text in report.dropped)


def test_hlg_goes_to_ten_bit_hevc(tmp_path):
    src = make_clip(
        tmp_path / "in.mp4", "hevc", pix_fmt="yuv420p10le", colorspace=9, color_trc=18,
        color_primaries=9,
    )  # fmt: skip
    assert process_video(src, tmp_path / "out.mp4").codec == "hevc"
    assert decoded(tmp_path / "out.mp4")[0].color_trc == 18


def test_an_encoder_that_refuses_leaves_one_line_and_no_file(tmp_path):
    src = make_clip(tmp_path / "in.mkv", "ffv1", size_wh=(2, 2))
    with pytest.raises(EncodeError, match="libx265 refuses 2x2") as caught:
        process_video(src, tmp_path / "out.mp4", None, Settings(codec="hevc"))
    assert "\n" not in str(caught.value)
    assert [path.name for path in tmp_path.iterdir()] == ["in.mkv"]


@pytest.mark.parametrize("name", list(CODECS))
def test_crf_and_preset_reach_the_encoder_or_are_refused(name):
    codec = CODECS[name]
    if codec.crf is None:
        with pytest.raises(UsageError, match="no crf"):
            encoder_options(codec, 20, None)
    else:
        low, high, default = codec.crf
        assert encoder_options(codec, None, None)["crf"] == str(default)
        assert encoder_options(codec, high, None)["crf"] == str(high)
        for wrong in (low - 1, high + 1):
            with pytest.raises(UsageError, match=f"{low}..{high}"):
                encoder_options(codec, wrong, None)
    with pytest.raises(UsageError, match=r"^preset must be"):
        encoder_options(codec, None, "quick")
    with pytest.raises(UsageError, match=r"got 'Very-Quick'$"):
        encoder_options(codec, None, "Very-Quick")
    for preset in codec.presets or ():
        assert preset in encoder_options(codec, None, preset).values()


def test_lower_crf_makes_a_larger_file(tmp_path):
    src = make_clip(tmp_path / "in.mp4", frames=20, size_wh=(320, 240))
    sizes = [
        process_video(src, tmp_path / f"{crf}.mp4", None, Settings(crf=crf)).bytes_out
        for crf in (10, 25, 40)
    ]
    assert sizes == sorted(sizes, reverse=True)


@pytest.mark.parametrize("container", ["mp4", "mov", "matroska", "webm"])
@pytest.mark.parametrize("deep", [False, True])
@pytest.mark.parametrize("alpha", [False, True])
def test_the_default_codec_always_fits_its_container(container, deep, alpha):
    codec = pick_codec(None, container, deep=deep, alpha=alpha)
    assert container in codec.containers
    if deep and not alpha:
        assert any("10le" in name for name in codec.pix_fmts)
    if alpha and container != "mp4":
        assert any(name.startswith("yuva") for name in codec.pix_fmts)


def test_codecs_that_a_container_cannot_hold_are_refused():
    with pytest.raises(UsageError, match="webm does not hold h264; use codec av1 or vp9"):
        pick_codec("h264", "webm", deep=False, alpha=False)
    with pytest.raises(UsageError, match="must be one of"):
        pick_codec("theora", "mp4", deep=False, alpha=False)


@pytest.mark.parametrize("name", list(CODECS))
def test_every_layout_in_the_table_is_one_the_encoder_takes(name):
    codec = CODECS[name]
    offered = {fmt.name for fmt in av.Codec(codec.encoder, "w").video_formats}
    assert set(codec.pix_fmts) <= offered
    for fmt in codec.pix_fmts:
        assert pick_pix_fmt(fmt, codec, bits_of(fmt)) == fmt


def test_the_sources_frame_types_do_not_become_the_encoders(tmp_path):
    """An all-intra source must not force an all-intra, four times larger output."""
    src = tmp_path / "in.mp4"
    with av.open(str(src), "w") as out:
        encode_frames(out, add_video(out, options={"g": "1"}), range(40))
    process_video(src, tmp_path / "out.mp4")
    with av.open(str(tmp_path / "out.mp4")) as container:
        keys = [packet.is_keyframe for packet in container.demux(video=0) if packet.size]
    assert sum(keys) < 4


@pytest.mark.parametrize("name", list(CODECS))
def test_the_last_frame_keeps_its_length(tmp_path, name):
    """SVT-AV1 returns packets without a duration, for which FFmpeg's muxers put in the mean."""
    pts = range(0, 1000, 100)
    src = make_clip(
        tmp_path / "in.mkv", "ffv1", pts=pts, last=2000, time_base=Fraction(1, 1000), rate=10
    )
    for container in CODECS[name].containers:
        end = "mkv" if container == "matroska" else container
        dst = tmp_path / f"out.{end}"
        report = process_video(src, dst, None, Settings(codec=name))
        assert float(report.media_seconds) == pytest.approx(2.9)
        with av.open(str(dst)) as written:
            assert written.duration == 2_900_000


@pytest.mark.parametrize("frames", [1, 2])
def test_few_frames_of_hevc_have_decoding_times(tmp_path, frames):
    """x265 returns random decoding times, most of which mp4 and mov refuse."""
    src = make_clip(tmp_path / "in.mp4", frames=frames)
    for number in range(8):
        dst = tmp_path / f"{number}.mov"
        process_video(src, dst, None, Settings(codec="hevc"))
        with av.open(str(dst)) as container:
            times = [(p.dts, p.pts) for p in container.demux(video=0) if p.size]
        assert times == [(512 * index, 512 * index) for index in range(frames)]


def test_the_length_counts_from_the_first_frame_on(tmp_path):
    src = make_clip(tmp_path / "in.mkv", "ffv1", pts=range(30, 42))
    report = process_video(src, tmp_path / "out.mp4")
    assert report.media_seconds == pytest.approx(0.4, abs=0.001)


def tag_of(path, index=0):
    with av.open(str(path)) as container:
        return container.streams.video[index].codec_context.codec_tag


@pytest.mark.parametrize("end", [".mp4", ".m4v", ".mov"])
@pytest.mark.parametrize("pix_fmt", ["yuv420p", "yuv420p10le"])
def test_hevc_is_tagged_hvc1_with_its_sets_in_the_header(tmp_path, end, pix_fmt):
    src = make_clip(tmp_path / "in.mkv", "ffv1", pix_fmt=pix_fmt)
    process_video(src, tmp_path / f"out{end}", None, Settings(codec="hevc"))
    assert tag_of(tmp_path / f"out{end}") == "hvc1"
    assert {32, 33, 34} & set(nal_types(tmp_path / f"out{end}")) == set()  # VPS, SPS, PPS
    with av.open(str(tmp_path / f"out{end}")) as container:
        header = bytes(container.streams.video[0].codec_context.extradata)
    assert header[22] >= 3  # arrays of parameter sets in hvcC
    assert len(decoded(tmp_path / f"out{end}")) == 12


def nal_types(path):
    """Yield the type of every NAL unit in the first video stream (H.265, table 7-1)."""
    with av.open(str(path)) as container:
        for packet in container.demux(video=0):
            data, offset = bytes(packet), 0
            while offset + 4 < len(data):
                yield data[offset + 4] >> 1 & 63
                offset += 4 + int.from_bytes(data[offset : offset + 4])


@pytest.mark.parametrize("begin", [".mp4", ".mkv", ".mov"])
@pytest.mark.parametrize("end", [".mp4", ".mov"])
def test_copied_hevc_is_tagged_hvc1_too(tmp_path, begin, end):
    src = tmp_path / f"in{begin}"
    with av.open(str(src), "w") as out:
        first, second = add_video(out), add_video(out, "hevc")
        encode_frames(out, first, range(8))
        encode_frames(out, second, range(8))
    process_video(src, tmp_path / f"out{end}")
    assert tag_of(tmp_path / f"out{end}", 1) == "hvc1"


def test_hevc_in_matroska_has_no_mp4_tag(tmp_path):
    process_video(
        make_clip(tmp_path / "in.mp4"), tmp_path / "out.mkv", None, Settings(codec="hevc")
    )
    assert tag_of(tmp_path / "out.mkv") == "\0\0\0\0"
