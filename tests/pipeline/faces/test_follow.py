"""Crops follow a face, rest on a still one and agree in two runs; shortcuts equal the full fit."""

from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import assume, example, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from makeup_video.pipeline.faces.crop_layout import CropLayout, lip_patch_to_px
from makeup_video.pipeline.faces.face import LipPatch
from makeup_video.pipeline.faces.follow import (
    _is_odd,
    _read_parts,
    _steady,
    _steady_number,
    _step_between,
)
from makeup_video.pipeline.faces.landmarks import FaceLandmarks
from makeup_video.pipeline.faces.nets import FaceNets, Parts, load_nets
from makeup_video.pipeline.faces.similarity import Similarity
from makeup_video.pipeline.frames.affine import invert
from makeup_video.training.faces.similarity_fit import fit_similarity

CENTRES = hnp.arrays(np.float64, (5, 2), elements=st.floats(-4000, 4000))


@given(CENTRES, CENTRES)
def test_a_step_is_the_similarity_between_the_rims(before, now):
    assume(np.hypot(*(before[3] - before[4])) > 1)
    want = fit_similarity(before[3:], now[3:])
    step = _step_between(*([complex(*xy) for xy in centres] for centres in (before, now)))
    np.testing.assert_allclose(step.array(), want, rtol=1e-6, atol=1e-4)


def landmarks(moved: float, lips_at: complex = 0j, painted: int = 100) -> FaceLandmarks:
    logits = np.full((80, 112), -1.0, np.float32)
    logits.ravel()[:painted] = 1
    pose, centres = Similarity(100 + 0j, 0j), (lips_at, -30 - 40j, 30 - 40j)
    layout, five = CropLayout(pose, centres), [*centres, -30 - 40j, 30 - 40j]
    return FaceLandmarks(
        np.zeros(478, complex), np.zeros(478), (1.0, 1.0), pose, LipPatch(logits, np.eye(2, 3)),
        layout, five, five, 0.0, moved=moved,
    )  # fmt: skip


@pytest.mark.parametrize(
    ("before", "found", "odd"),
    [
        (landmarks(0.005), landmarks(0.01), False),
        (landmarks(0.005), landmarks(0.01, lips_at=6 + 0j), True),  # the lips jump
        (landmarks(0.005), landmarks(0.01, painted=45), True),  # the lips vanish
        (landmarks(0.005), landmarks(0.06), True),  # the video jerks
        (landmarks(0.04), landmarks(0.06), False),  # the head is moving
    ],
)
def test_odd_landmarks_are_read_again(before, found, odd):
    assert _is_odd(before, found) is odd


def numbers(layout: CropLayout) -> np.ndarray:
    return np.array([*layout.pose, *layout.centres]).view(float)


def moved_by(layout: CropLayout, off: np.ndarray) -> CropLayout:
    turn, shift, *centres = (numbers(layout) + off).view(complex).tolist()
    return CropLayout(Similarity(turn, shift), tuple(centres))


def follow(layout: CropLayout, path: list[CropLayout]) -> list[CropLayout]:
    """The layouts of a face whose crops are expected on a path."""
    return [layout := expected.rounded(layout) for expected in path]


TURNS = st.complex_numbers(min_magnitude=20, max_magnitude=900)
SHIFTS = st.complex_numbers(max_magnitude=3000)
OFFS = hnp.arrays(float, 10, elements=st.floats(-9, 9))


@given(TURNS, SHIFTS)
def test_crops_around_the_mean_face_have_its_pose(turn, shift):
    nets, pose = load_nets(), Similarity(turn, shift)
    mean = pose.apply(nets.mean_face[:, 0] + 1j * nets.mean_face[:, 1])
    layout = nets.layout_around(nets.part_centres(mean[nets.part_points]))
    np.testing.assert_allclose(numbers(layout), numbers(nets.crop_layout(mean)), atol=1e-6)


@given(hnp.arrays(float, 10, elements=st.floats(-50, 50)), st.integers(0, 2**32 - 1))
@example(np.where(np.arange(10) == 1, 28.5, -42.75), 0)  # IOD 64 px: two grids are equally near
def test_the_crops_of_a_still_face_come_to_rest(off, seed):
    noise = np.random.default_rng(seed).uniform(-0.07, 0.07, (60, 10))  # px, 0.07 % of the IOD
    still = moved_by(landmarks(0).layout, off)
    layouts = [numbers(one) for one in follow(still, [moved_by(still, one) for one in noise])]
    assert (np.diff(layouts, axis=0) != 0).sum(0).max() <= 1


