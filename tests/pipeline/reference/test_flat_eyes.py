"""Tests of pipeline/reference/flat_eyes.py: hair and background beside the eyes are left out."""

from dataclasses import replace

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from makeup_video.pipeline.faces.topology import FACE_OVAL
from makeup_video.pipeline.reference.flat_eyes import FLAT_HW, different_eyes, eyes_of
from makeup_video.pipeline.reference.neutral_face import neutral_face
from makeup_video.pipeline.reference.photo_light import photo_light
from makeup_video.pipeline.render.surfaces.eyes_twin import lid_surfaces
from people import portrait
from reference_photos import face, flat_eyes

FIRST = 38  # column from which hair covers what lies beside an eye
BESIDE = np.s_[:, FIRST + 2 :]
BEFORE = np.s_[:, : FIRST - 3]  # columns that no blur carries hair to
SKINS = (230, 176, 150), (190, 140, 118)  # around the one eye and the other


def flat(rgb8, seen=None):
    seen = seen or face()
    return flat_eyes(neutral_face(rgb8, seen, photo_light(portrait(), face())))


def ending_at(column, eye):
    """The face with an outline that goes no further out than a column of one eye's grid."""
    points = face().points_px.copy()
    to_px = lid_surfaces(face())[eye].grid.to_px
    edge, inner = (to_px @ [at, 20, 1] for at in (column, 0))
    inwards = (inner - edge) / np.linalg.norm(inner - edge)
    beyond = np.maximum(-(points[FACE_OVAL, :2] - edge) @ inwards, 0)
    points[FACE_OVAL, :2] += beyond[:, None] * inwards
    return replace(face(), points_px=points)


def behind_hair(rgb, *eyes):
    """The portrait with even skin around both eyes, and a colour over what lies beside `eyes`."""
    rgb8 = portrait().copy()
    grids = [lid.grid.to_px for lid in lid_surfaces(face())]
    for to_px, skin in zip(grids, SKINS, strict=True):
        cover(rgb8, to_px, 14, skin)
    for eye in eyes:
        cover(rgb8, grids[eye], FIRST, rgb)
    return rgb8


def cover(rgb8, to_px, first, rgb):
    """Fill a grid outwards from its column `first`, and a little beyond its borders."""
    ends = FLAT_HW[1] + 8
    corners = np.array([[first, -8], [ends, -8], [ends, 44], [first, 44]])
    cv2.fillPoly(rgb8, [np.rint(corners @ to_px[:, :2].T + to_px[:, 2]).astype(np.int32)], rgb)


@settings(max_examples=8, deadline=None)
@given(st.sampled_from([0, 1]), st.tuples(*[st.integers(0, 40)] * 3))
def test_beside_hair_the_other_eye_counts_alone(eye, rgb):
    hidden, seen = flat(behind_hair(rgb, eye)), flat(behind_hair(rgb))
    each = [flat(behind_hair((0, 0, 0), 1 - one))[BESIDE] for one in (0, 1)]
    np.testing.assert_allclose(hidden[BESIDE], each[1 - eye], atol=0.01)
    np.testing.assert_allclose(seen[BESIDE], (each[0] + each[1]) / 2, atol=0.01)
    np.testing.assert_allclose(hidden[BEFORE], seen[BEFORE], atol=0.01)


def test_hair_beside_both_eyes_leaves_plain_skin():
    assert (flat(behind_hair((20, 12, 8), 0, 1))[BESIDE] == 1).all()


@settings(max_examples=8, deadline=None)
@given(st.sampled_from([0, 1]), st.tuples(*[st.integers(0, 255)] * 3))
def test_what_lies_beyond_a_turned_face_is_left_out(eye, rgb):
    turned = ending_at(FIRST - 1, eye)
    before, behind = flat(behind_hair(rgb), turned), flat(behind_hair(rgb, eye), turned)
    other = flat(behind_hair((0, 0, 0), eye), turned)
    np.testing.assert_allclose(behind[BESIDE], before[BESIDE], atol=0.01)
    np.testing.assert_allclose(behind[BESIDE], other[BESIDE], atol=0.01)
    np.testing.assert_allclose(behind[BEFORE], before[BEFORE], atol=0.01)


@pytest.mark.parametrize("rgb", [(120, 90, 80), (90, 70, 140)])
def test_eye_shadow_far_beyond_the_eyes_is_seen(rgb):
    worn, bare = flat(behind_hair(rgb, 0, 1))[BESIDE], flat(behind_hair(rgb))[BESIDE]
    assert (worn.mean((0, 1)) < 0.97 * bare.mean((0, 1))).any()
    assert worn[..., 0].max() < 0.9


def different(right, left):
    """The result of different_eyes for the portrait with eyes in two colours."""
    rgb8 = portrait().copy()
    for lid, skin in zip(lid_surfaces(face()), (right, left), strict=True):
        cover(rgb8, lid.grid.to_px, 14, skin)
    return different_eyes(eyes_of(neutral_face(rgb8, face(), photo_light(portrait(), face()))))


@settings(max_examples=10, deadline=None)
@given(st.sampled_from([(0, 120, 110), (110, 40, 150), (230, 120, 20)]), st.booleans())
def test_eyes_in_two_colours_are_read_each_by_itself(rgb, swapped):
    plain = SKINS[0]
    eyes = different(*((plain, rgb) if swapped else (rgb, plain)))
    worn, bare = (eyes[name][5:20, 20:36] for name in ("left", "right")[:: 1 if swapped else -1])
    assert np.abs(worn.mean((0, 1)) - bare.mean((0, 1))).max() > 0.1
    same = flat(behind_hair((0, 0, 0)))
    assert {each.shape for each in eyes.values()} == {same.shape}


@pytest.mark.parametrize("dim", [0.5, 0.8, 1.0])
def test_eyes_that_differ_in_light_alone_are_the_same(dim):
    shaded = [round(dim * code) for code in SKINS[0]]
    assert different(SKINS[0], shaded) == different((0, 120, 110), (0, 120, 110)) == {}
