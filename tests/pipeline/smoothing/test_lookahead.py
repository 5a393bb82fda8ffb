"""Smoothing with look-ahead: every frame comes out once, steady and without lag."""

from fractions import Fraction

import numpy as np
import pytest
from heads import HEAD_PX, IOD_PX, face, frame, frames_of, lip_logits, run_stage, xy_px
from hypothesis import given, settings
from hypothesis import strategies as st
from makeup_video.pipeline.engine.runner import Runner
from makeup_video.pipeline.faces.face import FrameFaces
from makeup_video.pipeline.faces.topology import LIPS
from makeup_video.pipeline.smoothing import lookahead
from makeup_video.pipeline.smoothing.lookahead import SmoothAhead
from makeup_video.pipeline.smoothing.realtime import SmoothLive
from noisy_heads import STAGES, noise_px

SMALL = lip_logits((8, 10))  # a small patch is fast, and any size is valid


def all_finite(items):
    return all(
        np.isfinite(found.points_px).all()
        and np.isfinite(found.lips.logits).all()
        and np.isfinite(found.lips.to_px).all()
        and 0 <= found.score <= 1
        and 0 <= found.mouth_visible <= 1
        for item in items
        for found in item.faces
    )


moments = st.lists(
    st.tuples(
        st.sampled_from([-400, -33, 0, 1, 17, 33, 33, 33, 42, 100, 160, 3000]),  # ms to the next
        st.sets(st.integers(0, 2)),  # visible tracks
        st.sampled_from([False] * 9 + [True]),  # cut
        st.integers(0, 299),  # frame of the head
    ),
    max_size=25,
)


def timeline(script):
    """FrameFaces of a drawn script; faces jump, shrink, grow and turn."""
    items, pts = [], 0
    for step, who, cut, pose in script:
        faces = []
        for track in sorted(who):
            size = (1, 0.05, 7, 0)[(pose + track) % 4 if pose % 7 == 0 else 0]
            turned = HEAD_PX[pose][:, ::-1] if pose % 11 == 0 else HEAD_PX[pose]
            faces.append(face(turned * size + 500 * track, track, SMALL))
        items.append(FrameFaces(frame(pts, Fraction(1, 1000)), tuple(faces), cut))
        pts += step
    return items


@pytest.mark.parametrize("stage", STAGES)
@given(script=moments)
@settings(deadline=None, max_examples=60)
def test_frames_come_out_once_in_order_with_their_faces(stage, script):
    items = timeline(script)
    before = [[found.points_px.copy() for found in item.faces] for item in items]
    out = run_stage(stage(), items)
    assert [item.frame for item in out] == [item.frame for item in items]
    assert [item.cut for item in out] == [item.cut for item in items]
    ids = [[found.track_id for found in item.faces] for item in items]
    assert [[found.track_id for found in item.faces] for item in out] == ids
    assert all_finite(out)
    for item, points in zip(items, before, strict=True):
        assert all((a.points_px == b).all() for a, b in zip(item.faces, points, strict=True))


@given(script=moments)
@settings(deadline=None, max_examples=40)
def test_the_live_output_does_not_depend_on_later_frames(script):
    items = timeline(script)
    half = len(items) // 2
    whole, first = run_stage(SmoothLive(), items), run_stage(SmoothLive(), items[:half])
    for a, b in zip(whole, first, strict=False):
        assert all(
            (x.points_px == y.points_px).all() for x, y in zip(a.faces, b.faces, strict=True)
        )


@pytest.mark.parametrize("stage", STAGES)
def test_another_time_base_gives_the_same_points(stage):
    faces = [face(points, logits=SMALL) for points in HEAD_PX[60:90]]
    a = run_stage(stage(), frames_of(faces, Fraction(1, 30)))
    b = run_stage(stage(), frames_of(faces, Fraction(1, 90000), 3000))
    assert (xy_px(a) == xy_px(b)).all()


