"""Trimming keeps every frame that was on screen, starts at 0 and stays in sync."""

from fractions import Fraction
from itertools import pairwise

import av
import pytest
from hypothesis import given
from hypothesis import strategies as st
from makeup_video.pipeline import DecodeError, Settings, process_video
from makeup_video.pipeline.media.trim import Trim
from media import add_video, decoded, encode_frames, make_clip, packets_of, times_of, tone
from rich_clips import add_titles, titles_of, write_title

TICK = Fraction(1, 1000)


def kept(times, start, end):
    trim = Trim(start, end, TICK)
    out = []
    for index, seconds in enumerate(times):
        duration = times[index + 1] - seconds if index + 1 < len(times) else Fraction(1, 30)
        out += trim(index, seconds, duration)
    return out + trim.finish(), trim


@given(
    gaps=st.lists(st.integers(1, 3000), min_size=1, max_size=30),
    start=st.none() | st.integers(1, 20000),
    length=st.none() | st.integers(1, 20000),
)
def test_what_was_on_screen_is_kept_in_order_from_zero(gaps, start, length):
    times = [Fraction(sum(gaps[:i]), 1000) for i in range(len(gaps))]
    begin = None if start is None else Fraction(start, 1000)
    end = None if length is None else (begin or 0) + Fraction(length, 1000)
    result, trim = kept(times, begin, end)
    inside = [
        i
        for i, seconds in enumerate(times)
        if (begin or 0) <= seconds and (end is None or seconds < end)
    ]
    indices = [index for index, *_ in result]
    assert indices[-len(inside) :] == inside if inside else len(indices) <= 1
    assert all(a < b for (_, a, _), (_, b, _) in pairwise(result))
    for index, seconds, duration in result:
        assert seconds >= 0 and duration > 0
        stop = seconds + duration + (trim.shift or 0)  # on the clock of the video
        assert stop <= sum(gaps) / 1000 + 1 / 30
        assert end is None or stop <= end or duration <= Fraction(1, 10)
        if index in inside:
            assert seconds == times[index] - (trim.shift or 0)
    if result and begin is not None:
        assert abs(trim.shift - begin) <= Fraction(1, 10) + TICK  # sound stays with the picture


def test_a_clip_that_begins_before_zero_is_moved_whole():
    result, trim = kept([Fraction(-1), Fraction(0), Fraction(1)], None, None)
    assert trim.shift == -1
    assert [seconds for _, seconds, _ in result] == [0, 1, 2]


def test_a_clip_moves_by_a_whole_number_of_ticks():
    result, trim = kept([Fraction(0), Fraction(1)], Fraction(1, 3), None)
    assert trim.shift == 333 * TICK
    assert [seconds for _, seconds, _ in result] == [0, 667 * TICK]


def test_a_picture_that_ends_at_the_start_is_not_kept():
    trim = Trim(Fraction(1), None, TICK)
    assert trim("old", Fraction(0), Fraction(1)) == trim.finish() == []


def test_a_picture_a_tenth_after_the_start_begins_the_clip():
    result, trim = kept([Fraction(0), Fraction(1, 5)], Fraction(1, 10), None)
    assert [index for index, *_ in result] == [1] and trim.shift == Fraction(1, 5)


@pytest.mark.parametrize(("start", "end", "want"), [
    (5, None, [0, 4, 5]), (5, 8, [0]), (Fraction("2.95"), None, [0, 6, 7]), (3, 9, [0]),
])  # fmt: skip
def test_a_picture_shown_for_seconds_keeps_its_sound(tmp_path, start, end, want):
    """A screen recording: frames at 0, 1, 2, 3, 9 and 10 s."""
    src = tmp_path / "in.mkv"
    with av.open(str(src), "w") as out:
        video = add_video(out, time_base=Fraction(1, 1000))
        sound = out.add_stream("flac", rate=48000, layout="mono")
        encode_frames(out, video, [0, 1000, 2000, 3000, 9000, 10000])
        tone(out, sound, 11.0)
    settings = Settings(start_seconds=Fraction(start), end_seconds=end and Fraction(end))
    process_video(src, tmp_path / "out.mkv", None, settings)
    assert [round(float(seconds)) for seconds in times_of(tmp_path / "out.mkv")] == want
    sound = packets_of(tmp_path / "out.mkv", "audio")
    expected = (end or 11) - float(start)
    assert len(sound) * 4608 / 48000 == pytest.approx(expected, abs=0.3)
    assert 0 <= sound[0][0] < Fraction(15, 100)


