"""A video is split at key frames, at least so many seconds apart, with a run-up before each."""

from contextlib import closing
from fractions import Fraction

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from makeup_video.pipeline.media.input_file import open_video
from makeup_video.pipeline.media.segments import RUN_UP_SECONDS, Segment, plan_segments
from media import make_clip
from split_videos import VARIABLE

TICK = Fraction(1, 600)


@pytest.fixture(scope="module")
def video(tmp_path_factory):
    path = tmp_path_factory.mktemp("video") / "in.mp4"
    make_clip(path, pts=VARIABLE, time_base=TICK, options={"g": "5"})
    source = open_video(path)
    keys = {packet.pts for packet in source.container.demux(source.video) if packet.is_keyframe}
    source.close()
    return path, keys


@given(seconds=st.fractions(Fraction(1, 100), 10, max_denominator=100), run_up=st.booleans())
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture], max_examples=50)
def test_segments_share_out_the_video(video, seconds, run_up):
    path, keys = video
    source = open_video(path)
    tick = source.time_base
    plan = plan_segments(source, seconds, run_up=run_up)
    source.close()
    ticks = [round(n * TICK / tick) for n in VARIABLE]
    if len(plan.segments) == 1:
        # a scene of 5 s has no key frame in its midst
        assert ticks[-1] * tick < 2 * seconds + 7
        return
    # every frame belongs to one segment
    assert all(sum(one.holds(pts) for one in plan.segments) == 1 for pts in ticks)
    for before, one in zip(plan.segments, plan.segments[1:], strict=False):
        assert one.first in keys and before.end == one.first
        assert (one.first - before.first) * tick >= seconds
        assert (ticks[-1] - one.first) * tick >= seconds / 2
        if run_up:
            settled = [pts for pts in ticks if one.run_up <= pts < one.first]
            assert one.run_up in ticks
            assert one.run_up == ticks[0] or len(settled) >= 8
            before_it = [pts for pts in ticks if pts < one.run_up]
            assert all((one.first - pts) * tick > RUN_UP_SECONDS for pts in before_it)
        else:
            assert one.run_up == one.first
    assert plan.segments[0].run_up is None and plan.segments[-1].end is None


def test_no_seam_lies_between_frames_a_millisecond_apart(tmp_path):
    """In Matroska's milliseconds, both could have the same time."""
    ticks = [3000 * number for number in range(90)]
    ticks[29] = ticks[30] - 90
    src = make_clip(
        tmp_path / "in.mp4", pts=ticks, time_base=Fraction(1, 90000),
        options={"g": "30", "bf": "0"}, container_options={"video_track_timescale": "90000"},
    )  # fmt: skip
    with closing(open_video(src)) as source:
        plan = plan_segments(source, Fraction(1))
    assert [one.first for one in plan.segments] == [0, ticks[60]]


def test_times_of_a_segment_are_those_of_the_output():
    """The video begins before 0, so all of its times move."""
    one = Segment(first=100, end=200, run_up=40, shift=-10)
    assert [one.is_unseen(pts) for pts in (49, 50)] == [True, False]
    assert [one.is_before(pts) for pts in (109, 110)] == [True, False]
    assert [one.holds(pts) for pts in (109, 110, 209, 210)] == [False, True, True, False]
    assert [one.is_after(pts) for pts in (209, 210)] == [False, True]