@given(hnp.arrays(float, 10, elements=st.floats(-50, 50)), st.integers(0, 2**32 - 1))
def test_crops_around_steady_centres_hardly_move(off, seed):
    """Readings vary by half a step. Around single readings, crops would move up to 30 times.

    Even around steady centres, noise may move a crop now and then: in 249 of 12,000 draws a number
    of the layout moved more than once, and in none more than four times.
    """
    noise = np.random.default_rng(seed).uniform(-0.25, 0.25, (60, 10))  # px, 0.25 % of the IOD
    face, nets = landmarks(0), load_nets()
    still, layout, layouts = np.array(face.centres).view(float) + off / 10, face.layout, []
    face = replace(face, steady_centres=[*(still + noise[0]).view(complex)])
    for one in noise:
        face = replace(face, steady_centres=_steady(face, (still + one).view(complex)))
        layout = nets.layout_around(face.steady_centres).rounded(layout)
        layouts.append(numbers(layout))
    assert (np.diff(layouts, axis=0) != 0).sum(0).max() <= 5


@given(hnp.arrays(float, (30, 10), elements=st.floats(-9, 9)))
def test_steady_centres_lie_near_the_newest_reading(steps):
    """A reading a fiftieth of the IOD away counts whole: the lag is at most a quarter of that."""
    face = landmarks(0)
    for now in (np.array(face.centres).view(float) + steps.cumsum(0)).view(complex):
        face = replace(face, steady_centres=_steady(face, now.tolist()))
        assert np.abs(now - face.steady_centres).max() <= 0.5 + 1e-9  # px; the IOD is 100


@given(OFFS, st.floats(4, 40), st.booleans())
def test_two_runs_that_follow_one_face_come_together(apart, reach, down):
    start = landmarks(0).layout
    path = [moved_by(start, np.full(10, reach * i / 40 * (-1) ** down)) for i in range(40)]
    one, other = (follow(first, path)[-1] for first in (start, moved_by(start, apart)))
    assert one == other


@given(OFFS)
def test_crops_lie_within_a_step_of_where_they_are_expected(speed):
    start = landmarks(0).layout
    path = [moved_by(start, speed * np.sin(frame / 2)) for frame in range(40)]
    for expected, layout in zip(path, follow(start, path), strict=True):
        assert np.abs(numbers(layout) - numbers(expected)).max() <= 0.66  # px: the step is 1


def a_mouth(wide: float, high: float, pose: Similarity) -> np.ndarray:
    """Part points (186,) of the mean face, but with a mouth of that width and height in IOD."""
    nets = load_nets()
    xy = (nets.mean_face[:, 0] + 1j * nets.mean_face[:, 1])[nets.part_points]
    turns = np.linspace(0, 2 * np.pi, 80, endpoint=False)
    xy[:80] = xy[:80].mean() + (wide * np.cos(turns) + 1j * high * np.sin(turns)) / 2
    return pose.apply(xy)


@given(TURNS, SHIFTS, st.floats(0.2, 1.0), st.floats(0.05, 0.7))
def test_the_crop_of_the_lips_holds_every_mouth(turn, shift, wide, high):
    nets, pose = load_nets(), Similarity(turn, shift)
    part_xy = a_mouth(wide, high, pose)
    centres = nets.part_centres(part_xy)
    layout = CropLayout(pose, tuple(centres[:3]), nets.widening(part_xy, pose)).rounded()
    lips = part_xy[:80].view(float).reshape(80, 2)
    x, y = invert(lip_patch_to_px(layout)) @ np.column_stack([lips, np.ones(80)]).T
    assert x.min() > -0.5 and x.max() < 111.5
    assert y.min() > -0.5 and y.max() < 79.5


@given(TURNS, SHIFTS, st.floats(0.1, 1.0), st.floats(0.05, 0.7), st.integers(0, 4))
def test_lips_reach_the_border_where_their_crop_ends(turn, shift, wide, high, steps):
    nets, pose = load_nets(), Similarity(turn, shift)
    part_xy = a_mouth(wide, high, pose)
    layout = CropLayout(pose, tuple(nets.part_centres(part_xy)[:3]), steps)
    lips = part_xy[:80].view(float).reshape(80, 2)
    at = invert(lip_patch_to_px(layout)) @ np.column_stack([lips, np.ones(80)]).T
    shares = np.abs(at - [[55.5], [39.5]]) / [[56], [40]]
    assert nets.lips_reach(part_xy, layout) == pytest.approx(shares.max(), rel=1e-6)