@pytest.mark.parametrize("end", [".mp4", ".mov", ".mkv"])
@pytest.mark.parametrize(("start", "stop", "seconds"), [
    (2, 4, 2), (0, 3, 3), (5, 8, 3), (3, 9.5, 6.5), (9.5, 9.8, 0.3),
])  # fmt: skip
def test_a_picture_ends_where_the_clip_ends(tmp_path, end, start, stop, seconds):
    """Frames at 0, 1, 2, 3, 9 and 10 s; mp4 tells how long each is shown."""
    src = tmp_path / "in.mp4"
    with av.open(str(src), "w") as out:
        video = add_video(out, time_base=Fraction(1, 1000))
        encode_frames(out, video, [0, 1000, 2000, 3000, 9000, 10000])
    dst = tmp_path / f"out{end}"
    settings = Settings(start_seconds=Fraction(start), end_seconds=Fraction(stop))
    report = process_video(src, dst, None, settings)
    assert float(report.media_seconds) == pytest.approx(seconds, abs=0.05)
    with av.open(str(dst)) as container:
        assert container.duration / 1e6 == pytest.approx(seconds, abs=0.05)


@pytest.mark.parametrize("name", ["in.ts", "in.mp4", "in.mkv", "in.avi", "in.flv"])
@pytest.mark.parametrize("group", ["250", "30"])
@pytest.mark.parametrize("start", ["0.05", "0.95", "2.5", "4.9"])
def test_no_frame_is_lost_wherever_the_keyframes_lie(tmp_path, name, group, start):
    src = make_clip(tmp_path / name, frames=150, options={"g": group, "bf": "3"})
    report = process_video(src, tmp_path / "out.mkv", None, Settings(start_seconds=Fraction(start)))
    with av.open(str(src)) as container:
        video = container.streams.video[0]
        origin = video.start_time * video.time_base
    want = [seconds for seconds in times_of(src) if seconds >= origin + Fraction(start)]
    assert report.frames_out == len(want)


@pytest.mark.parametrize("split", [None, Fraction(1, 60)])
@pytest.mark.parametrize("group", ["250", "30"])
@pytest.mark.parametrize("start", ["0.5", "4.9"])
@pytest.mark.parametrize("first", [0, 2**33 - 90000, 2**33 - 3000 * 90])  # of a clock of 33 bits
def test_a_stream_that_is_decoded_before_0_loses_no_frame(tmp_path, first, start, group, split):
    src = make_clip(
        tmp_path / "in.ts", pts=[first + 3000 * i for i in range(150)],
        time_base=Fraction(1, 90000), options={"g": group, "bf": "3"},
        container_options={"mpegts_copyts": "1", "avoid_negative_ts": "disabled"},
    )  # fmt: skip
    with av.open(str(src)) as container:
        assert next(container.demux(video=0)).dts < 0
    settings = Settings(start_seconds=Fraction(start), end_seconds=Fraction(5), split_minutes=split)
    report = process_video(src, tmp_path / "out.mkv", None, settings)
    assert report.frames_out == 150 - Fraction(start) * 30 and report.converted == []
    kept = decoded(src)[-report.frames_out].to_ndarray().astype(int)
    assert abs(kept - decoded(tmp_path / "out.mkv")[0].to_ndarray()).mean() < 3


@pytest.mark.parametrize("codec", ["h264", "hevc"])
def test_an_open_group_of_pictures_loses_no_leading_frame(tmp_path, codec):
    options = {
        "h264": {"preset": "veryfast", "x264-params": "open-gop=1:keyint=30:bframes=4:scenecut=0"},
        "hevc": {"x265-params": "log-level=none:open-gop=1:keyint=30:bframes=4:scenecut=0"},
    }[codec]
    src = make_clip(tmp_path / "in.mp4", codec, frames=120, options=options)
    settings = Settings(start_seconds=Fraction("0.95"), end_seconds=Fraction(3))
    report = process_video(src, tmp_path / "out.mp4", None, settings)
    want = [seconds for seconds in times_of(src) if Fraction("0.95") <= seconds < 3]
    assert report.frames_out == len(want)
    old = [f.to_ndarray() for f in decoded(src) if Fraction("0.95") <= f.pts * f.time_base < 3]
    for a, b in zip(old, decoded(tmp_path / "out.mp4"), strict=True):
        assert abs(a.astype(int) - b.to_ndarray()).mean() < 3


