"""The light on faces over time: steady, gradual, and estimated anew after a cut."""

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from lit_faces import assert_sane, face_at, light, lit, points
from makeup_video.pipeline.faces.face import FrameFaces
from makeup_video.pipeline.render.scene_light import EstimateLight, light_of
from people import frame_of, portrait


def test_the_environment_shows_the_frame_where_it_is():
    picture = np.zeros((360, 640, 3), np.uint8)
    picture[:, :320] = 255
    picture[:90, 320:] = (0, 0, 255)
    (estimated,) = light_of(FrameFaces(frame_of(picture), (face_at(points()),)))
    assert estimated.environment.shape == (16, 16, 3) and estimated.environment.dtype == np.float32
    assert estimated.environment[:, :7].min() > 0.95 and estimated.environment[5:, 9:].max() < 0.05
    blue = estimated.environment[:3, 9:]
    assert blue[..., 2].min() > 0.8 and blue[..., :2].max() < 0.1


def lights_over_time(pictures, fps, faces=None, cut_at=None):
    """Yield (seconds, lights) for two seconds of the frames pictures(seconds), at fps frames/s."""
    estimate = EstimateLight()
    for index in range(round(2 * fps)):
        seconds = index / fps
        frame = replace(pictures(seconds), pts=index, time_base=Fraction(1, fps))
        item = FrameFaces(frame, faces or (face_at(points()),), seconds == cut_at)
        yield seconds, estimate(item)


def switched(at_seconds, before=1.0, after=0.4):
    """Return a function of seconds that gives frames whose light is switched at a moment."""
    frames = frame_of(lit(*[before] * 3)), frame_of(lit(*[after] * 3))
    return lambda seconds: frames[seconds >= at_seconds]


def test_the_light_follows_by_time_not_by_frames():
    strengths = {}
    for fps in (15, 30, 60):
        strengths[fps] = {
            round(seconds, 3): lights[0].strength
            for seconds, lights in lights_over_time(switched(0.4), fps)
            if abs(seconds * 15 - round(seconds * 15)) < 1e-6
        }
    for seconds, want in strengths[30].items():
        for fps in (15, 60):  # all rates estimate the light at 0.4 s
            assert strengths[fps][seconds] == pytest.approx(want, rel=0.04)


def test_a_change_of_light_comes_gradually():
    strengths = [lights[0].strength for _, lights in lights_over_time(switched(0.4), 30)]
    start, end = light(lit(1, 1, 1)).strength, light(lit(0.4, 0.4, 0.4)).strength
    assert strengths[0] == pytest.approx(start) and strengths[11] == pytest.approx(start)
    assert np.diff(strengths).max() < 1e-6
    assert strengths[12 + 15] == pytest.approx(end + (start - end) * np.exp(-1), abs=0.06)
    assert strengths[-1] == pytest.approx(end, rel=0.05)


def test_a_cut_starts_afresh():
    lights = [lights[0] for _, lights in lights_over_time(switched(0.5), 30, cut_at=0.5)]
    want = light(lit(0.4, 0.4, 0.4))
    assert lights[15].strength == pytest.approx(want.strength)
    np.testing.assert_array_equal(lights[15].environment, want.environment)


def test_each_face_has_its_own_light_and_all_share_the_room():
    bright, dark = np.ascontiguousarray(lit(1, 1, 1)), lit(0.3, 0.3, 0.3)
    frame = frame_of(np.hstack([bright, dark]))
    beside = points() + np.array([bright.shape[1], 0, 0])
    faces = face_at(points(), 3), face_at(beside, 8), face_at(beside, 8)
    estimate = EstimateLight()
    for pts in range(3):
        left, right, twin = estimate(FrameFaces(replace(frame, pts=pts), faces))
        assert left.strength > 1.3 * right.strength
        assert twin.strength == pytest.approx(right.strength, rel=0.01)
        assert left.environment is right.environment


def test_clocks_that_stand_still_or_jump_back_do_no_harm():
    estimate, frame = EstimateLight(), frame_of(portrait())
    face = face_at(points())
    for pts in (0, 1, 1, 500, 3, 4, -90, 10**9, 10**9):
        assert_sane(estimate(FrameFaces(replace(frame, pts=pts), (face,)))[0])


def test_a_face_that_was_long_away_is_read_anew():
    estimate, face = EstimateLight(), face_at(points())
    bright, dark = frame_of(portrait()), frame_of(lit(0.3, 0.3, 0.3))
    estimate(FrameFaces(bright, (face,)))
    assert estimate(FrameFaces(replace(dark, pts=30), ())) == ()
    (estimated,) = estimate(FrameFaces(replace(dark, pts=150), (face,)))
    assert estimated.strength == pytest.approx(light(lit(0.3, 0.3, 0.3)).strength)


def test_the_room_follows_a_change():
    moved = [lights[0].environment for _, lights in lights_over_time(switched(0.4), 30)]
    (end,) = light_of(FrameFaces(switched(0)(0), (face_at(points()),)))
    assert np.abs(moved[12] - end.environment).max() > 0.03
    assert np.abs(moved[-1] - end.environment).max() < 0.03
