"""Times of decoded frames: strictly increasing, and unchanged where they already increase."""

from fractions import Fraction
from itertools import pairwise
from types import SimpleNamespace

import av
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from makeup_video.pipeline import process_video
from makeup_video.pipeline.media.frame_times import FrameTimes, until_next
from media import decoded, make_clip


def times_for(pts, durations=None, dts=None, container="mp4"):
    """Return (times, FrameTimes) for frames with these values, in ticks of 1/1000 s."""
    context = SimpleNamespace(has_b_frames=True)
    source = SimpleNamespace(
        time_base=Fraction(1, 1000),
        container=SimpleNamespace(format=SimpleNamespace(name=container)),
        video=SimpleNamespace(name="h264", codec_context=context),
    )
    times = FrameTimes(source)
    durations, dts = durations or [40] * len(pts), dts or [None] * len(pts)
    frames = [
        SimpleNamespace(pts=p, dts=d, duration=length)
        for p, d, length in zip(pts, dts, durations, strict=True)
    ]
    return [times(frame) for frame in frames], times


@given(st.lists(st.integers(-(2**40), 2**40), unique=True, min_size=1).map(sorted))
def test_times_that_increase_stay_as_they_are(pts):
    got, times = times_for(pts)
    assert got == pts and times.mended == 0


@given(st.lists(st.none() | st.integers(-(2**66), 2**66), min_size=1))
def test_any_times_become_strictly_increasing(pts):
    got, times = times_for(pts)
    assert all(a < b for a, b in pairwise(got))
    assert times.mended <= len(pts) and times.last_pts == got[-1]


def test_a_missing_time_follows_the_picture_before():
    got, times = times_for([0, None, None, 500])
    assert got == [0, 40, 80, 500] and times.mended == 2


def test_absurd_durations_do_not_move_the_next_picture():
    got, _ = times_for([0, None], durations=[2**63, 40])
    assert got == [0, 1]


def test_h264_in_avi_is_timed_by_its_decoding_order():
    got, times = times_for([80, 0, 40], dts=[-40, 0, 40], container="avi")
    assert got == [80, 120, 160] and times.mended == 0


@given(
    st.integers(2, 40), st.integers(0, 5), st.lists(st.integers(2, 60), min_size=400, max_size=400)
)
def test_after_a_repeated_time_the_clock_returns_to_the_files(before, again, steps):
    own = [sum(steps[:at]) for at in range(before)]
    own += own[-1 - min(again, before - 1) :]  # repeat times that came before
    own += [own[-1] + sum(steps[: at + 1]) for at in range(400)]
    got, _ = times_for(own, durations=[60] * len(own))  # longer than all steps
    assert all(a < b for a, b in pairwise(got))
    assert got[-1] == own[-1]


def test_after_a_clock_begins_anew_pictures_keep_their_length():
    got, _ = times_for([9000, 9040, 0, 40, 80])
    assert got == [9000, 9040, 9080, 9120, 9160]


@given(
    pts=st.lists(st.integers(-500, 500), unique=True, min_size=1).map(sorted),
    lengths=st.lists(st.integers(0, 600), min_size=100, max_size=100),
    end=st.none() | st.integers(-600, 600),
    stays=st.booleans(),
)
@example(pts=[0], lengths=[9] * 100, end=5, stays=False)
def test_no_picture_is_shown_beyond_the_next_one(pts, lengths, end, stays):
    pictures = [SimpleNamespace(duration=length) for length in lengths[: len(pts)]]
    got = list(until_next(zip(pictures, pts, strict=False), end, lambda: stays))
    assert [(picture, begin) for picture, begin, _ in got] == list(zip(pictures, pts, strict=False))
    known = end is not None and end > pts[-1]
    ends = [*pts[1:], end if known else pts[-1] + 600]
    if stays and known:
        *got, (_, begin, duration) = got
        assert duration == ends.pop() - begin
    for (picture, begin, duration), until in zip(got, ends, strict=True):
        assert duration == min(picture.duration, until - begin)


@pytest.mark.parametrize("still_at", [20, 40, 57])
@pytest.mark.parametrize("codec", ["h264", "hevc"])
def test_a_picture_that_stands_still_makes_no_video_longer(tmp_path, codec, still_at):
    """mp4 stores durations in decoding order, where a different picture may come next."""
    pts = [i if i < still_at else i + 150 for i in range(60)]
    src = make_clip(tmp_path / "in.mp4", codec, pts=pts, options={"bf": "3"})
    assert max(frame.duration for frame in decoded(src)) > 100 * 512
    for end in (".mp4", ".mkv"):
        report = process_video(src, tmp_path / f"out{end}")
        assert float(report.media_seconds) == pytest.approx(7, abs=0.01)
        with av.open(str(tmp_path / f"out{end}")) as container:
            assert container.duration / 1e6 == pytest.approx(7, abs=0.04)
