"""Faces are found, kept apart, followed, lost and found again; and odd pictures do no harm."""

from dataclasses import replace
from fractions import Fraction

import cv2
import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp
from makeup_video.pipeline import Face, FindFaces, find_faces, lip_mask
from makeup_video.pipeline.faces.find import find_faces_in_frame
from makeup_video.pipeline.faces.lip_mask import lip_mask_part
from makeup_video.pipeline.faces.topology import (
    EYE_CONTOUR,
    EYE_CORNERS,
    LIPS,
    LIPS_INNER,
    LIPS_OUTER,
)
from people import TICK, clip, clip_points, face_of, frame_of, grey, portrait, put


def inter_ocular(points: np.ndarray) -> float:
    a, b = points[list(EYE_CORNERS), :2]
    return float(np.linalg.norm(a - b))


def error_percent(face: Face, true: np.ndarray, index=slice(None)) -> float:
    off = np.linalg.norm(face.points_px[index, :2] - true[index], axis=1)
    return 100 * float(off.mean()) / inter_ocular(true)


def run(pictures, finder: FindFaces | None = None, *, first_pts=0, **how):
    """The faces of each picture, followed as a film."""
    finder = finder or FindFaces()
    return [finder(frame_of(p, first_pts + at, **how)) for at, p in enumerate(pictures)]


def middle(face: Face) -> np.ndarray:
    return face.points_px[:, :2].mean(0)


def wall() -> np.ndarray:
    y, x = np.mgrid[0:360, 0:640]
    return np.dstack([(90 + 80 * np.sin(x / 25) * np.cos(y / 30)).astype(np.uint8)] * 3)


def assert_sound(faces, size_wh):
    for face in faces:
        assert np.isfinite(face.points_px).all()
        assert face.points_px.dtype == np.float32
        assert 0 <= face.score <= 1
        assert 0 <= face.mouth_visible <= 1
        assert np.ptp(face.points_px[:, 0]) > 10
        middle_x, middle_y = middle(face)
        assert -200 < middle_x < size_wh[0] + 200
        assert -200 < middle_y < size_wh[1] + 200


# --- one picture


def test_a_portrait_has_one_face_whose_mouth_is_visible():
    (face,) = find_faces(portrait())
    assert face.score > 0.9
    assert face.mouth_visible > 0.9
    assert face.track_id == 0
    assert inter_ocular(face.points_px) == pytest.approx(122, rel=0.1)


