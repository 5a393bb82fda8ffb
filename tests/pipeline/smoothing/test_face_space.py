from dataclasses import replace

import numpy as np
import pytest
from heads import HEAD_PX, face
from hypothesis import given, settings
from hypothesis import strategies as st
from makeup_video.pipeline.faces.face import POINTS, LipPatch
from makeup_video.pipeline.faces.topology import EYE, LIPS
from makeup_video.pipeline.smoothing.face_space import (
    PART_OF_COLUMN,
    PART_OF_POSE,
    PARTS,
    PLACE_PART,
    POSE_PART,
    RIGHT_EYE,
    STABLE,
    FaceSpace,
    Readings,
)
from makeup_video.training.faces.similarity_fit import fit_similarity

finite = st.floats(-1e3, 1e3)


def similarity(scale, turn, x, y):
    c, s = scale * np.cos(turn), scale * np.sin(turn)
    return np.array([[c, -s, x], [s, c, y]])


def moved(points, matrix):
    return points @ matrix[:, :2].T + matrix[:, 2]


@given(scale=st.floats(0.01, 100), turn=st.floats(-3.1, 3.1), x=finite, y=finite)
@settings(deadline=None)
def test_a_similarity_is_found_again(scale, turn, x, y):
    points = np.random.default_rng(0).normal(size=(9, 2))
    want = similarity(scale, turn, x, y)
    np.testing.assert_allclose(fit_similarity(points, moved(points, want)), want, atol=1e-8)


def test_no_other_similarity_fits_better():
    rng = np.random.default_rng(1)
    a, b = rng.normal(size=(2, 12, 2))
    best = fit_similarity(a, b)
    error = ((moved(a, best) - b) ** 2).sum()
    for _ in range(50):
        c, s, x, y = rng.normal(0, 0.05, 4)
        other = best + np.array([[c, -s, x], [s, c, y]])
        assert ((moved(a, other) - b) ** 2).sum() > error


def test_many_fits_at_once_are_the_fits_one_by_one():
    rng = np.random.default_rng(2)
    a, b = rng.normal(size=(7, 2)), rng.normal(size=(3, 4, 7, 2))
    many = fit_similarity(np.broadcast_to(a, b.shape), b)
    assert many.shape == (3, 4, 2, 3)
    np.testing.assert_allclose(many[2, 1], fit_similarity(a, b[2, 1]))


def test_fitting_one_point_is_a_shift():
    same = np.full((5, 2), 3.0)
    np.testing.assert_allclose(
        fit_similarity(same, same + np.array([2, -1])), [[1, 0, 2], [0, 1, -1]]
    )


def test_float32_far_from_the_origin_is_fitted_precisely():
    points = HEAD_PX[0].astype(np.float32) + np.float32(3000)
    np.testing.assert_allclose(fit_similarity(points, points), np.eye(2, 3), atol=1e-9)


def test_parts_name_points_once_and_eyes_mirror_each_other():
    named = np.concatenate([LIPS, EYE, RIGHT_EYE])
    assert len(set(named)) == len(named) and named.min() >= 0 and named.max() < POINTS
    assert len(set(STABLE)) == len(STABLE) and not np.isin(STABLE, LIPS).any()
    assert len(PART_OF_COLUMN) == 3 * POINTS and set(PART_OF_COLUMN) == set(range(4))
    assert len(PARTS) == 7 and set(PART_OF_POSE) == {POSE_PART, PLACE_PART}
    straight = HEAD_PX[:12].mean(0)
    mirrored = fit_similarity(straight[EYE] * [-1, 1], straight[RIGHT_EYE])
    off = moved(straight[EYE] * [-1, 1], mirrored) - straight[RIGHT_EYE]
    assert np.abs(off).max() < 4  # px, with 190 px between the eyes: faces are slightly asymmetric


@pytest.mark.parametrize("size", [0.05, 1, 8])
def test_what_is_split_is_joined_again(size):
    rng = np.random.default_rng(3)
    faces = [face(HEAD_PX[i] * size, logits=rng.normal(0, 3, (80, 112))) for i in (0, 90, 195)]
    space = FaceSpace(faces[0])
    readings = Readings(space, 3)
    for index, original in enumerate(faces):
        space.split(original, readings, index, index / 30)
    for index, original in enumerate(faces):
        points, patch = space.join(
            readings.values[index], readings.pose[index], readings.patches[index]
        )
        np.testing.assert_allclose(points, original.points_px, atol=1e-3 * max(size, 1))
        assert patch.logits.shape == (80, 112)


def test_moments_differ_by_the_mean_square_of_their_keys():
    space = FaceSpace(face(HEAD_PX[0]))
    readings = Readings(space, 3)
    for moment, frame_index in enumerate((0, 90, 195, 20)):  # the last replaces the first
        space.split(face(HEAD_PX[frame_index]), readings, moment % 3, moment / 30)
    off = readings.keys[:, None] - readings.keys
    # shifts are in units of the size at the later moment; 0 is the last one
    order = [2, 0, 1]  # of the moments 0, 1 and 2
    later = np.where(np.greater.outer(order, order), *np.ix_(range(3), range(3)))
    for part in (POSE_PART, PLACE_PART):
        column = space.key_starts[part]
        off[..., column : column + 2] *= np.exp(-readings.pose[later, 2])[..., None]
    want = np.add.reduceat(off * off, space.key_starts, 2) / space.key_counts
    np.testing.assert_allclose(readings.apart, np.moveaxis(want, 2, 0), atol=1e-12)


