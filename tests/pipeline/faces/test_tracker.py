"""Faces are found, told apart, tracked, lost and found again in a video."""

from fractions import Fraction
from itertools import permutations

import cv2
import numpy as np
import pytest
from face_checks import assert_sound, error_percent, middle, run, wall
from makeup_video.pipeline import FindFaces, find_faces, lip_mask
from makeup_video.pipeline.faces import tracker
from makeup_video.pipeline.faces.topology import LIPS
from people import TICK, clip, clip_points, face_of, frame_of, grey, put


def test_no_more_than_thirty_two_faces_are_followed():
    crowd = grey(1280, 720)
    for index in range(45):
        crowd = put(crowd, face_of(56), 10 + index % 9 * 140, 5 + index // 9 * 140)
    assert 20 < len(find_faces(crowd)) <= 32
    assert 20 < len(run([crowd] * 2)[-1].faces) <= 32


def test_no_face_is_added_to_as_many_as_may_be_followed(monkeypatch):
    monkeypatch.setattr(tracker, "MAX_FACES", 1)
    picture = put(put(grey(), face_of(150), 60, 20), face_of(100), 410, 90)
    assert all(len(item.faces) == 1 for item in run([picture] * 12))


def test_a_followed_face_is_now_and_then_checked_mirrored(monkeypatch):
    relocate, checks = tracker.relocate, []

    def noted(nets, picture, before, seconds, verify):
        checks.append(verify)
        return relocate(nets, picture, before, seconds, verify)

    monkeypatch.setattr(tracker, "relocate", noted)
    run([put(grey(), face_of(150), 60, 20)] * 60)
    assert len(checks) == 59 and sum(checks) == 4  # once in every second slot of 0.24 s


@pytest.mark.parametrize("rotation", [90, 180, 270])
def test_a_rotated_video_is_followed_in_stored_pixels(rotation):
    plain = run(clip()[:6])
    turned = run(clip()[:6], rotation_degrees=rotation)
    for a, b in zip(plain, turned, strict=True):
        lips = b.faces[0].points_px[LIPS, :2].mean(0)
        x, y = a.faces[0].points_px[LIPS, :2].mean(0)
        want = {90: (359 - y, x), 180: (639 - x, 359 - y), 270: (y, 639 - x)}[rotation]
        assert lips == pytest.approx(want, abs=1.5)


# --- videos


def test_a_talking_head_keeps_its_number_and_its_points():
    items = run(clip())
    assert all(len(item.faces) == 1 for item in items)
    assert {item.faces[0].track_id for item in items} == {0}
    errors = [
        error_percent(item.faces[0], true) for item, true in zip(items, clip_points(), strict=True)
    ]
    assert max(errors) < 6


@pytest.mark.parametrize("lead", range(3, 12, 2))
def test_a_face_after_black_frames_is_found_in_its_first(lead):
    black = np.zeros_like(clip()[0])
    items = run([*[black] * lead, *clip()[:2], *[black] * 8, clip()[0]])
    assert [len(item.faces) for item in items[lead : lead + 2]] == [1, 1]
    assert len(items[-1].faces) == 1


def test_frames_come_back_with_their_own_face_and_unchanged():
    finder = FindFaces()
    for index in range(4):
        frame = frame_of(clip()[index], index)
        before = [plane.copy() for plane in frame.planes]
        item = finder(frame)
        assert item.frame is frame
        assert all((a == b).all() for a, b in zip(before, frame.planes, strict=True))


def test_two_faces_that_move_keep_their_numbers():
    def scene(index: int) -> np.ndarray:
        return put(put(grey(), face_of(90), 20 + 3 * index, 60), face_of(90), 420 - 3 * index, 120)

    items = run([scene(index) for index in range(30)])
    assert all(len(item.faces) == 2 for item in items)
    for item in items:
        by_id = {face.track_id: middle(face)[0] for face in item.faces}
        assert set(by_id) == {0, 1}
    first = {face.track_id: middle(face)[0] for face in items[0].faces}
    last = {face.track_id: middle(face)[0] for face in items[-1].faces}
    for number in (0, 1):
        towards = 1 if first[number] < 320 else -1
        assert last[number] - first[number] == pytest.approx(towards * 87, abs=6)


@pytest.mark.parametrize("sizes_px", [*permutations((70, 90, 110)), (90, 110, 90), (80, 80, 80)])
def test_faces_that_appear_together_are_numbered_by_size(sizes_px):
    """Equal sizes count from left to right. Scores do not count: painting changes them."""
    scene = grey()
    for index, size_px in enumerate(sizes_px):
        scene = put(scene, face_of(size_px), 20 + 210 * index, 60)
    by_number = sorted(run([scene])[0].faces, key=lambda face: face.track_id)
    wanted = sorted(range(3), key=lambda index: -sizes_px[index])
    assert [round((middle(face)[0] - 85) / 210) for face in by_number] == wanted


def test_only_frames_are_searched():
    for wrong in (grey(), None):
        with pytest.raises(TypeError, match=f"frame must be a Frame, got {type(wrong).__name__}"):
            FindFaces()(wrong)


@pytest.mark.parametrize("rate", [12, 30, 60])
def test_a_new_face_is_picked_up_within_half_a_second(rate):
    alone = put(grey(), face_of(110), 20, 60)
    both = put(alone, face_of(80), 400, 100)
    finder = FindFaces()
    run([alone] * rate, finder, time_base=Fraction(1, rate))
    after = run([both] * rate, finder, first_pts=rate, time_base=Fraction(1, rate))
    first = next(index for index, item in enumerate(after) if len(item.faces) == 2)
    assert first / rate <= 0.5


def test_a_small_face_is_picked_up_in_a_large_video():
    ground = cv2.resize(wall(), (3840, 2160))
    finder = FindFaces()
    empty = finder(frame_of(ground, 0))
    assert not empty.faces
    there = put(ground, face_of(60), 2900, 300)
    seen = [bool(finder(frame_of(there, pts)).faces) for pts in range(5, 125, 5)]
    assert any(seen)


@pytest.mark.parametrize("width", [24, 30, 36])
def test_a_face_that_is_too_small_counts_once_in_a_search(width):
    finder = FindFaces()  # its detector finds the face at several input sizes, and turned
    finder(frame_of(put(grey(), face_of(width), 300, 150)))
    assert finder.tiny_faces == 1


@pytest.mark.parametrize("rotation", [90, 180, 270])
def test_a_phone_held_another_way_is_followed_at_once(rotation):
    turned = [np.ascontiguousarray(np.rot90(picture, rotation // 90)) for picture in clip()[:4]]
    assert all(len(item.faces) == 1 for item in run(turned))


def test_a_face_that_leaves_and_returns_keeps_its_number():
    away = wall()
    here = put(away, face_of(120), 200, 50)
    items = run([here] * 5 + [away] * 15 + [here] * 15)
    assert all(len(item.faces) == 1 for item in items[:5])
    assert all(item.faces == () for item in items[8:20])  # it is gone after a tenth of a second
    assert len(items[-1].faces) == 1
    assert items[-1].faces[0].track_id == items[0].faces[0].track_id
    back = next(index for index, item in enumerate(items[20:]) if item.faces)
    assert back * TICK <= Fraction(1, 2)


def test_a_face_that_walks_out_is_lost_at_the_border():
    scenes = [put(grey(), face_of(120), 330 + 14 * index, 60) for index in range(45)]
    items = run(scenes)
    assert items[0].faces
    assert items[-1].faces == ()
    assert_sound([face for item in items for face in item.faces], (640, 360))


def test_after_a_cut_faces_get_new_numbers_at_once():
    other = put(wall(), face_of(120), 380, 60)
    items = run([*clip()[:5], *[other] * 3])
    assert [item.cut for item in items] == [False] * 5 + [True] + [False] * 2
    assert items[5].faces[0].track_id != items[4].faces[0].track_id
    assert middle(items[5].faces[0])[0] > 380


def test_faces_are_found_though_the_clock_stops_or_jumps_back():
    finder = FindFaces()
    face = put(wall(), face_of(120), 200, 50)
    run([wall()] * 3, finder, first_pts=3000)
    items = [finder(frame_of(face, pts)) for pts in (0, 0, 0, 0, 1, 2, 3, 4, 5, 6, 7, 8)]
    assert not any(item.cut for item in items)
    assert items[-1].faces


def test_faces_that_cross_keep_their_numbers():
    def scene(index: int) -> np.ndarray:
        behind = put(wall(), face_of(90), 20 + 10 * index, 60)
        return put(behind, face_of(110), 420 - 10 * index, 90)

    items = run([scene(index) for index in range(42)])
    first = {face.track_id: middle(face)[0] for face in items[0].faces}
    last = {face.track_id: middle(face)[0] for face in items[-1].faces}
    assert set(first) == set(last) == {0, 1}


def test_a_face_hidden_for_a_moment_keeps_its_number():
    still = put(wall(), face_of(90), 330, 60)
    items = run([put(still, face_of(120), 40 + 14 * index, 70) for index in range(45)])
    hidden = [face for face in items[0].faces if middle(face)[0] > 330]
    again = [face for face in items[-1].faces if middle(face)[0] < 480]
    assert [face.track_id for face in again] == [face.track_id for face in hidden]


@pytest.mark.parametrize("step", [1, -1])
def test_two_faces_that_return_elsewhere_keep_their_numbers(monkeypatch, step):
    """One of them is then nearer to where the other one was."""
    detect = tracker.detect  # the surest face comes first: of equal faces, either may
    monkeypatch.setattr(tracker, "detect", lambda *given: detect(*given)[::step])
    face = face_of(90)[:, 36:152]

    def scene(x: int) -> np.ndarray:
        return put(put(wall(), face, x, 60), face, x + 120, 60)

    items = run([scene(100)] * 5 + [wall()] * 6 + [scene(165)] * 8)
    first, last = (
        [face.track_id for face in sorted(item.faces, key=lambda face: middle(face)[0])]
        for item in (items[0], items[-1])
    )
    assert sorted(first) == [0, 1] and last == first


def test_a_face_away_for_long_returns_under_a_new_number():
    here = put(wall(), face_of(120), 200, 50)
    items = run([here] * 3 + [wall()] * 75 + [here] * 10)
    assert items[-1].faces[0].track_id != items[0].faces[0].track_id


def test_a_shrinking_face_is_dropped_when_too_small():
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
        put(grey(), face_of(120), 60 + 22 * (index if index < 12 else 24 - index), 60)
        for index in range(24)
    ]
    items = run(scenes)  # 22 px a frame: a third of the distance between the eyes
    assert all(len(item.faces) == 1 for item in items)
    assert {item.faces[0].track_id for item in items} == {0}


def test_lips_have_no_comb_of_single_columns():
    """Where the net is unsure, its output differs between the columns of its last cells."""
    singles = []
    for item in run(clip()):
        lips = item.faces[0].lips.logits > 0
        edges = lips[:, 1:] != lips[:, :-1]
        singles.append((edges[:, 1:] & edges[:, :-1]).sum())
    assert np.mean(singles) < 1 and max(singles) < 5
