"""Faces are found in one picture, and unusual pictures do no harm."""

from fractions import Fraction
from functools import cache

import cv2
import numpy as np
import pytest
from face_checks import assert_sound, error_percent, inter_ocular, middle, run, wall
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from makeup_video.pipeline import FindFaces, find_faces, lip_mask
from makeup_video.pipeline.faces.find import find_faces_in_frame, find_in
from makeup_video.pipeline.faces.lip_mask import lip_mask_part
from makeup_video.pipeline.faces.nets import load_nets
from makeup_video.pipeline.faces.topology import EYE_CONTOUR, LIPS
from makeup_video.pipeline.frames.views import FramePicture
from people import clip, clip_points, face_of, frame_of, grey, portrait, put


def test_a_portrait_has_one_face_whose_mouth_is_visible():
    (face,) = find_faces(portrait())
    assert face.score > 0.9
    assert face.mouth_visible > 0.9
    assert face.track_id == 0
    assert inter_ocular(face.points_px) == pytest.approx(122, rel=0.1)


@pytest.mark.parametrize("index", [0, 25])
def test_points_lie_where_they_truly_are(index):
    (face,) = find_faces(clip()[index])
    true = clip_points()[index]
    assert error_percent(face, true) < 4.5  # MediaPipe, which defines the order of points: 2.7
    assert error_percent(face, true, LIPS) < 5
    assert error_percent(face, true, EYE_CONTOUR) < 3


def test_several_faces_come_largest_first():
    picture = put(put(grey(), face_of(60), 40, 150), face_of(130), 330, 50)
    large, small = find_faces(picture)
    assert np.ptp(large.points_px[:, 0]) > np.ptp(small.points_px[:, 0])
    assert {large.track_id, small.track_id} == {0, 1}
    assert middle(large)[0] > 330 > middle(small)[0]