def test_a_face_moved_as_a_whole_keeps_its_shape():
    space = FaceSpace(face(HEAD_PX[0]))
    readings = Readings(space, 2)
    space.split(face(HEAD_PX[0]), readings, 0, 0.0)
    where = similarity(1.7, 0.6, 300, -40)
    moved_face = face(moved(HEAD_PX[0], where))
    moved_face.points_px[:, 2] = 1.7 * face(HEAD_PX[0]).points_px[:, 2]
    space.split(moved_face, readings, 1, 0.0)
    np.testing.assert_allclose(readings.values[1], readings.values[0], atol=2e-5)
    log_scale, turn = readings.pose[1, 2:4] - readings.pose[0, 2:4]
    assert log_scale == pytest.approx(np.log(1.7), abs=1e-5)
    assert turn == pytest.approx(0.6, abs=1e-5)


def test_a_turning_face_does_not_jump_at_180_degrees():
    space = FaceSpace(face(HEAD_PX[0]))
    readings = Readings(space, 40)
    for index in range(40):
        turned = face(moved(HEAD_PX[0], similarity(1, 0.3 * index, 0, 0)))
        space.split(turned, readings, index, index / 30)
    np.testing.assert_allclose(np.diff(readings.pose[:, 3]), 0.3, atol=1e-5)


def test_a_crop_that_moves_far_takes_the_old_patches_along():
    x = np.mgrid[0:80, 0:112][1].astype(np.float32)
    first = face(HEAD_PX[0], logits=x - 40)
    to_px = first.lips.to_px.copy()
    to_px[:, 2] += 20 * to_px[:, 0]  # the crop moves right by 20 of its own pixels
    space = FaceSpace(first)
    readings = Readings(space, 2)
    space.split(first, readings, 0, 0.0)
    space.split(face(HEAD_PX[0], logits=x - 20, to_px=to_px), readings, 1, 0.0)
    np.testing.assert_allclose(readings.patches[0][:, :90], readings.patches[1][:, :90], atol=1e-3)
    _, patch = space.join(readings.values[1], readings.pose[1], readings.patches[1])
    np.testing.assert_allclose(patch.to_px, to_px, atol=1e-3)


def test_readings_do_not_depend_on_where_a_track_begins():
    """From the next slot of time on, crop and shape do not depend on the first face."""
    rng = np.random.default_rng(5)
    points = HEAD_PX[:40] + rng.normal(0, 0.4, (40, *HEAD_PX.shape[1:]))
    faces = [face(one, logits=rng.normal(0, 3, (80, 112))) for one in points]
    patches, values = [], []
    for first in (0, 13):
        space = FaceSpace(faces[first])
        readings = Readings(space, 1)
        for index in range(first, 20):
            space.split(faces[index], readings, 0, index / 30)
        patches.append(readings.patches.copy())
        values.append(readings.values.copy())
    np.testing.assert_allclose(patches[1], patches[0], atol=1e-3)
    np.testing.assert_allclose(values[1], values[0], atol=1e-5)


def test_a_mouth_that_closes_keeps_lips_that_were_wide_open():
    """Moments before the present one are painted from crops that may have been wider."""
    narrow = face(HEAD_PX[0])
    step = narrow.lips.to_px[0, 0]
    h, w = narrow.lips.logits.shape
    logits = np.full((h, w), -5, np.float32)
    logits[2:-2, 2:-2] = 5  # lips nearly up to the border of the wider crop
    shift = narrow.lips.to_px[:, 2] - 0.15 * step * np.array([w - 1, h - 1])
    to_px = np.column_stack([1.3 * narrow.lips.to_px[:, :2], shift])
    wide = replace(narrow, lips=LipPatch(logits, to_px, 1.3 * narrow.lips.span))
    space = FaceSpace(wide)
    readings = Readings(space, 5)
    for index, one in enumerate([wide, wide, narrow, narrow]):
        space.split(one, readings, index, 0.04 * index)
    _, patch = space.join(readings.values[1], readings.pose[1], readings.patches[1])
    assert patch.span == wide.lips.span
    painted = [(p.logits > 0).sum() * np.linalg.det(p.to_px[:, :2]) for p in (patch, wide.lips)]
    assert painted[0] == pytest.approx(painted[1], rel=0.01)
    for index in range(5):  # until no wide crop is held any more
        space.split(narrow, readings, index, 0.6 + 0.04 * index)
    space.split(narrow, readings, 0, 1.2)
    _, patch = space.join(readings.values[0], readings.pose[0], readings.patches[0])
    assert patch.span == narrow.lips.span
    np.testing.assert_allclose(patch.to_px, narrow.lips.to_px, atol=1e-6)
