"""A video in segments is the video of one run: frames, times, headers and all other streams."""

from fractions import Fraction
from types import SimpleNamespace

import av
import numpy as np
import pytest
from fuzz.check import video_faults
from makeup_video.pipeline import (
    DecodeError,
    Settings,
    StrictError,
    UsageError,
    WorkerError,
    process_video,
)
from makeup_video.pipeline.offline import paint_segments
from makeup_video.pipeline.offline import split as split_module
from media import damage, decoded, make_clip, packets_of
from people import SAMPLES
from split_videos import GROUP, VIDEOS, differences, rich

SECOND = Fraction(1, 60)  # in minutes


def both(src, folder, end, minutes=SECOND, trimmed=False, **settings):
    """(the video of one run, the video in segments, the report of the second)."""
    whole, split = folder / f"whole{end}", folder / f"split{end}"
    process_video(src, whole, None, Settings(**settings))
    report = process_video(src, split, None, Settings(**settings, split_minutes=minutes))
    assert sorted(path.name for path in folder.glob("*split*")) == [split.name]
    assert video_faults(src, split, report.to_dict(), trimmed=trimmed) == []
    return whole, split, report


@pytest.mark.parametrize("name", VIDEOS)
def test_an_odd_video_in_segments_is_that_of_one_run(tmp_path, name):
    src = VIDEOS[name](tmp_path / name)
    end = src.suffix if src.suffix in (".mp4", ".mov") else ".mkv"
    whole, split, report = both(src, tmp_path, end)
    assert report.segments > 1 and report.why_whole == ""
    assert differences(whole, split) == []


@pytest.mark.parametrize(
    ("codec", "end"),
    [("hevc", ".mp4"), ("hevc", ".mkv"), ("av1", ".mp4"), ("vp9", ".webm"), ("prores", ".mov")],
)
def test_segments_of_every_codec_are_joined(tmp_path, codec, end):
    src = make_clip(tmp_path / "in.mp4", frames=60, options=GROUP, audio="aac")
    whole, split, report = both(src, tmp_path, end, codec=codec)
    assert report.segments == 2 and differences(whole, split) == []


@pytest.mark.parametrize(("codec", "end"), [("h264", ".mp4"), ("av1", ".mp4"), ("vp9", ".webm")])
def test_segments_are_as_long_as_one_run(tmp_path, codec, end):
    """The video begins late, and its last frame stands still."""
    pts = [500 + 40 * index for index in range(60)]
    src = make_clip(
        tmp_path / "in.mp4", pts=pts, last=2000, time_base=Fraction(1, 1000), options=GROUP,
        container_options={"video_track_timescale": "1000"},
    )  # fmt: skip
    whole, split, report = both(src, tmp_path, end, codec=codec)
    assert report.segments > 1 and differences(whole, split) == []
    assert report.media_seconds == pytest.approx(4.36)
    ends = []
    for path in (whole, split):
        with av.open(str(path)) as container:
            ends.append(container.duration)
    assert ends[0] == ends[1] == pytest.approx(4_360_000 + (0 if end == ".mp4" else 500_000))