@pytest.mark.parametrize("stage", STAGES)
def test_a_later_start_time_gives_the_same_points(stage):
    faces = [face(points, logits=SMALL) for points in HEAD_PX[60:90]]
    late = [FrameFaces(frame(index + 12360), (still,), False) for index, still in enumerate(faces)]
    # 412 s is a whole number of all slots; seconds are subtracted in floating point.
    np.testing.assert_allclose(
        xy_px(run_stage(stage(), frames_of(faces))), xy_px(run_stage(stage(), late)), atol=1e-3
    )


@pytest.mark.parametrize("stage", STAGES)
@pytest.mark.parametrize("iod_px", [20, 190, 1500])
def test_a_face_that_stays_is_left_as_it_is(stage, iod_px):
    rng = np.random.default_rng(1)
    still = face(HEAD_PX[100] * iod_px / IOD_PX, logits=rng.normal(0, 4, (80, 112)))
    for item in run_stage(stage(), frames_of([still] * 14)):
        got = item.faces[0]
        np.testing.assert_allclose(got.points_px, still.points_px, atol=2e-6 * iod_px + 1e-3)
        np.testing.assert_allclose(got.lips.logits, still.lips.logits, atol=1e-5)
        np.testing.assert_allclose(got.lips.to_px, still.lips.to_px, atol=2e-6 * iod_px)
        assert got.score == pytest.approx(0.9) and got.mouth_visible == pytest.approx(1.0)


def steady(count, every=1):
    """A head that moves across the picture at constant speed, without noise."""
    index = np.arange(count)[:, None, None] * every
    return HEAD_PX[0] + index * [3.7, -1.3]


@pytest.mark.parametrize("time_base", [Fraction(1, 24), Fraction(1, 30), Fraction(1, 60)])
def test_steady_motion_in_a_file_does_not_lag_at_any_frame(time_base):
    true = steady(30)
    got = xy_px(run_stage(SmoothAhead(), frames_of([face(points) for points in true], time_base)))
    assert np.abs(got - true).max() < 2e-3  # float32


@given(steps=st.lists(st.integers(8, 60), min_size=1, max_size=20))
@settings(deadline=None, max_examples=30)
def test_steady_motion_does_not_lag_at_a_variable_frame_rate(steps):
    pts = np.concatenate([[0], np.cumsum(steps)])
    true = HEAD_PX[0] + pts[:, None, None] * [0.11, -0.04]
    items = [
        FrameFaces(frame(int(t), Fraction(1, 1000)), (face(points, logits=SMALL),))
        for t, points in zip(pts, true, strict=True)
    ]
    assert np.abs(xy_px(run_stage(SmoothAhead(), items)) - true).max() < 2e-3


def test_steady_live_motion_lags_less_than_a_third_of_a_frame():
    true = steady(40)
    got = xy_px(run_stage(SmoothLive(), frames_of([face(points) for points in true])))
    assert np.abs(got - true)[5:].max() < 3.7 / 3


@pytest.mark.parametrize("stage", STAGES)
def test_a_step_at_a_cut_is_untouched(stage):
    before, after = face(HEAD_PX[0]), face(HEAD_PX[190] * 0.7 + [400, 90])
    items = frames_of([before] * 10 + [after] * 10)
    items[10] = FrameFaces(items[10].frame, items[10].faces, cut=True)
    got = run_stage(stage(), items)
    for item, want in zip(got, items, strict=True):
        np.testing.assert_allclose(item.faces[0].points_px, want.faces[0].points_px, atol=1e-3)


@pytest.mark.parametrize("stage", STAGES)
def test_nothing_is_smoothed_across_a_cut(stage):
    noise = noise_px(20)
    items = frames_of([face(HEAD_PX[0] + n) for n in noise])
    items[10] = FrameFaces(items[10].frame, items[10].faces, cut=True)
    whole = xy_px(run_stage(stage(), items))
    second = xy_px(run_stage(stage(), items[10:]))
    np.testing.assert_allclose(whole[10:], second, atol=1e-3)


