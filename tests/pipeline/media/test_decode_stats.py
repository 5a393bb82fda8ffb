"""Damaged input: decode what decodes, count and report the damage, never hang."""

import random
from contextlib import closing
from fractions import Fraction

import pytest
from makeup_video.pipeline import process_video
from makeup_video.pipeline.media.codecs import CODECS
from makeup_video.pipeline.media.decode import Decoder
from makeup_video.pipeline.media.input_file import open_video
from makeup_video.pipeline.media.pixel_format import ConvertPixelFormat
from makeup_video.pipeline.media.segment_file import SegmentWriter
from makeup_video.pipeline.media.segment_trim import SegmentTrim
from makeup_video.pipeline.media.segments import plan_segments
from media import damage, decoded, make_clip, packets_of
from split_videos import hidden_frames


@pytest.mark.parametrize("end", [".mp4", ".mkv"])
def test_an_mp4_cut_in_the_middle_gives_the_frames_it_has(tmp_path, end):
    whole = make_clip(
        tmp_path / "whole.mp4", frames=90, size_wh=(320, 240), audio="aac",
        container_options={"movflags": "faststart"},
    ).read_bytes()  # fmt: skip
    src, dst = tmp_path / "in.mp4", tmp_path / f"out{end}"
    src.write_bytes(whole[: len(whole) * 2 // 3])
    report = process_video(src, dst)
    assert report.truncated and report.damaged
    assert 30 < report.frames_out == report.frames_in == len(decoded(dst)) < 90
    assert report.lost_frames == 90 - report.frames_out
    assert any("ends early" in line for line in report.warnings())


def test_a_cut_mkv_gives_the_frames_it_has_with_a_warning(tmp_path):
    whole = make_clip(tmp_path / "whole.mkv", frames=120, size_wh=(320, 240), audio="aac")
    src = tmp_path / "in.mkv"
    src.write_bytes(whole.read_bytes()[: whole.stat().st_size // 2])
    report = process_video(src, tmp_path / "out.mkv")
    assert 30 < report.frames_out < 100
    assert report.truncated and report.damaged


@pytest.mark.parametrize(
    "codec_name", [("h264", "in.mp4"), ("hevc", "in.mp4"), ("mpeg4", "in.avi")]
)
@pytest.mark.parametrize("seed", range(4))
def test_flipped_bytes_are_survived_counted_and_reported(tmp_path, codec_name, seed):
    codec, name = codec_name
    clip = make_clip(
        tmp_path / f"whole-{name}", codec, frames=60, size_wh=(320, 240), options={"g": "10"}
    )
    data, rng = bytearray(clip.read_bytes()), random.Random(seed)
    for _ in range(200):
        data[rng.randrange(len(data) // 4, len(data) // 2)] ^= 0xFF
    src, dst = tmp_path / name, tmp_path / "out.mp4"
    src.write_bytes(data)
    report = process_video(src, dst)
    assert report.frames_out == report.frames_in == len(decoded(dst)) > 20
    assert report.damaged
    assert report.corrupt_frames + report.decode_errors + report.lost_frames > 0
    assert src.read_bytes() == bytes(data)


def test_frames_hidden_by_an_edit_list_are_no_damage(tmp_path):
    """A stream copy inside a group of pictures: decoding begins before 0, playback at 0."""
    src = hidden_frames(tmp_path / "in.mp4", frames=90, options={"g": "30"})
    shown = len(decoded(src))
    assert shown == 75
    report = process_video(src, tmp_path / "out.mp4")
    assert (report.frames_out, report.damaged) == (75, False)


def test_a_sound_clip_is_not_called_damaged(tmp_path):
    for name, codec in (
        ("a.mp4", "h264"),
        ("b.mkv", "hevc"),
        ("c.webm", "vp9"),
        ("d.avi", "mpeg4"),
    ):
        src = make_clip(tmp_path / name, codec, frames=40, options={"g": "10"})
        report = process_video(src, tmp_path / f"out-{name}.mp4")
        assert not report.damaged, name
        assert report.warnings() == [], name


def damaged_frames(src, segment=None):
    """How many frames are counted as damaged in a video, or in one of its segments."""
    with closing(open_video(src)) as source:
        trim = segment and SegmentTrim(segment, 0, source.time_base)
        convert = ConvertPixelFormat(CODECS["h264"], None)
        nowhere = SegmentWriter(src.with_name("out"), "mp4")
        decoder = Decoder(source, convert, nowhere, segment=trim)
        for _ in decoder.frames():
            pass
    return decoder.stats.corrupt_frames


def test_damage_in_the_run_up_of_a_segment_is_counted_once(tmp_path):
    src = make_clip(tmp_path / "in.mp4", frames=150, size_wh=(320, 240), options={"g": "30"})
    damage(src)
    with closing(open_video(src)) as source:
        plan = plan_segments(source, Fraction(1))
    counts = [damaged_frames(src, one) for one in plan.segments]
    assert len(counts) == 5 and sum(counts) == damaged_frames(src) > 0


def test_a_cut_is_noticed_where_other_frames_are_hidden(tmp_path):
    """An edit list hides more frames than are missing."""
    src = hidden_frames(
        tmp_path / "in.mp4", frames=90, options={"g": "30", "bf": "0"},
        container_options={"movflags": "faststart"},
    )  # fmt: skip
    *_, (_, last) = packets_of(src, "video")
    data = src.read_bytes()
    src.write_bytes(data[: data.rindex(last)])
    report = process_video(src, tmp_path / "out.mp4")
    assert report.truncated and report.frames_out < 75