def test_pauses_before_seams_count_in_the_length(tmp_path):
    pts = [40 * index + 5000 * (index // 30) for index in range(90)]
    src = make_clip(
        tmp_path / "in.mkv", pts=pts, time_base=Fraction(1, 1000), options={"g": "30", "bf": "0"}
    )
    whole = process_video(src, tmp_path / "one.mkv", None, Settings())
    *_, report = both(src, tmp_path, ".mkv")
    assert report.segments > 1
    assert whole.media_seconds > 13
    assert report.media_seconds == pytest.approx(whole.media_seconds)


def test_transparency_is_kept_in_segments(tmp_path):
    src = make_clip(tmp_path / "in.mkv", "ffv1", frames=60, pix_fmt="yuva420p")
    _, split, report = both(src, tmp_path, ".webm")
    assert report.segments == 2 and report.dropped == []
    with av.open(str(split)) as container:
        packets = [packet for packet in container.demux(video=0) if packet.size]
    assert all(packet.has_sidedata("matroska_block_additional") for packet in packets)


@pytest.mark.parametrize(("minutes", "segments"), [(1, 1), (SECOND * 2, 2), (SECOND / 2, 7)])
def test_the_frames_do_not_depend_on_the_number_of_segments(tmp_path, minutes, segments):
    src = make_clip(tmp_path / "in.mp4", frames=105, options={**GROUP, "g": "15"})
    _, split, report = both(src, tmp_path, ".mkv", minutes=Fraction(minutes), codec="ffv1")
    assert report.segments == segments
    for old, new in zip(decoded(src), decoded(split), strict=True):
        np.testing.assert_array_equal(old.to_ndarray(), new.to_ndarray())


@pytest.mark.parametrize(
    ("name", "frames", "options", "why"),
    [
        ("one_group.mp4", 90, {"g": "1000"}, "not split: it has no key frame to split it at"),
        ("one_frame.mp4", 1, GROUP, None),
        ("bare.h264", 60, GROUP, "not split: its frames have no times of their own"),
        ("guessed.avi", 60, GROUP, "not split: its frames have no times of their own"),
    ],
)
def test_a_video_that_cannot_be_split_is_painted_whole(tmp_path, name, frames, options, why):
    src = make_clip(tmp_path / name, frames=frames, options=options)
    whole, split, report = both(src, tmp_path, ".mp4")
    assert report.segments == 1 and differences(whole, split) == []
    assert [line for line in report.warnings() if "split" in line] == ([why] if why else [])


@pytest.mark.parametrize(
    ("start", "end"),
    [(Fraction(1, 2), None), (None, Fraction(5, 2)), (Fraction(1), Fraction(16, 5))],
)
@pytest.mark.parametrize("end_of_name", [".mp4", ".mkv"])
def test_a_part_of_a_video_in_segments_is_that_of_one_run(tmp_path, start, end, end_of_name):
    src = rich(tmp_path / "in.mkv")
    part = {"start_seconds": start, "end_seconds": end}
    whole, split, report = both(src, tmp_path, end_of_name, SECOND / 2, trimmed=True, **part)
    assert report.segments > 1 and differences(whole, split) == []


def test_a_part_that_begins_with_a_still_is_painted_whole(tmp_path):
    times = [0, 1, 2, *range(60, 150)]  # the third picture is on screen for two seconds
    src = make_clip(tmp_path / "in.mkv", frames=len(times), pts=times, options=GROUP)
    part = {"start_seconds": Fraction(1)}
    whole, split, report = both(src, tmp_path, ".mkv", trimmed=True, **part)
    assert report.why_whole.startswith("its first frame was already on screen")
    assert differences(whole, split) == []


def test_damage_is_counted_once(tmp_path):
    src = make_clip(tmp_path / "in.mp4", frames=96, options=GROUP)
    damage(src)
    whole = process_video(src, tmp_path / "whole.mp4")
    split = process_video(src, tmp_path / "split.mp4", None, Settings(split_minutes=SECOND))
    assert split.segments > 1 and whole.damaged
    for name in ("frames_out", "corrupt_frames", "decode_errors", "lost_frames", "truncated"):
        assert getattr(split, name) == getattr(whole, name), name


def test_a_video_with_a_segment_that_is_all_damaged_is_whole(tmp_path):
    src = make_clip(tmp_path / "in.mkv", "mpeg4", frames=96, options={"g": "1"})
    data = src.read_bytes()
    for _, payload in packets_of(src, "video")[30:66]:
        data = data.replace(payload, bytes(len(payload)))
    src.write_bytes(data)
    whole = process_video(src, tmp_path / "whole.mp4")
    split = process_video(src, tmp_path / "split.mp4", None, Settings(split_minutes=SECOND))
    assert split.why_whole == "a segment of it is damaged" and split.damaged
    assert 0 < split.frames_out == whole.frames_out < 96
    assert split.decode_errors == whole.decode_errors


def test_before_and_after_works_in_segments(tmp_path):
    src = make_clip(tmp_path / "in.mp4", frames=60, options=GROUP)
    whole, split, _ = both(src, tmp_path, ".mp4", compare=True)
    assert differences(whole, split) == [] and decoded(split)[0].width == 192


def test_losses_are_refused_before_anything_is_painted(tmp_path, monkeypatch):
    src = rich(tmp_path / "in.mkv")
    monkeypatch.setattr(split_module, "paint_segments", None)
    with pytest.raises(StrictError, match="attachment"):
        process_video(src, tmp_path / "out.mp4", None, Settings(strict=True, split_minutes=SECOND))
    assert [path.name for path in tmp_path.iterdir()] == ["in.mkv"]


def test_a_segment_that_fails_leaves_no_file(tmp_path):
    small = make_clip(tmp_path / "small.ts", frames=45, options=GROUP, time_base=Fraction(1, 90000),
                      pts=range(0, 45 * 3000, 3000))  # fmt: skip
    large = make_clip(tmp_path / "large.ts", frames=45, options=GROUP, time_base=Fraction(1, 90000),
                      pts=range(45 * 3000, 90 * 3000, 3000), size_wh=(128, 64))  # fmt: skip
    src = tmp_path / "in.ts"
    src.write_bytes(small.read_bytes() + large.read_bytes())
    with pytest.raises(DecodeError, match="changes from 96x64"):
        process_video(src, tmp_path / "out.mp4", None, Settings(split_minutes=SECOND))
    assert not list(tmp_path.glob("out*"))


def test_an_error_of_a_segment_is_not_met_again_in_one_run(tmp_path, monkeypatch):
    def refused(*_):
        raise DecodeError("its size changes")

    src = make_clip(tmp_path / "in.mp4", frames=60, options=GROUP)
    monkeypatch.setattr(split_module, "process_in_segments", refused)
    with pytest.raises(DecodeError, match="its size changes"):
        process_video(src, tmp_path / "out.mp4", None, Settings(split_minutes=SECOND))
    assert [path.name for path in tmp_path.iterdir()] == ["in.mp4"]


def test_what_a_killed_run_left_is_removed_only_on_request(tmp_path):
    src = make_clip(tmp_path / "in.mp4", frames=60, options=GROUP)
    left = tmp_path / "out.part.mp4.segments"
    left.mkdir()
    (left / "segment-00001").write_bytes(b"old")
    (left / "mine.txt").write_bytes(b"mine")
    settings = {"split_minutes": SECOND}
    with pytest.raises(UsageError, match=r"out\.part\.mp4\.segments exists"):
        process_video(src, tmp_path / "out.mp4", None, Settings(**settings))
    process_video(src, tmp_path / "out.mp4", None, Settings(**settings, overwrite=True))
    assert len(decoded(tmp_path / "out.mp4")) == 60
    assert [path.name for path in left.iterdir()] == ["mine.txt"]


def test_runs_whose_outputs_differ_in_the_ending_stay_apart(tmp_path, monkeypatch):
    src = make_clip(tmp_path / "in.mp4", frames=60, options=GROUP)
    settings, paint = Settings(split_minutes=SECOND, overwrite=True), split_module.paint_segments

    def with_another_run(*words):
        monkeypatch.setattr(split_module, "paint_segments", paint)
        process_video(src, tmp_path / "out.mkv", None, settings)
        return paint(*words)

    monkeypatch.setattr(split_module, "paint_segments", with_another_run)
    process_video(src, tmp_path / "out.mp4", None, settings)
    assert sorted(path.name for path in tmp_path.iterdir()) == ["in.mp4", "out.mkv", "out.mp4"]
    assert len(decoded(tmp_path / "out.mp4")) == len(decoded(tmp_path / "out.mkv")) == 60


def test_progress_counts_the_frames_of_all_segments(tmp_path):
    src = make_clip(tmp_path / "in.mp4", frames=96, options=GROUP)
    ticks = []
    process_video(
        src, tmp_path / "out.mp4", None, Settings(split_minutes=SECOND),
        lambda done, expected, rate: ticks.append((done, expected, rate)),
    )  # fmt: skip
    counts = [done for done, *_ in ticks]
    assert counts == sorted(counts) and counts[-1] <= 96
    assert {tick[1:] for tick in ticks} == {(96, Fraction(30))}


@pytest.mark.parametrize(
    ("settings", "text"),
    [
        ({"split_minutes": Fraction(0)}, "split_minutes must be more than 0, got 0"),
        (
            {"split_minutes": Fraction(1), "jobs": 0},
            "jobs must be a whole number of at least 1, got 0",
        ),
        ({"jobs": 2}, "jobs needs split_minutes"),
    ],
)
def test_settings_that_do_not_fit_are_refused(settings, text):
    with pytest.raises(UsageError, match=text):
        Settings(**settings)


def test_at_least_one_worker_is_needed(tmp_path):
    src = make_clip(tmp_path / "in.mp4", frames=60, options=GROUP)
    with pytest.raises(UsageError, match="workers must hold at least one"):
        process_video(src, tmp_path / "out.mp4", None, Settings(split_minutes=SECOND), workers=[])


def test_a_daemonic_process_paints_in_one_run(tmp_path, monkeypatch):
    src, out = make_clip(tmp_path / "in.mp4", frames=60, options=GROUP), tmp_path / "out.mp4"
    monkeypatch.setattr(paint_segments, "current_process", lambda: SimpleNamespace(daemon=True))
    with pytest.raises(UsageError, match=r"daemonic .*: leave split_minutes out here"):
        process_video(src, out, None, Settings(split_minutes=SECOND))
    assert [path.name for path in tmp_path.iterdir()] == ["in.mp4"]


def test_a_picture_is_not_split(tmp_path):
    with pytest.raises(UsageError, match="is a picture: leave out split_minutes"):
        process_video(SAMPLES / "portrait.jpg", tmp_path / "o.png", None,
                      Settings(split_minutes=SECOND))  # fmt: skip


def test_a_worker_error_is_one_line():
    assert WorkerError("x").exit_code == 1
