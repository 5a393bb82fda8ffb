"""Flattened lids: each place on the lid keeps its place in the crop, however the face moves."""

import cv2
import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from makeup import close_up, true_face
from makeup_video.pipeline.faces.topology import EYE, RIGHT_EYE
from makeup_video.pipeline.reference.flat_lids import FLAT_WH, flat_lids

AS_IS = np.eye(2, 3)
LASH_ROW = 45
CREASE_ROW = 45 - 45 / 2.2  # rows are evenly spaced between 2.2 and the lash line
BROW_ROW = 45 - 45 * 2 / 2.2


def mapped(points, to_new):
    return (points @ to_new[:, :2].T + to_new[:, 2]).astype(np.float32)


def rows_of(points_px, places):
    """Return the rows and columns of the crop whose places lie nearest to the points."""
    flat = places.reshape(2, -1).T
    nearest = np.linalg.norm(points_px[:, None, :2] - flat[None], axis=2).argmin(1)
    return nearest // FLAT_WH[0], nearest % FLAT_WH[0]


def test_lash_line_crease_and_brow_come_to_their_rows():
    _, points = close_up()
    places = flat_lids(true_face(points), AS_IS)
    assert places.shape == (2, *FLAT_WH[::-1]) and places.dtype == np.float32
    for eye in (EYE, RIGHT_EYE):
        middle = np.asarray(eye)[[12, 28, 44]]  # above the pupil
        rows, _ = rows_of(points[middle], places)
        assert np.abs(rows - [LASH_ROW, CREASE_ROW, BROW_ROW]).max() <= 3


def test_outer_corners_lie_outside_inner_ones_inside():
    _, points = close_up()
    places = flat_lids(true_face(points), AS_IS)
    corners = np.array([EYE[0], EYE[8], RIGHT_EYE[8], RIGHT_EYE[0]])
    _, columns = rows_of(points[corners], places)
    assert (np.diff(columns) > 10).all()
    assert columns[1] < FLAT_WH[0] // 2 <= columns[2]


@settings(max_examples=50, deadline=None)
@given(st.floats(-3.1, 3.1), st.floats(0.3, 6), st.floats(-200, 200))
def test_a_moved_turned_or_larger_face_gives_the_same_crop(angle, scale, shift):
    _, points = close_up()
    c, s = scale * np.cos(angle), scale * np.sin(angle)
    to_new = np.array([[c, -s, shift], [s, c, -shift]])
    places = flat_lids(true_face(points), AS_IS)
    moved = flat_lids(true_face(mapped(points, to_new)), cv2.invertAffineTransform(to_new))
    assert np.abs(moved - places).max() < 0.1


def test_a_closing_lid_keeps_its_rows():
    _, points = close_up()
    half_shut = points.copy()
    lashes = np.asarray(EYE)[8:16]
    half_shut[lashes, 1] += 0.05 * np.ptp(points[:, 0])
    rows, _ = rows_of(half_shut[np.asarray(EYE)[[12]]], flat_lids(true_face(half_shut), AS_IS))
    assert abs(rows[0] - LASH_ROW) <= 3


def test_an_eye_too_narrow_to_see_is_the_mirror_of_the_other():
    _, points = close_up()
    one_eyed = points.copy()
    one_eyed[np.asarray(EYE)] = points[EYE[0]]
    places = flat_lids(true_face(one_eyed), AS_IS)
    assert (places == places[:, :, ::-1]).all()
    one_eyed[np.asarray(RIGHT_EYE)] = points[RIGHT_EYE[0]]
    assert flat_lids(true_face(one_eyed), AS_IS) is None