@pytest.mark.parametrize("stage", STAGES)
@pytest.mark.parametrize(("away", "begins_anew"), [(2, False), (8, True)])
def test_a_face_that_was_away_for_long_begins_anew(stage, away, begins_anew):
    noise = noise_px(30)
    faces = [face(HEAD_PX[0] + n) for n in noise]
    faces[10 : 10 + away] = [None] * away
    items = frames_of(faces)
    got = run_stage(stage(), items)[10 + away :]
    alone = run_stage(stage(), items[10 + away :])
    same = np.abs(xy_px(got) - xy_px(alone)).max() < 1e-3
    assert same == begins_anew


@pytest.mark.parametrize("stage", STAGES)
@given(share_of_iod=st.floats(0.0005, 0.01), seed=st.integers(0, 1000))
@settings(deadline=None, max_examples=10)
def test_lips_do_not_move_with_errors_of_the_pose(stage, share_of_iod, seed):
    """All other points jump from frame to frame, as where some frames alone are read anew."""
    still = np.repeat(HEAD_PX[:1], 40, 0)
    rng = np.random.default_rng(seed)
    others = ~np.isin(np.arange(still.shape[1]), LIPS)
    read = still.copy()
    read[:, others] += rng.normal(0, share_of_iod * IOD_PX, (40, 1, 2))
    got = xy_px(run_stage(stage(), frames_of([face(points, logits=SMALL) for points in read])))
    assert np.abs(got - still)[:, LIPS].max() < 2e-3  # px


def test_missed_frames_cause_no_false_motion():
    """A head at constant speed that is missed in two frames does not lag in the others."""
    true = steady(24)
    faces = [face(points) for points in true]
    faces[11:13] = [None, None]
    for item, points in zip(run_stage(SmoothAhead(), frames_of(faces)), true, strict=True):
        for found in item.faces:
            assert np.abs(found.points_px[:, :2] - points).max() < 2e-3


@pytest.mark.parametrize("stage", STAGES)
def test_two_faces_do_not_influence_each_other(stage):
    noise = noise_px(20)
    left = [face(HEAD_PX[0] + n, 4) for n in noise]
    right = [face(HEAD_PX[i] + [900, 0], 7) for i in range(20)]
    both = [FrameFaces(frame(i), (a, b)) for i, (a, b) in enumerate(zip(left, right, strict=True))]
    got, alone = run_stage(stage(), both), run_stage(stage(), frames_of(left))
    for a, b in zip(got, alone, strict=True):
        assert (a.faces[0].points_px == b.faces[0].points_px).all()


@pytest.mark.parametrize("stage", STAGES)
def test_faces_of_one_number_in_one_frame_do_not_mix(stage):
    near, far = face(HEAD_PX[0], 3), face(HEAD_PX[0] * 0.4 + [800, 0], 3)
    got = run_stage(stage(), [FrameFaces(frame(i), (near, far)) for i in range(12)])
    for item in got:
        np.testing.assert_allclose(item.faces[0].points_px, near.points_px, atol=1e-3)
        np.testing.assert_allclose(item.faces[1].points_px, far.points_px, atol=1e-3)


@pytest.mark.parametrize("stage", STAGES)
def test_a_face_that_is_not_finite_is_left_out(stage):
    broken = HEAD_PX[0].copy()
    broken[7, 0] = np.nan
    faces = [face(HEAD_PX[0])] * 6 + [face(broken)] + [face(HEAD_PX[0])] * 6
    got = run_stage(stage(), frames_of(faces))
    assert [len(item.faces) for item in got] == [1] * 6 + [0] + [1] * 6
    assert all_finite(got)


@pytest.mark.parametrize("stage", STAGES)
@pytest.mark.parametrize("to_px", [np.zeros((2, 3)), np.eye(2, 3) * 1e-9, np.eye(2, 3) * 1e6])
def test_a_degenerate_crop_gives_finite_points(stage, to_px):
    faces = [face(p, logits=SMALL, to_px=to_px) for p in HEAD_PX[:12]]
    assert all_finite(run_stage(stage(), frames_of(faces)))