def test_twenty_faces_are_all_found():
    picture = grey(1280, 720)
    for number in range(20):
        picture = put(picture, face_of(70), 30 + number % 7 * 175, 20 + number // 7 * 230)
    faces = find_faces(picture)
    assert len(faces) == 20
    assert_sound(faces, (1280, 720))


def test_a_face_under_forty_pixels_is_skipped_and_counted():
    picture = put(grey(), face_of(28), 300, 150)
    assert find_faces(picture) == ()
    assert find_faces_in_frame(frame_of(picture))[1] == 1
    finder = FindFaces()
    assert all(item.faces == () for item in run([picture] * 8, finder))
    assert finder.tiny_faces > 0
    assert finder.frames_with_face == 0


@pytest.mark.parametrize(("width", "beside"), [(60, 0.5), (90, 0.6)])
def test_a_face_that_is_too_small_hides_no_larger_one(width, beside):
    dark = face_of(width) // 4  # the detector is surer of the tiny face
    tiny = face_of(30)[6:-6, 10:-10]
    middle_x, middle_y = 200 + dark.shape[1] / 2, 60 + dark.shape[0] / 2
    x = int(middle_x + beside * width - tiny.shape[1] / 2)
    picture = put(put(grey(), dark, 200, 60), tiny, x, int(middle_y - tiny.shape[0] / 2))
    assert len(find_faces(picture)) == 1
    finder = FindFaces()
    assert len(finder(frame_of(picture)).faces) == 1 == finder.tiny_faces


def test_a_wrong_guess_does_not_hide_the_face_behind_it():
    # at the coarsest size the detector mistakes the uniform for a face
    assert len(find_faces(put(wall(), face_of(150), 200, 20))) == 1


@pytest.mark.parametrize("degrees", [-45, -25, 25, 45])
def test_a_tilted_head_is_found(degrees):
    turn = cv2.getRotationMatrix2D((220, 190), degrees, 1)
    tilted = cv2.warpAffine(portrait()[60:500, 40:480], turn, (440, 440), borderValue=(90, 90, 90))
    (face,) = find_faces(tilted)
    across = face.points_px[263, :2] - face.points_px[33, :2]
    assert np.degrees(np.arctan2(-across[1], across[0])) == pytest.approx(degrees, abs=6)
    items = run([put(grey(), tilted[:360], 100, 0)] * 30)
    assert items[-1].faces


@pytest.mark.parametrize("x", [-110, 430])
def test_a_face_cut_by_the_border_is_found(x):
    (face,) = find_faces(put(wall(), face_of(150), x, 20))  # a third of the face lies outside
    middle_x = middle(face)[0]
    assert middle_x < 70 or middle_x > 560


@pytest.mark.parametrize("x", [-155, 480])
def test_half_a_face_at_the_border_is_sound_or_not_found(x):
    picture = put(grey(), face_of(150), x, 40)
    faces = find_faces(picture)
    assert_sound(faces, (640, 360))
    for face in faces:
        assert np.isfinite(lip_mask(picture, face)).all()


@pytest.mark.parametrize("quarters", [1, 2, 3])
def test_a_face_on_its_side_or_upside_down_is_found(quarters):
    picture = portrait()[60:500, 40:480]
    (upright,) = find_faces(picture)
    (face,) = find_faces(np.ascontiguousarray(np.rot90(picture, quarters)))
    x, y = upright.points_px[:, :2].T
    want = {1: (y, 439 - x), 2: (439 - x, 439 - y), 3: (439 - y, x)}[quarters]
    off = np.linalg.norm(face.points_px[:, :2] - np.column_stack(want), axis=1).mean()
    assert off < 0.03 * inter_ocular(upright.points_px)


def test_a_face_of_sixty_pixels_is_found_in_4k():
    ground = cv2.resize(wall(), (3840, 2160))
    (face,) = find_faces(put(ground, face_of(60), 2900, 300))
    assert 50 < np.ptp(face.points_px[:, 0]) < 75
    assert 2900 < middle(face)[0] < 3030


def test_a_rotated_frame_is_found_in_stored_pixels():
    picture = portrait()[60:500, 40:480]
    (face,) = find_faces_in_frame(frame_of(picture, rotation_degrees=180))[0].faces
    (upright,) = find_faces(picture)
    mirrored = 439 - face.points_px[:, :2]  # both axes of the stored picture run backwards
    off = np.linalg.norm(mirrored - upright.points_px[:, :2], axis=1).mean()
    assert off < 0.02 * inter_ocular(upright.points_px)


@pytest.mark.parametrize("pix_fmt", ["yuv420p", "yuv422p", "yuv444p", "nv12", "yuv420p10le"])
def test_every_layout_gives_the_same_points(pix_fmt):
    want = find_faces(portrait())[0].points_px
    got = find_faces_in_frame(frame_of(portrait(), pix_fmt=pix_fmt))[0].faces[0].points_px
    off = np.linalg.norm((got - want)[:, :2], axis=1)
    assert off.mean() < 0.01 * inter_ocular(want)


def test_wide_pixels_do_not_bend_the_face():
    squeezed = np.ascontiguousarray(portrait()[:, ::2])
    picture = FramePicture(frame_of(squeezed, pix_fmt="yuv444p"), Fraction(2))
    ((face,), _) = find_in(picture, load_nets())
    want = find_faces(portrait())[0].points_px[:, :2]
    off = np.linalg.norm(face.points_px[:, :2] * [2, 1] + [0.5, 0] - want, axis=1)
    assert off.mean() < 0.015 * inter_ocular(want)


@pytest.mark.parametrize("shade", [0, 255])
@pytest.mark.parametrize("size", [(1, 1), (1, 900), (3, 2), (64, 64), (720, 1280)])
def test_black_and_white_and_single_pixels_hold_no_face(shade, size):
    assert find_faces(np.full((*size, 3), shade, np.uint8)) == ()
    frames = run([np.full((*size, 3), shade, np.uint8)] * 3, pix_fmt="yuv444p")
    assert [item.faces for item in frames] == [()] * 3


def test_an_8k_picture_is_read_like_any_other():
    picture = put(grey(7680, 4320), np.repeat(np.repeat(portrait(), 5, 0), 5, 1), 3000, 600)
    (face,) = find_faces(picture)
    assert middle(face)[0] == pytest.approx(
        3000 + 5 * middle(find_faces(portrait())[0])[0], rel=0.01
    )
    window = lip_mask_part(face, (4000, 2500), (800, 600))
    assert window.shape == (600, 800)


@settings(max_examples=25, deadline=None, suppress_health_check=[HealthCheck.data_too_large])
@given(
    hnp.arrays(
        np.uint8,
        st.tuples(st.integers(1, 90), st.integers(1, 90), st.just(3)),
        elements=st.integers(0, 255),
        fill=st.integers(0, 255),
    )
)
def test_any_picture_gives_sound_faces_and_masks(picture):
    assert_sound(find_faces(picture), picture.shape[1::-1])
    assert_mask(picture, face_of_portrait())  # noise has no face of its own


@settings(max_examples=25, deadline=None)
@given(st.integers(0, 9), st.integers(1, 120), st.integers(150, 300), st.integers(150, 350))
def test_noise_over_a_face_gives_sound_faces_and_masks(seed, size, x, y):
    noise = np.random.default_rng(seed).integers(0, 256, (size, size, 3), np.uint8)
    picture = put(portrait(), noise, x, y)
    faces = find_faces(picture)
    assert faces or size > 40
    assert_sound(faces, picture.shape[1::-1])
    for face in faces:
        assert_mask(picture, face)


@cache
def face_of_portrait():
    (face,) = find_faces(portrait())
    return face


def assert_mask(picture, face):
    mask = lip_mask(picture, face)
    assert mask.shape == picture.shape[:2]
    assert (mask >= 0).all() and (mask <= 1).all()


@pytest.mark.parametrize(
    "bad", [np.zeros((9, 9)), np.zeros((9, 9, 3)), np.zeros((9, 9, 4), np.uint8)]
)
def test_anything_but_a_picture_is_refused(bad):
    with pytest.raises(ValueError, match="8-bit RGB"):
        find_faces(bad)


@pytest.mark.parametrize("rotation", [0, 90, 180, 270])
def test_equal_faces_are_numbered_from_left_to_right_upright(rotation):
    picture = put(put(grey(), face_of(90), 60, 120), face_of(90), 420, 120)
    faces = find_faces_in_frame(frame_of(picture, rotation_degrees=rotation))[0].faces
    x, y = np.array([middle(face) for face in faces]).T
    along = {0: x, 90: y, 180: -x, 270: -y}[rotation]
    assert len(faces) == 2 and along[0] < along[1]
