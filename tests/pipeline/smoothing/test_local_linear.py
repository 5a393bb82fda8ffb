import numpy as np
import pytest
from heads import HEAD_PX, IOD_PX, face, lip_logits
from hypothesis import given, settings
from hypothesis import strategies as st
from makeup_video.pipeline.smoothing.face_space import POSE_REGION, FaceSpace, Readings
from makeup_video.pipeline.smoothing.local_linear import local_linear_taps
from makeup_video.pipeline.smoothing.noise_level import NOISE_MOMENTS, NoiseLevel

SMALL = lip_logits((8, 10))


def heard(points, seconds=None):
    """NoiseLevel after these faces, and their space."""
    seconds = np.arange(len(points)) / 30 if seconds is None else seconds
    space, level = FaceSpace(face(points[0], logits=SMALL)), NoiseLevel()
    readings = Readings(space, len(points))
    for at, each in enumerate(points):
        space.split(face(each, logits=SMALL), readings, at)
        last = range(max(0, at + 1 - NOISE_MOMENTS), at + 1)
        level.update(readings.apart, last, seconds[last].tolist())
    return space, readings, level


@pytest.mark.parametrize("share_of_iod", [0.001, 0.004])
@pytest.mark.parametrize("even", [True, False])
def test_noise_is_told_on_a_still_and_on_a_moving_head(share_of_iod, even):
    rng = np.random.default_rng(0)
    sigma = share_of_iod * IOD_PX
    steps = np.full(60, 1 / 30) if even else rng.uniform(0.015, 0.05, 60)
    seconds = np.cumsum(steps)
    shake = 0.2 * IOD_PX * np.sin(2 * np.pi * 1.5 * seconds)[:, None, None] * [1, 0.3]
    for motion in (0 * shake, shake):
        noise = rng.normal(0, sigma, (60, 478, 2))
        space, _, level = heard(HEAD_PX[0] + motion + noise, seconds)
        lips = np.sqrt(level.variance()[0] / 2) * space._unit  # per axis, px
        assert lips == pytest.approx(sigma, rel=0.15)
    # Of the pose the shake leaves a trace, which must stay well under the noise of a point.
    assert np.sqrt(level.variance()[POSE_REGION]) * space._unit < 1.5 * sigma


def test_blinks_and_syllables_are_not_taken_for_noise():
    space, _, level = heard(HEAD_PX[:120])
    assert np.sqrt(level.variance()[:4]).max() * space._unit < 0.001 * IOD_PX


def test_moments_far_apart_say_nothing():
    rng = np.random.default_rng(1)
    points = HEAD_PX[0] + rng.normal(0, 2, (20, 478, 2))
    _, _, level = heard(points, np.arange(20) / 4)
    assert (level.variance() == NoiseLevel().variance()).all()


@given(
    steps=st.lists(st.floats(1e-6, 1.0), min_size=8, max_size=8),
    hidden=st.sets(st.integers(0, 8)),
    now=st.integers(0, 8),
)
@settings(deadline=None)
def test_taps_sum_to_one_and_leave_out_what_is_not_to_be_used(steps, hidden, now):
    _, readings, level = heard(HEAD_PX[60:69])
    from_now = np.concatenate([[0], np.cumsum(steps)])
    from_now -= from_now[now]
    from_now[list(hidden - {now})] = np.nan
    taps = local_linear_taps(readings.apart, from_now.tolist(), now, level.variance())
    assert np.isfinite(taps).all()
    np.testing.assert_allclose(taps.sum(1), 1, atol=1e-6)
    assert (taps[:, list(hidden - {now})] == 0).all()


def test_a_moment_alone_is_itself():
    _, readings, level = heard(HEAD_PX[:3])
    from_now = np.array([np.nan, 0, np.nan])
    taps = local_linear_taps(readings.apart, from_now.tolist(), 1, level.variance())
    np.testing.assert_allclose(taps, [[0, 1, 0]] * 6)