def test_a_bare_stream_is_trimmed_without_seeking(tmp_path):
    src = make_clip(tmp_path / "in.h264", frames=60)
    try:
        report = process_video(src, tmp_path / "out.mp4", None, Settings(start_seconds=Fraction(1)))
    except DecodeError:
        pytest.fail("a trim inside a bare stream found no frame")
    assert 0 < report.frames_out <= 60


@pytest.mark.parametrize("end", [".mp4", ".mov", ".mkv", ".webm"])
def test_a_video_that_begins_before_zero_is_shown_whole(tmp_path, end):
    # a broadcast whose 33-bit clock wraps: FFmpeg gives earlier frames negative times
    src = make_clip(
        tmp_path / "in.ts", pts=[2**33 - 90000 + 3000 * i for i in range(60)],
        time_base=Fraction(1, 90000), container_options={"mpegts_copyts": "1", "muxdelay": "0"},
    )  # fmt: skip
    assert times_of(src)[0] == -1
    report = process_video(src, tmp_path / f"out{end}")
    assert len(decoded(tmp_path / f"out{end}")) == report.frames_out == 60
    assert times_of(tmp_path / f"out{end}")[0] == 0
    assert any("later" in text for text in report.converted)
    process_video(src, tmp_path / f"strict{end}", None, Settings(strict=True))


@pytest.mark.parametrize("settings", [{}, {"start_seconds": Fraction(0)}, {"strict": True},
                                      {"split_minutes": Fraction(1, 60)}])  # fmt: skip
@pytest.mark.parametrize("end", [".mp4", ".mov", ".mkv", ".webm"])
def test_a_clock_that_begins_late_begins_at_zero(tmp_path, end, settings):
    src = late_video(tmp_path / "in.ts", [3000 * i for i in range(60)])
    report = process_video(src, tmp_path / f"out{end}", None, Settings(**settings))
    times = times_of(tmp_path / f"out{end}")
    assert len(times) == report.frames_out == 60
    assert times[0] == 0
    assert times[-1] == pytest.approx(59 / 30, abs=0.001)
    assert any("36000 s earlier" in text for text in report.converted)


def test_a_late_clock_keeps_sound_and_picture_together(tmp_path):
    src = late_video(tmp_path / "in.ts", [45000 + 3000 * i for i in range(30)], sound=True)
    out = tmp_path / "out.mp4"
    process_video(src, out)
    before, after = (times_of(file)[0] - packets_of(file, "audio")[0][0] for file in (src, out))
    assert after == before
    assert packets_of(out, "audio")[0][0] == 0


def late_video(path, pts, sound=False):
    """A broadcast's video of 90,000 ticks a second, on a clock that says ten in the morning."""
    late = 10 * 3600
    with av.open(str(path), "w", container_options={"mpegts_copyts": "1", "muxdelay": "0"}) as out:
        video = add_video(out, "h264", time_base=Fraction(1, 90000))
        audio = out.add_stream("aac", rate=48000, layout="stereo") if sound else None
        encode_frames(out, video, [late * 90000 + ticks for ticks in pts])
        if audio is not None:
            tone(out, audio, 1.5, start_seconds=late)
    return path


def test_a_late_start_that_is_meant_is_kept(tmp_path):
    src = make_clip(tmp_path / "in.mkv", pts=[2000 + 33 * i for i in range(30)],
                    time_base=Fraction(1, 1000))  # fmt: skip
    process_video(src, tmp_path / "out.mkv")
    assert times_of(tmp_path / "out.mkv")[0] == times_of(src)[0] == 2


@pytest.mark.parametrize("name", ["in.mkv", "in.mp4", "in.ts"])
def test_sound_before_a_late_picture_stays_after_start(tmp_path, name):
    src = tmp_path / name
    with av.open(str(src), "w") as out:
        video = add_video(out, "h264", time_base=Fraction(1, 90000))
        audio = out.add_stream("aac", rate=48000, layout="stereo")
        tone(out, audio, 4)
        encode_frames(out, video, [180000 + 3000 * i for i in range(60)])
    process_video(src, tmp_path / "out.mkv", None, Settings(start_seconds=Fraction(1)))
    sound = [seconds for seconds, *_ in packets_of(tmp_path / "out.mkv", "audio")]
    assert sound[0] == pytest.approx(0, abs=0.03)
    assert sound[-1] == pytest.approx(3, abs=0.05)
    assert max(b - a for a, b in pairwise(sound)) < 0.05
    assert times_of(tmp_path / "out.mkv")[0] == pytest.approx(1, abs=0.05)


