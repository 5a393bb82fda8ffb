"""Colour tags that only the container declares are kept."""

import av
import pytest
from hypothesis import given
from hypothesis import strategies as st
from makeup_video.pipeline import Settings, StrictError, process_video
from makeup_video.pipeline.frames.colour_tags import ColourTags
from media import add_video, decoded, encode_frames, make_clip, picture

CODES = st.sampled_from([1, 2, 5, 6, 9])


def declared(path, codec="hevc", **tags):
    """Write a clip whose coded frames have no colour tags and whose container has these."""
    with av.open(str(path), "w") as out:
        stream = add_video(out, codec, pix_fmt="yuv420p10le")
        stream.codec_context.open(strict=False)  # the encoder never sees the tags
        for name, value in tags.items():
            setattr(stream.codec_context, name, value)
        encode_frames(out, stream, range(8))
    return path


@pytest.mark.parametrize("begin", [".mp4", ".mkv", ".mov"])
@pytest.mark.parametrize("end", [".mp4", ".mkv"])
def test_hdr_that_the_container_declares_stays_hdr(tmp_path, begin, end):
    src = declared(
        tmp_path / f"in{begin}", colorspace=9, color_trc=16, color_primaries=9, color_range=1
    )
    assert decoded(src)[0].color_trc == 2  # otherwise this clip proves nothing
    report = process_video(src, tmp_path / f"out{end}")
    frame = decoded(tmp_path / f"out{end}")[0]
    assert (frame.colorspace, frame.color_trc, frame.color_primaries) == (9, 16, 9)
    assert report.codec == "hevc" and report.conversions == []


def test_hdr_declared_by_the_container_becomes_sdr(tmp_path):
    src = declared(tmp_path / "in.mkv", colorspace=9, color_trc=18, color_primaries=9)
    report = process_video(src, tmp_path / "out.mp4", None, Settings(sdr=True))
    assert any("HLG" in text and "BT.2390" in text for text in report.conversions)
    assert decoded(tmp_path / "out.mp4")[0].color_trc == 1


@given(frame_tags=st.tuples(CODES, st.integers(0, 2), CODES, CODES),
       container_tags=st.tuples(CODES, st.integers(0, 2), CODES, CODES))  # fmt: skip
def test_a_picture_takes_only_the_tags_that_it_lacks(frame_tags, container_tags):
    frame = picture(0, 16, 16)
    frame.colorspace, frame.color_range, frame.color_trc, frame.color_primaries = frame_tags
    ColourTags(*container_tags).complete(frame)
    got = ColourTags.of(frame)
    unknown = (2, 0, 2, 2)
    want = [
        declared if own == none else own
        for own, declared, none in zip(frame_tags, container_tags, unknown, strict=True)
    ]
    assert (got.matrix, got.range, got.transfer, got.primaries) == tuple(want)


def test_sdr_into_prores_has_its_ten_bits(tmp_path):
    src = declared(tmp_path / "in.mkv", colorspace=9, color_trc=16, color_primaries=9)
    process_video(src, tmp_path / "out.mov", None, Settings(sdr=True, codec="prores"))
    frame = decoded(tmp_path / "out.mov")[0]
    assert frame.format.name == "yuv422p10le" and frame.color_trc == 1


@pytest.mark.parametrize(
    ("pix_fmt", "size_wh", "settings", "is_kept"),
    [
        ("yuv420p10le", (96, 64), {"codec": "h264"}, False),
        ("yuv420p10le", (96, 64), {"codec": "h264", "bit_depth": 8}, True),  # 8 bits are wanted
        ("yuv420p10le", (96, 64), {"codec": "h264", "bit_depth": 10}, True),
        ("yuv420p10le", (96, 64), {"codec": "hevc"}, True),
        ("yuv444p12le", (96, 64), {"codec": "h264"}, False),
        ("yuv420p", (97, 63), {"codec": "h264"}, False),
        ("yuv420p", (97, 63), {"codec": "ffv1"}, True),
    ],
)
def test_strict_refuses_unasked_changes_of_the_picture(
    tmp_path, pix_fmt, size_wh, settings, is_kept
):
    src = make_clip(tmp_path / "in.mkv", "ffv1", pix_fmt=pix_fmt, size_wh=size_wh)
    strict = Settings(strict=True, **settings)
    if is_kept:
        assert process_video(src, tmp_path / "out.mkv", None, strict).frames_out == 12
    else:
        with pytest.raises(StrictError, match="cannot keep the picture as it is"):
            process_video(src, tmp_path / "out.mkv", None, strict)
        assert [path.name for path in tmp_path.iterdir()] == ["in.mkv"]
