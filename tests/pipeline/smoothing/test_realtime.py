"""Smoothing in real time, with camera times: jitter, missing frames and long runs."""

from fractions import Fraction

import numpy as np
import pytest
from heads import HEAD_PX, IOD_PX, face, frame, xy_px
from makeup_video.pipeline.faces.face import FrameFaces
from makeup_video.pipeline.faces.topology import LIPS
from makeup_video.pipeline.live.interfaces import LIVE_TIME_BASE
from makeup_video.pipeline.smoothing import realtime
from makeup_video.pipeline.smoothing.lookahead import SmoothAhead
from makeup_video.pipeline.smoothing.realtime import SmoothLive

_LIPS_APART = 13, 14  # inner rims in the middle


def recorded(points_px, seconds):
    return [
        FrameFaces(frame(round(second * 1_000_000), LIVE_TIME_BASE), (face(points),))
        for points, second in zip(points_px, seconds, strict=True)
    ]


def noisy(points_px, seed=0, share=0.003):
    rng = np.random.default_rng(seed)
    return points_px + rng.normal(0, share * IOD_PX, points_px.shape)


def live(points_px, seconds):
    return xy_px(list(map(SmoothLive(), recorded(points_px, seconds))))


def stamps(kind, count, tick=1 / 30):
    """Arrival times of frames that were taken every tick, s."""
    rng = np.random.default_rng(5)
    taken = 1000 + np.arange(count) * tick
    if kind == "late at random":
        return taken + np.abs(rng.normal(0, 0.2 * tick, count))
    if kind == "in pairs":  # a driver that delivers two frames at once
        return taken + np.where(np.arange(count) % 2, 0.0, tick - 0.001)
    return taken


def opening(points_px):
    upper, lower = _LIPS_APART
    return np.linalg.norm(points_px[:, upper] - points_px[:, lower], axis=1)


def lag_frames(got, true):
    """The shift in time, in frames, that best aligns the mouth's opening with the true one."""
    index = np.arange(len(got))
    lags = np.arange(-1, 3, 0.05)
    off = [np.square(np.interp(index - lag, index, true) - got)[5:-5].mean() for lag in lags]
    return lags[int(np.argmin(off))]


@pytest.mark.parametrize("kind", ["even", "late at random", "in pairs"])
def test_speech_does_not_lag_by_half_a_frame(kind):
    got = live(noisy(HEAD_PX[:200]), stamps(kind, 200))
    assert abs(lag_frames(opening(got), opening(HEAD_PX[:200]))) < 0.5


@pytest.mark.parametrize(
    ("kind", "most"), [("even", 0.9), ("late at random", 0.9), ("in pairs", 1.1)]
)
def test_smoothed_points_are_no_worse_than_the_readings(kind, most):
    """With raw times, the squared error of frames in pairs would be almost five times as large."""
    read = noisy(HEAD_PX[:200])
    off = live(read, stamps(kind, 200)) - HEAD_PX[:200]
    assert np.square(off).mean() < most * np.square(read - HEAD_PX[:200]).mean()


@pytest.mark.parametrize("every", [2, 4])
def test_a_camera_or_a_machine_of_fewer_frames_is_followed(every):
    true = HEAD_PX[:240:every]
    got = live(noisy(true), 1000 + np.arange(len(true)) * every / 30)
    assert np.abs(got - true)[:, LIPS].mean() < 0.004 * IOD_PX
    assert lag_frames(opening(got), opening(true)) < 0.5


def test_a_still_face_is_steady_however_frames_arrive():
    still = np.repeat(HEAD_PX[:1], 300, 0)
    read = noisy(still)
    for kind in ("even", "late at random"):
        got = live(read, stamps(kind, 300, 1 / 60))
        assert (got - still)[30:].std() < 0.5 * (read - still)[30:].std()


def test_a_camera_that_speeds_up_keeps_the_filter_of_a_face(monkeypatch):
    """Evened times then run ahead for a while, by more than an absence may take."""
    begun, new = [], realtime._Filter
    monkeypatch.setattr(realtime, "_Filter", lambda *given: begun.append(given) or new(*given))
    seconds = 1000 + np.cumsum([1 / 10] * 40 + [1 / 30] * 60)
    live(noisy(HEAD_PX[:100]), seconds)
    assert len(begun) == 1


def test_dropped_frames_do_no_harm():
    rng = np.random.default_rng(2)
    arrived = np.sort(rng.choice(240, 150, replace=False))
    read = noisy(HEAD_PX[:240])[arrived]
    got = live(read, 1000 + arrived / 30)
    assert np.square(got - HEAD_PX[arrived]).mean() < np.square(read - HEAD_PX[arrived]).mean()


def test_smoothing_is_the_same_after_minutes_and_months():
    long = np.concatenate([HEAD_PX, HEAD_PX[::-1]] * 31)[:18000]
    read = noisy(HEAD_PX[:60], seed=4)
    stage = SmoothLive()
    for item in recorded(long[::6], 1000 + np.arange(3000) / 5 * 1.0001):
        stage(item)
    start = 1000 + 600 + 5
    got = xy_px(list(map(stage, recorded(read, start + np.arange(60) / 30))))
    np.testing.assert_allclose(got, live(read, 1000 + np.arange(60) / 30), atol=0.02)
    months = live(read, 2e7 + np.arange(60) / 30)
    np.testing.assert_allclose(months, live(read, 1000 + np.arange(60) / 30), atol=0.02)


def test_look_ahead_is_hardly_better_than_realtime():
    true = HEAD_PX[:200]
    items = recorded(noisy(true), 1000 + np.arange(200) / 30)
    ahead = SmoothAhead()
    files = [x for x in map(ahead, items) if x is not None] + list(ahead.drain())
    at_once = list(map(SmoothLive(), items))
    off = [np.sqrt(np.square(xy_px(points) - true)[:, LIPS].mean()) for points in (files, at_once)]
    assert off[1] < 1.6 * off[0] + 0.0005 * IOD_PX


def test_the_smoother_uses_the_time_base_of_live_frames():
    assert Fraction(1, 1_000_000) == LIVE_TIME_BASE
