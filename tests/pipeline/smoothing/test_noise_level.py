"""The measured noise of a face's readings, and its removal by smoothing."""

from fractions import Fraction

import numpy as np
import pytest
from heads import (
    HEAD_PX,
    IOD_PX,
    LOWER_LID,
    UPPER_LID,
    face,
    frames_of,
    lip_logits,
    rms,
    run_stage,
    xy_px,
)
from makeup_video.pipeline.faces.topology import LIPS
from makeup_video.pipeline.smoothing.face_space import POSE_PART
from makeup_video.pipeline.smoothing.lookahead import SmoothAhead
from makeup_video.pipeline.smoothing.noise_level import NoiseLevel
from makeup_video.pipeline.smoothing.realtime import SmoothLive
from noisy_heads import SMALL, STAGES, measure_noise, noise_px


@pytest.mark.parametrize("share_of_iod", [0.001, 0.004])
@pytest.mark.parametrize("even", [True, False])
def test_noise_is_measured_on_still_and_moving_heads(share_of_iod, even):
    rng = np.random.default_rng(0)
    sigma = share_of_iod * IOD_PX
    steps = np.full(60, 1 / 30) if even else rng.uniform(0.015, 0.05, 60)
    seconds = np.cumsum(steps)
    shake = 0.2 * IOD_PX * np.sin(2 * np.pi * 1.5 * seconds)[:, None, None] * [1, 0.3]
    for motion in (0 * shake, shake):
        noise = rng.normal(0, sigma, (60, 478, 2))
        space, _, level = measure_noise(HEAD_PX[0] + motion + noise, seconds)
        lips = np.sqrt(level.variance()[0] / 2) * space._unit  # per axis, px
        assert lips == pytest.approx(sigma, rel=0.15)
    # The shake leaves a trace in the pose, which must stay well below the noise of a point.
    assert np.sqrt(level.variance()[POSE_PART]) * space._unit < 1.5 * sigma


def test_blinks_and_syllables_are_not_taken_for_noise():
    space, _, level = measure_noise(HEAD_PX[:120])
    assert np.sqrt(level.variance()[:4]).max() * space._unit < 0.001 * IOD_PX


def test_moments_far_apart_do_not_change_the_noise_level():
    rng = np.random.default_rng(1)
    points = HEAD_PX[0] + rng.normal(0, 2, (20, 478, 2))
    _, _, level = measure_noise(points, np.arange(20) / 4)
    assert (level.variance() == NoiseLevel().variance()).all()


@pytest.mark.parametrize("stage", STAGES)
@pytest.mark.parametrize("start", range(0, 150, 30))
def test_at_ten_frames_a_second_speech_is_not_smoothed_away(stage, start):
    """Few frames of speech look like noise, at a face's first moments above all."""
    true = HEAD_PX[start::3][:40]
    noise = noise_px(len(true), 0.001)
    frames = frames_of([face(p, logits=SMALL) for p in true + noise], Fraction(1, 10))
    error = xy_px(run_stage(stage(), frames)) - true
    assert rms(error, LIPS) < 1.7 * rms(noise, LIPS)


@pytest.mark.parametrize("stage", STAGES)
def test_at_ten_frames_a_second_a_still_face_is_smoothed(stage):
    noise = noise_px(60, 0.004)
    frames = frames_of([face(HEAD_PX[0] + n, logits=SMALL) for n in noise], Fraction(1, 10))
    error = xy_px(run_stage(stage(), frames)) - HEAD_PX[0]
    inside = slice(8, -8)
    assert rms(noise[inside], LIPS) > 1.5 * rms(error[inside], LIPS)


@pytest.mark.parametrize("share_of_iod", [0.001, 0.004])
@pytest.mark.parametrize(("stage", "times"), [(SmoothAhead, 2.4), (SmoothLive, 2.2)])
def test_jitter_of_a_still_face_falls(stage, times, share_of_iod):
    noise = noise_px(150, share_of_iod)
    got = xy_px(run_stage(stage(), frames_of([face(HEAD_PX[0] + n) for n in noise])))
    inside = slice(12, 138)
    error = (got - HEAD_PX[0])[inside]
    assert rms(noise[inside], LIPS) > times * rms(error, LIPS)
    assert rms(noise[inside]) > times * rms(error)
    # The jitter from frame to frame, which is visible as shimmer, falls further.
    assert rms(np.diff(noise[inside], axis=0), LIPS) > 2 * times * rms(np.diff(error, axis=0), LIPS)


def test_a_talking_head_is_never_worse_than_unsmoothed():
    noise = noise_px(300)
    got = xy_px(run_stage(SmoothAhead(), frames_of([face(p) for p in HEAD_PX + noise])))
    error = got - HEAD_PX
    lids = [159, 145, 158, 153, 160, 144, 386, 374, 385, 380, 387, 373]
    for points in (LIPS, lids, slice(None)):
        assert rms(noise, points) > 1.15 * rms(error, points)
    speed_px = np.linalg.norm(np.gradient(HEAD_PX.mean(1), axis=0), axis=1)
    fast = speed_px > 3
    assert rms(noise[fast]) > 1.3 * rms(error[fast])