def test_words_cost_a_video_no_frames_where_nothing_is_sought(tmp_path):
    """A picture that begins late is decoded from the beginning of the file, without a seek."""
    with av.open(str(tmp_path / "in.mkv"), "w") as out:
        video, text = add_video(out, time_base=Fraction(1, 1000)), add_titles(out, "subrip")
        audio = out.add_stream("aac", rate=48000, layout="stereo")
        write_title(out, text, 500, 3000, b"Hello")
        tone(out, audio, 4)
        encode_frames(out, video, [2000 + 33 * i for i in range(60)])
    cut = Settings(start_seconds=Fraction(1))
    report = process_video(tmp_path / "in.mkv", tmp_path / "out.mkv", None, cut)
    assert report.frames_out == 60 and titles_of(tmp_path / "out.mkv")[0][:2] == (0, 2500)
    assert len(packets_of(tmp_path / "out.mkv", "audio")) == pytest.approx(141, abs=2)


@pytest.mark.parametrize("split", [None, Fraction(1, 60)])
@pytest.mark.parametrize("codec", ["subrip", "ass"])
def test_subtitles_on_screen_at_the_start_are_kept_once(tmp_path, codec, split):
    with av.open(str(tmp_path / "in.mkv"), "w") as out:
        video, text = add_video(out, options={"g": "30"}), add_titles(out, codec)
        for start, length in ((500, 3000), (1800, 400), (2100, 300), (3600, 100)):
            write_title(out, text, start, length, b"Hello %d" % start)
        encode_frames(out, video, range(150))
    cut = Settings(start_seconds=Fraction(2), split_minutes=split)
    process_video(tmp_path / "in.mkv", tmp_path / "out.mkv", None, cut)
    found = titles_of(tmp_path / "out.mkv")
    assert [(start, length, text.strip()) for start, length, text in found] == [
        (0, 1500, b"Hello 500"), (0, 200, b"Hello 1800"), (100, 300, b"Hello 2100"),
        (1600, 100, b"Hello 3600"),
    ]  # fmt: skip


def test_another_video_track_begins_with_a_key_frame(tmp_path):
    with av.open(str(tmp_path / "in.mkv"), "w") as out:
        first, second = (add_video(out, options={"g": "30"}) for _ in range(2))
        encode_frames(out, first, range(90))
        encode_frames(out, second, range(90))
    cut = Settings(start_seconds=Fraction("1.5"), strict=True)
    report = process_video(tmp_path / "in.mkv", tmp_path / "out.mkv", None, cut)
    with av.open(str(tmp_path / "out.mkv")) as container:
        (packet, *_) = container.demux(container.streams.video[1])
        assert packet.is_keyframe and packet.pts * packet.time_base == pytest.approx(0.5, abs=0.002)
    assert report.dropped == ["video #1 (h264): what lies before its first key frame"]


def second_track(path):
    with av.open(str(path)) as container:
        return list(container.decode(container.streams.video[1]))


@pytest.mark.parametrize("end", range(34, 42))
def test_another_video_track_ends_without_broken_pictures(tmp_path, end):
    """A picture between two others needs the later one, which may lie beyond the end."""
    src, dst = tmp_path / "in.mp4", tmp_path / "out.mp4"
    options = {"preset": "medium", "g": "60", "bf": "3", "sc_threshold": "0"}
    with av.open(str(src), "w") as out:
        first, second = add_video(out), add_video(out, options=options)
        encode_frames(out, first, range(60))
        encode_frames(out, second, range(60))
    cut = Settings(end_seconds=Fraction(end, 30), strict=True)
    report = process_video(src, dst, None, cut)
    whole, kept = (second_track(path) for path in (src, dst))
    assert end - 3 <= len(kept) <= end
    assert all((a.to_ndarray() == b.to_ndarray()).all() for a, b in zip(kept, whole, strict=False))
    wanted = ["video #1 (h264): its last pictures, which need later ones"]
    assert report.dropped == (wanted if len(kept) < end else [])