@pytest.mark.parametrize("at", [0, 25])
def test_points_lie_where_they_truly_are(at):
    (face,) = find_faces(clip()[at])
    true = clip_points()[at]
    assert error_percent(face, true) < 4.5  # MediaPipe, which made the truth's order: 2.7
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
    for at in range(20):
        picture = put(picture, face_of(70), 30 + at % 7 * 175, 20 + at // 7 * 230)
    faces = find_faces(picture)
    assert len(faces) == 20
    assert_sound(faces, (1280, 720))


def test_a_face_under_forty_pixels_is_left_alone_and_counted():
    picture = put(grey(), face_of(28), 300, 150)
    assert find_faces(picture) == ()
    finder = FindFaces()
    assert all(item.faces == () for item in run([picture] * 8, finder))
    assert finder.tiny_faces > 0
    assert finder.frames_with_face == 0


def test_a_wrong_guess_does_not_hide_the_face_behind_it():
    # at the coarsest size the detector takes the uniform for a face
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


def test_no_more_than_thirty_two_faces_are_followed():
    crowd = grey(1280, 720)
    for at in range(45):
        crowd = put(crowd, face_of(56), 10 + at % 9 * 140, 5 + at // 9 * 140)
    assert 20 < len(find_faces(crowd)) <= 32
    assert 20 < len(run([crowd] * 2)[-1].faces) <= 32


@pytest.mark.parametrize("x", [-110, 430])
def test_a_face_cut_by_the_border_is_found(x):
    (face,) = find_faces(put(wall(), face_of(150), x, 20))  # a third of it lies outside
    middle_x = middle(face)[0]
    assert middle_x < 70 or middle_x > 560


@pytest.mark.parametrize("x", [-155, 480])
def test_half_a_face_at_the_border_does_no_harm(x):
    picture = put(grey(), face_of(150), x, 40)
    faces = find_faces(picture)
    assert_sound(faces, (640, 360))
    for face in faces:
        assert np.isfinite(lip_mask(picture, face)).all()


def test_an_upside_down_face_is_found_only_through_the_rotation():
    picture = portrait()[60:500, 40:480]
    turned = np.ascontiguousarray(np.rot90(picture, 2))
    assert_sound(find_faces(turned), (440, 440))
    (face,) = find_faces_in_frame(frame_of(picture, rotation_degrees=180))[0].faces
    (upright,) = find_faces(picture)
    there = 439 - face.points_px[:, :2]  # both axes of the stored picture run backwards
    off = np.linalg.norm(there - upright.points_px[:, :2], axis=1).mean()
    assert off < 0.02 * inter_ocular(upright.points_px)


@pytest.mark.parametrize("rotation", [90, 180, 270])
def test_a_rotated_film_is_followed_in_stored_pixels(rotation):
    plain = run(clip()[:6])
    turned = run(clip()[:6], rotation_degrees=rotation)
    for a, b in zip(plain, turned, strict=True):
        lips = b.faces[0].points_px[LIPS, :2].mean(0)
        x, y = a.faces[0].points_px[LIPS, :2].mean(0)
        want = {90: (359 - y, x), 180: (639 - x, 359 - y), 270: (y, 639 - x)}[rotation]
        assert lips == pytest.approx(want, abs=1.5)


@pytest.mark.parametrize("pix_fmt", ["yuv420p", "yuv422p", "yuv444p", "nv12", "yuv420p10le"])
def test_every_layout_gives_the_same_points(pix_fmt):
    want = find_faces(portrait())[0].points_px
    got = find_faces_in_frame(frame_of(portrait(), pix_fmt=pix_fmt))[0].faces[0].points_px
    off = np.linalg.norm((got - want)[:, :2], axis=1)
    assert off.mean() < 0.01 * inter_ocular(want)


def test_wide_pixels_do_not_bend_the_face():
    squeezed = np.ascontiguousarray(portrait()[:, ::2])
    (face,) = find_faces_in_frame(frame_of(squeezed, pix_fmt="yuv444p"), Fraction(2))[0].faces
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
def test_no_picture_does_any_harm(picture):
    faces = find_faces(picture)
    assert_sound(faces, picture.shape[1::-1])
    for face in faces:
        mask = lip_mask(picture, face)
        assert mask.shape == picture.shape[:2]
        assert np.isfinite(mask).all()


@pytest.mark.parametrize(
    "bad", [np.zeros((9, 9)), np.zeros((9, 9, 3)), np.zeros((9, 9, 4), np.uint8)]
)
def test_what_is_no_picture_is_refused(bad):
    with pytest.raises(ValueError, match="8-bit RGB"):
        find_faces(bad)


# --- the lip mask


def polygon(points: np.ndarray, contour: np.ndarray, shape: tuple[int, int]) -> np.ndarray:
    inside = np.zeros(shape, np.uint8)
    cv2.fillPoly(inside, [np.rint(points[contour] * 16).astype(np.int32)], 1, shift=4)
    return inside.astype(bool)


def open_mouth() -> int:
    points = clip_points(300)
    gap = np.linalg.norm(points[:, 13] - points[:, 14], axis=1)
    return int(gap[:40].argmax())


@pytest.mark.parametrize("at", [0, open_mouth()])
def test_the_mask_covers_the_lips_and_little_else(at):
    picture, true = clip()[at], clip_points()[at]
    mask = lip_mask(picture, find_faces(picture)[0])
    assert mask.shape == picture.shape[:2]
    assert mask.dtype == np.float32
    assert mask.min() >= 0
    assert mask.max() <= 1
    lips = polygon(true, LIPS_OUTER, mask.shape) & ~polygon(true, LIPS_INNER, mask.shape)
    painted = mask > 0.5
    assert (painted & lips).sum() / (painted | lips).sum() > 0.6
    away = np.abs(np.mgrid[0:360, 0:640] - true[LIPS].mean(0)[::-1, None, None]).max(0) > 70
    assert mask[away].max() == 0


def test_a_part_of_the_mask_is_that_part_of_the_whole():
    (face,) = find_faces(portrait())
    whole = lip_mask(portrait(), face)
    x, y = face.points_px[LIPS, :2].mean(0).astype(int) - 40
    part = lip_mask_part(face, (int(x), int(y)), (90, 70))
    assert part == pytest.approx(whole[y : y + 70, x : x + 90], abs=2e-3)


def test_a_hidden_mouth_has_no_mask_and_a_half_hidden_one_a_weaker():
    (face,) = find_faces(portrait())
    full = lip_mask(portrait(), face)
    assert lip_mask(portrait(), replace(face, mouth_visible=0.1)).max() == 0
    half = lip_mask(portrait(), replace(face, mouth_visible=0.35))
    assert half.max() == pytest.approx(full.max() / 2, rel=0.01)


def test_a_mouth_behind_a_medical_mask_is_told_to_be_hidden():
    picture = portrait().copy()
    (face,) = find_faces(picture)
    nose, chin = face.points_px[1, :2], face.points_px[152, :2]
    left, right = face.points_px[234, :2], face.points_px[454, :2]
    cloth = np.array([[left[0] + 8, nose[1]], nose - [0, 12], [right[0] - 8, nose[1]],
                      [right[0] - 25, chin[1]], np.add(chin, (0, 8)), [left[0] + 25, chin[1]]])  # fmt: skip
    cv2.fillPoly(picture, [np.rint(cloth).astype(np.int32)], (150, 190, 215))
    for face in find_faces(picture):
        assert face.mouth_visible < 0.5


def test_lips_outside_the_picture_have_no_mask():
    (face,) = find_faces(portrait())
    assert lip_mask(portrait()[:120], face).max() == 0


# --- a film


def test_a_talking_head_keeps_its_number_and_its_points():
    items = run(clip())
    assert all(len(item.faces) == 1 for item in items)
    assert {item.faces[0].track_id for item in items} == {0}
    errors = [
        error_percent(item.faces[0], true) for item, true in zip(items, clip_points(), strict=True)
    ]
    assert max(errors) < 6


def test_frames_come_back_with_their_own_face_and_unchanged():
    finder = FindFaces()
    for at in range(4):
        frame = frame_of(clip()[at], at)
        before = [plane.copy() for plane in frame.planes]
        item = finder(frame)
        assert item.frame is frame
        assert all((a == b).all() for a, b in zip(before, frame.planes, strict=True))


def test_two_faces_that_move_keep_their_numbers():
    def scene(at: int) -> np.ndarray:
        return put(put(grey(), face_of(90), 20 + 3 * at, 60), face_of(90), 420 - 3 * at, 120)

    items = run([scene(at) for at in range(30)])
    assert all(len(item.faces) == 2 for item in items)
    for item in items:
        by_id = {face.track_id: middle(face)[0] for face in item.faces}
        assert set(by_id) == {0, 1}
    first = {face.track_id: middle(face)[0] for face in items[0].faces}
    last = {face.track_id: middle(face)[0] for face in items[-1].faces}
    for number in (0, 1):
        towards = 1 if first[number] < 320 else -1
        assert last[number] - first[number] == pytest.approx(towards * 87, abs=6)


@pytest.mark.parametrize("rate", [12, 30, 60])
def test_a_new_face_is_picked_up_within_half_a_second(rate):
    alone = put(grey(), face_of(110), 20, 60)
    both = put(alone, face_of(80), 400, 100)
    finder = FindFaces()
    run([alone] * rate, finder, time_base=Fraction(1, rate))
    after = run([both] * rate, finder, first_pts=rate, time_base=Fraction(1, rate))
    first = next(at for at, item in enumerate(after) if len(item.faces) == 2)
    assert first / rate <= 0.5


def test_a_face_that_leaves_is_lost_and_returns_under_its_number():
    away = wall()
    here = put(away, face_of(120), 200, 50)
    items = run([here] * 5 + [away] * 15 + [here] * 15)
    assert all(len(item.faces) == 1 for item in items[:5])
    assert all(item.faces == () for item in items[8:20])  # within a tenth of a second
    assert len(items[-1].faces) == 1
    assert items[-1].faces[0].track_id == items[0].faces[0].track_id
    back = next(at for at, item in enumerate(items[20:]) if item.faces)
    assert back * TICK <= Fraction(1, 2)


def test_a_face_that_walks_out_is_not_painted_on_the_border_for_ever():
    scenes = [put(grey(), face_of(120), 330 + 14 * at, 60) for at in range(45)]
    items = run(scenes)
    assert items[0].faces
    assert items[-1].faces == ()
    assert_sound([face for item in items for face in item.faces], (640, 360))


def test_after_a_cut_faces_are_found_at_once_under_new_numbers():
    other = put(wall(), face_of(120), 380, 60)
    items = run([*clip()[:5], *[other] * 3])
    assert [item.cut for item in items] == [False] * 5 + [True] + [False] * 2
    assert items[5].faces[0].track_id != items[4].faces[0].track_id
    assert middle(items[5].faces[0])[0] > 380


def test_a_clock_that_jumps_back_or_stands_still_does_not_blind():
    finder = FindFaces()
    face = put(wall(), face_of(120), 200, 50)
    run([wall()] * 3, finder, first_pts=3000)
    seen = [finder(frame_of(face, pts)) for pts in (0, 0, 0, 0, 1, 2, 3, 4, 5, 6, 7, 8)]
    assert not any(item.cut for item in seen)
    assert seen[-1].faces


def test_two_who_cross_keep_their_numbers():
    def scene(at: int) -> np.ndarray:
        behind = put(wall(), face_of(90), 20 + 10 * at, 60)
        return put(behind, face_of(110), 420 - 10 * at, 90)

    items = run([scene(at) for at in range(42)])
    first = {face.track_id: middle(face)[0] for face in items[0].faces}
    last = {face.track_id: middle(face)[0] for face in items[-1].faces}
    assert set(first) == set(last) == {0, 1}


def test_who_is_hidden_for_a_moment_keeps_the_number():
    still = put(wall(), face_of(90), 330, 60)
    items = run([put(still, face_of(120), 40 + 14 * at, 70) for at in range(45)])
    there = [face for face in items[0].faces if middle(face)[0] > 330]
    again = [face for face in items[-1].faces if middle(face)[0] < 480]
    assert [face.track_id for face in again] == [face.track_id for face in there]


def test_who_was_away_for_long_comes_back_as_another():
    here = put(wall(), face_of(120), 200, 50)
    items = run([here] * 3 + [wall()] * 75 + [here] * 10)
    assert items[-1].faces[0].track_id != items[0].faces[0].track_id


def test_a_face_that_shrinks_is_left_when_it_is_too_small():
    sizes = np.linspace(70, 20, 60)
    items = run([put(wall(), face_of(round(size)), 300, 150) for size in sizes])
    assert items[0].faces
    assert items[-1].faces == ()
    for item in items:
        for face in item.faces:
            assert np.ptp(face.points_px[:, 0]) > 30


@pytest.mark.parametrize("rate", [30, 60, 120])
@pytest.mark.parametrize("phase", [0, 3, 7])
def test_a_hand_that_covers_the_mouth_is_not_painted(rate, phase):
    picture = put(wall(), face_of(150), 200, 20)
    (face,) = find_faces(picture)
    x, y = face.points_px[LIPS, :2].mean(0).astype(int)
    covered = picture.copy()
    cv2.ellipse(covered, (int(x), int(y) + 12), (46, 34), 0, 0, 360, (205, 160, 135), -1)
    finder, how = FindFaces(), {"time_base": Fraction(1, rate)}
    run([picture] * (rate // 4 + phase), finder, **how)
    after = run([covered] * (rate // 4), finder, first_pts=rate // 4 + phase, **how)
    free = (lip_mask(picture, face) > 0.3).sum()
    for item in after:
        painted = sum((lip_mask(covered, face) > 0.3).sum() for face in item.faces)
        assert painted < 0.25 * free


def test_a_fast_head_is_not_lost():
    scenes = [
        put(grey(), face_of(120), 60 + 22 * (at if at < 12 else 24 - at), 60) for at in range(24)
    ]
    items = run(scenes)  # 22 px a frame: a third of the distance between the eyes
    assert all(len(item.faces) == 1 for item in items)
    assert {item.faces[0].track_id for item in items} == {0}