def opening_px(points_px, upper, lower):
    return np.linalg.norm(points_px[:, upper] - points_px[:, lower], axis=1)


@pytest.mark.parametrize(("stage", "share"), [(SmoothAhead, 0.97), (SmoothLive, 0.95)])
def test_a_blink_keeps_its_depth_and_its_moment(stage, share):
    got = xy_px(run_stage(stage(), frames_of([face(p) for p in HEAD_PX + noise_px(300, 0.002)])))
    true, smoothed = (opening_px(p, UPPER_LID, LOWER_LID) for p in (HEAD_PX, got))
    shut = np.flatnonzero(true < 3.5)  # of 21 px
    assert len(shut) > 10
    assert ((true.max() - smoothed[shut]) / (true.max() - true[shut])).mean() > share
    assert ((true.max() - smoothed[shut]) / (true.max() - true[shut])).min() > 0.9


@pytest.mark.parametrize("stage", STAGES)
def test_lips_closed_for_two_frames_stay_closed(stage):
    """The b of a fast "aba": an open mouth closes for 60 ms."""
    wide, closed = HEAD_PX[195], HEAD_PX[2]
    true = np.repeat(wide[None], 60, 0)
    for index in (30, 31):
        true[index, LIPS] = closed[LIPS] - closed[LIPS].mean(0) + wide[LIPS].mean(0)
    got = xy_px(run_stage(stage(), frames_of([face(p) for p in true + noise_px(60, 0.002)])))
    true_px, seen_px = (opening_px(p, 13, 14) for p in (true, got))
    drop_px = true_px[20] - true_px[30]
    assert drop_px > 20
    assert true_px[20] - seen_px[30] > 0.9 * drop_px
    assert true_px[20] - seen_px[31] > 0.9 * drop_px
    assert abs(seen_px[29] - true_px[29]) < 0.1 * drop_px
    assert abs(seen_px[32] - true_px[32]) < 0.1 * drop_px


@pytest.mark.parametrize("hz", [1.0, 2.5])
@pytest.mark.parametrize("axis", [0, 1])
def test_a_shaken_or_nodding_head_is_followed(hz, axis):
    seconds = np.arange(120) / 30
    move = np.zeros((120, 1, 2))
    move[:, 0, axis] = 0.3 * IOD_PX * np.sin(2 * np.pi * hz * seconds)
    true = HEAD_PX[0] + move
    ahead = xy_px(run_stage(SmoothAhead(), frames_of([face(p) for p in true]))) - true
    live = xy_px(run_stage(SmoothLive(), frames_of([face(p) for p in true]))) - true
    assert np.abs(ahead).max() < 0.005 * IOD_PX
    assert np.abs(live)[10:].max() < 0.01 * IOD_PX


@pytest.mark.parametrize(("stage", "times"), [(SmoothAhead, 2.4), (SmoothLive, 2.2)])
def test_noise_of_the_lip_patch_falls(stage, times):
    rng = np.random.default_rng(2)
    clean = lip_logits()
    noise = rng.normal(0, 0.7, (60, 80, 112)) + rng.normal(0, 0.2, (60, 1, 1))
    got = run_stage(stage(), frames_of([face(HEAD_PX[0], logits=clean + n) for n in noise]))
    error = np.array([item.faces[0].lips.logits for item in got]) - clean
    assert noise[10:50].std() > times * error[10:50].std()


@pytest.mark.parametrize(("stage", "frames"), [(SmoothAhead, 1), (SmoothLive, 2)])
def test_a_hand_in_front_of_the_mouth_counts_at_once(stage, frames):
    """The points stay, only the patch changes: lipstick must vanish within a frame or two."""
    rng = np.random.default_rng(3)
    clean, hidden = lip_logits(), lip_logits()
    hidden[:, 56:] = -8
    noise = rng.normal(0, 0.5, (40, 80, 112))
    items = frames_of(
        [
            face(p, logits=(hidden if i >= 20 else clean) + n, mouth_visible=0.2 if i >= 20 else 1)
            for i, (p, n) in enumerate(zip(HEAD_PX[0] + noise_px(40), noise, strict=True))
        ]
    )
    got = run_stage(stage(), items)
    right = [item.faces[0].lips.logits[36:44, 62:80].mean() for item in got]
    assert min(right[12:20]) > 1.5
    assert max(right[19 + frames :]) < -7
    visible = [item.faces[0].mouth_visible for item in got]
    assert min(visible[:18]) > 0.95 and max(visible[22:]) < 0.3