# -- the lip patch


def placed(item, xy):
    """The logit of a smoothed face at a point of the picture, to the nearest pixel."""
    patch = item.faces[0].lips
    u, v = np.linalg.solve(patch.to_px[:, :2], np.asarray(xy) - patch.to_px[:, 2])
    return patch.logits[round(v), round(u)]


@pytest.mark.parametrize("stage", STAGES)
def test_the_patch_stays_on_the_lips_when_the_crop_wanders(stage):
    """The crop wanders by a tenth of its size and back; the mask stays on the moving lips."""
    items, places = [], []
    for index in range(40):
        points = HEAD_PX[0] + [2.5 * index, -index]
        centred = face(points)
        step = centred.lips.to_px[0, 0]
        shift = np.array([12 * np.sin(index / 6), 5 * np.cos(index / 4)])  # crop px
        to_px = centred.lips.to_px.copy()
        to_px[:, 2] += step * shift
        y, x = np.mgrid[0:80, 0:112].astype(np.float32)
        u, v = (x + shift[0] - 56) / 35, (y + shift[1] - 40) / 18
        items.append(face(points, logits=4 - 6 * (u * u + v * v), to_px=to_px))
        places.append(centred.lips.to_px @ [56, 40, 1])
    for item, place in zip(run_stage(stage(), frames_of(items)), places, strict=True):
        assert placed(item, place) == pytest.approx(4, abs=0.15)


# -- holding frames back


def test_a_file_is_held_back_by_four_frames_and_no_more():
    stage = SmoothAhead()
    items = frames_of([face(HEAD_PX[0], logits=SMALL)] * 20, Fraction(1, 60))
    out = [stage(item) for item in items]
    assert out[:4] == [None] * 4
    assert [item.frame.pts for item in out[4:]] == list(range(16))
    assert [item.frame.pts for item in stage.drain()] == [16, 17, 18, 19]
    assert list(stage.drain()) == []


def test_slow_videos_are_held_back_by_the_time_window_only():
    stage = SmoothAhead()
    out = [stage(item) for item in frames_of([None] * 6, Fraction(1, 10))]
    assert [item and item.frame.pts for item in out] == [None, None, 0, 1, 2, 3]


def test_live_holds_nothing_back():
    stage = SmoothLive()
    items = frames_of([face(HEAD_PX[0], logits=SMALL)] * 5)
    assert [stage(item).frame for item in items] == [item.frame for item in items]


def test_runs_as_a_stage():
    class Sink:
        def __init__(self):
            self.pts = []

        def __call__(self, item):
            self.pts.append(item.frame.pts)

        def finish(self, stopped):
            pass

    sink = Sink()
    faces = (item for item in frames_of([face(HEAD_PX[0], logits=SMALL)] * 9))
    Runner(("faces", faces), [("smooth", SmoothAhead())], ("sink", sink)).run()
    assert sink.pts == list(range(9))


def test_without_frames_ahead_no_frame_is_held_back(monkeypatch):
    monkeypatch.setattr(lookahead, "AHEAD_FRAMES", 0)
    items = frames_of([face(p) for p in HEAD_PX[:8]])
    got = run_stage(SmoothAhead(), items)
    np.testing.assert_allclose(xy_px(got), HEAD_PX[:8], atol=1e-3)


@pytest.mark.parametrize("stage", STAGES)
def test_a_patch_of_another_size_begins_a_track(stage):
    patches = [SMALL] * 6 + [lip_logits((10, 12))] * 6
    faces = [face(HEAD_PX[number], 0, one) for number, one in enumerate(patches)]
    found = [item.faces[0].lips.logits for item in run_stage(stage(), frames_of(faces))]
    assert [one.shape for one in found] == [one.shape for one in patches]