@given(st.floats(0.5, 1.0), st.integers(0, 2**32 - 1))
def test_the_crop_of_still_lips_keeps_its_width(wide, seed):
    """The noise is a fiftieth of the mouth's width; a step of the crop's width is a tenth."""
    nets, pose, seen = load_nets(), Similarity(100 + 0j), []
    steady, layout = nets.widening(a_mouth(wide, 0.2, pose), pose), None
    for noise in np.random.default_rng(seed).uniform(-0.02, 0.02, 60):
        now = nets.widening(a_mouth(wide * (1 + noise), 0.2, pose), pose)
        steady = _steady_number(steady, now)
        layout = CropLayout(pose, (0j, 0j, 0j), steady).rounded(layout)
        seen.append(layout.widening)
    assert (np.diff(seen) != 0).sum() <= 1


@given(st.floats(0, 4), st.floats(0, 4))
def test_a_wider_mouth_gets_a_wider_crop_soon(before, now):
    for _ in range(5):
        before = _steady_number(before, now)
    assert abs(before - now) < 0.35  # of a step


@pytest.mark.parametrize(
    ("wide", "moved", "again"),
    [(0.7, 0j, 0), (0.7, 6j, 0), (0.7, 12j, 0), (0.7, 18j, 1), (0.7, 12 + 0j, 1), (1.0, 0j, 1)],
)
def test_lips_that_reach_the_border_are_read_again(wide, moved, again, monkeypatch):
    """moved: by how many px the lips moved since the last frame; the IOD is 100 px."""
    nets, pose, layouts = load_nets(), Similarity(100 + 0j), []
    xy = a_mouth(wide, 0.3, pose)
    lips, left, right, *_ = nets.part_centres(xy)

    def read(self, picture, layout):
        layouts.append(layout)
        return Parts(xy, LipPatch(np.zeros((80, 112)), np.eye(2, 3)), self.part_centres(xy))

    monkeypatch.setattr(FaceNets, "read_parts", read)
    layout, *_ = _read_parts(nets, None, CropLayout(pose, (lips - moved, left, right)))
    assert len(layouts) == 1 + again and layouts[-1] == layout
    assert abs(layout.centres[0] - lips) < (2 if again else 13)
    assert layout.lip_span > 1.12 * wide * 0.94
    _read_parts(nets, None, layout)
    assert len(layouts) == 2 + again


@pytest.mark.parametrize(("wide", "high"), [(0.7, 0.585), (0.7, 0.6), (0.7, 0.9), (1.35, 0.3)])
@given(st.floats(60, 130), st.floats(-1, 1), st.integers(0, 2**32 - 1))
@settings(max_examples=30, deadline=None)
def test_a_still_mouth_is_not_read_again_for_ever(wide, high, iod, shift, seed):
    """Nor does its crop jump, even if the mouth is as large as the crop or larger than any crop."""
    nets, rng, layouts = load_nets(), np.random.default_rng(seed), []
    pose = Similarity(iod + 0j, complex(shift, shift / 3))
    xy = a_mouth(wide, high, pose)

    def read(self, picture, layout):
        noise = rng.standard_normal(len(xy)) + 1j * rng.standard_normal(len(xy))
        noisy = xy + 0.0005 * iod * noise
        layouts.append(layout)
        return Parts(noisy, LipPatch(np.zeros((80, 112)), np.eye(2, 3)), self.part_centres(noisy))

    before, steady, width = None, nets.part_centres(xy), nets.widening(xy, pose)
    kept = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(FaceNets, "read_parts", read)
        for _ in range(30):
            expected = nets.layout_around(steady, width).rounded(before)
            before, parts, now = _read_parts(nets, None, expected)
            steady = [
                mean + 0.1 * (new - mean) for mean, new in zip(steady, parts.centres, strict=True)
            ]
            width = _steady_number(width, now)
            kept.append(before)
    assert len(layouts) <= 30 + 3
    assert sum(a != b for a, b in pairwise(kept)) <= 4
