"""Which face of a photo is read, and which photos are refused and why."""

import math
from dataclasses import replace

import cv2
import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from makeup_video.pipeline import (
    Look,
    PhotoError,
    SeveralFacesError,
    UsageError,
    apply_look,
    estimate_look,
    find_faces,
    look_from_photo,
    product,
)
from makeup_video.pipeline.faces.net import read_array
from makeup_video.pipeline.reference.checks import (
    MAX_TURN_DEGREES,
    MIN_WIDTH_PX,
    check_face,
    choose_face,
    face_list,
    faces_within,
    turn_degrees,
    width_px,
)
from people import SAMPLES, face_of, grey, portrait, put
from reference_photos import face

# -- which face is read


def two_faces(left_px, right_px):
    return put(put(grey(1000, 600), face_of(left_px), 30, 60), face_of(right_px), 520, 60)


def test_faces_are_numbered_by_size_as_find_faces_orders_them():
    faces = find_faces(two_faces(110, 170))
    assert [found.track_id for found in faces] == [0, 1]
    assert width_px(faces[0]) > width_px(faces[1])
    assert choose_face(faces, "largest") is choose_face(faces, "0") is faces[0]
    assert choose_face(faces, "1") is faces[1]


def test_a_neighbour_whom_the_photo_cuts_off_is_not_meant():
    picture = put(put(grey(700, 600), face_of(150), 60, 60), face_of(150), 530, 60)
    assert len(find_faces(picture)) == 2
    (meant,) = faces_within(picture)
    assert meant.points_px[:, 0].mean() < 350


def test_inspect_shows_the_same_numbers(tmp_path):
    import json

    from makeup_video.pipeline import inspect_video

    picture = two_faces(110, 170)
    cv2.imwrite(str(tmp_path / "in.png"), picture[..., ::-1])
    inspect_video(tmp_path / "in.png", tmp_path / "out.png", tmp_path / "points.json")
    (frame,) = json.loads((tmp_path / "points.json").read_text())["frames"]
    for exported, found in zip(frame["faces"], find_faces(picture), strict=True):
        assert exported["id"] == found.track_id
        np.testing.assert_allclose(exported["points_px"], found.points_px, atol=2)


def test_faces_of_about_one_size_are_numbered_left_to_right(tmp_path):
    """The right face measures a little larger."""
    import json

    from makeup_video.pipeline import inspect_video

    picture = two_faces(150, 152)
    cv2.imwrite(str(tmp_path / "in.png"), picture[..., ::-1])
    inspect_video(tmp_path / "in.png", tmp_path / "out.png", tmp_path / "points.json")
    (frame,) = json.loads((tmp_path / "points.json").read_text())["frames"]
    file_x = {exported["id"]: np.mean(exported["points_px"], 0)[0] for exported in frame["faces"]}
    array_x = {found.track_id: found.points_px.mean(0)[0] for found in find_faces(picture)}
    assert file_x[0] < file_x[1] and array_x[0] < array_x[1]


@pytest.mark.parametrize("chosen", [0, "0", None, "", "largest"])
def test_a_face_is_chosen_by_a_number_or_a_word(chosen):
    assert look_from_photo(SAMPLES / "portrait.jpg", chosen) == look_from_photo(
        SAMPLES / "portrait.jpg"
    )


def test_of_several_faces_one_must_be_chosen():
    with pytest.raises(SeveralFacesError, match=r"^one face was expected, 2 were found") as caught:
        estimate_look(two_faces(150, 130))
    assert "\n" not in str(caught.value)
    assert [face.track_id for face in caught.value.faces] == [0, 1]
    text = face_list(caught.value.faces)
    assert "0 at (" in text and "1 at (" in text and text.count("px wide") == 2


def test_a_small_face_in_the_background_is_ignored():
    picture = put(put(grey(1000, 700), face_of(260), 20, 60), face_of(60), 760, 60)
    assert len(find_faces(picture)) == 2
    assert isinstance(estimate_look(picture), Look)


def test_no_face_and_a_number_that_is_not_there_are_refused():
    with pytest.raises(PhotoError, match="no face was found: give a photo that shows one upright"):
        estimate_look(grey())
    with pytest.raises(
        PhotoError, match=r"no face 3 in the photo; it has face 0 at .*: choose that"
    ):
        choose_face([face()], "3")
    with pytest.raises(PhotoError, match=r"it has faces 0 at .*; 0 at .*: choose one of them"):
        choose_face([face(), face()], "3")


@pytest.mark.parametrize("chosen", ["x", -1, 1.0, "-1", "1.0", "all", "²", "12345678901"])
def test_a_choice_is_a_number_or_largest(chosen):
    with pytest.raises(UsageError, match=r"^face must be largest, or the number"):
        look_from_photo(SAMPLES / "portrait.jpg", chosen)


# -- what cannot be read


def test_a_face_that_is_too_small_is_refused_with_its_width():
    small = face_of(MIN_WIDTH_PX - 30)
    with pytest.raises(PhotoError, match=rf"px wide, and at least {MIN_WIDTH_PX} px are needed"):
        estimate_look(put(grey(), small, 60, 30))


def turned(yaw_degrees, pitch_degrees=0.0, roll_degrees=0.0):
    """Return the mean face, 200 px from eye to eye, turned by these angles."""
    y, p, r = np.radians([yaw_degrees, pitch_degrees, roll_degrees])
    yaw = [[np.cos(y), 0, np.sin(y)], [0, 1, 0], [-np.sin(y), 0, np.cos(y)]]
    pitch = [[1, 0, 0], [0, np.cos(p), -np.sin(p)], [0, np.sin(p), np.cos(p)]]
    roll = [[np.cos(r), -np.sin(r), 0], [np.sin(r), np.cos(r), 0], [0, 0, 1]]
    points = (
        200 * read_array("mean_face.npy").astype(float) @ np.transpose(yaw) @ np.transpose(pitch)
    )
    points = points @ np.transpose(roll) + [300, 300, 0]
    return replace(face(), points_px=points.astype(np.float32))


@given(st.floats(-80, 80), st.floats(-60, 60), st.floats(-180, 180))
def test_the_turn_is_the_angle_between_nose_and_viewer(yaw, pitch, roll):
    true = math.degrees(math.acos(math.cos(math.radians(yaw)) * math.cos(math.radians(pitch))))
    assert turn_degrees(turned(yaw, pitch, roll)) == pytest.approx(true, abs=0.1)


def test_a_face_turned_too_far_is_refused_a_tilted_one_is_not():
    colourful = np.random.default_rng(0).integers(90, 200, (600, 600, 3), np.uint8)
    with pytest.raises(PhotoError, match=f"at most {MAX_TURN_DEGREES} are read"):
        check_face(colourful, turned(MAX_TURN_DEGREES + 5))
    check_face(colourful, turned(MAX_TURN_DEGREES - 5, 0, 90))


def test_a_covered_mouth_is_refused():
    with pytest.raises(PhotoError, match="the mouth is covered"):
        estimate_look(portrait(), replace(face(), mouth_visible=0.1))


def test_a_mouth_outside_is_refused_and_eyes_outside_are_bare():
    chin = int(face().points_px[13, 1])
    with pytest.raises(PhotoError, match="the mouth is covered, cut off"):
        estimate_look(portrait()[:chin], face())
    lids = int(face().points_px[145, 1])
    below = replace(face(), points_px=face().points_px - np.float32([0, lids, 0]))
    lips = replace(face().lips, to_px=face().lips.to_px - [[0, 0, 0], [0, 0, lids]])
    assert estimate_look(portrait()[lids:], replace(below, lips=lips)).eyes is None


TINTS = st.tuples(*[st.floats(0.6, 1.0)] * 3)
STAINS = st.tuples(*[st.floats(0, 60)] * 3)


@given(tint=TINTS, stain=STAINS)
@example(tint=(1.0, 1.0, 1.0), stain=(0.0, 0.0, 0.0))  # grey
def test_a_photo_of_one_tint_is_refused(tint, stain):
    luma = cv2.cvtColor(portrait(), cv2.COLOR_RGB2GRAY)[..., None] / 255
    toned = np.array(stain) + luma * (255 * np.array(tint) - stain)
    with pytest.raises(PhotoError, match="grey, or of one tint"):
        check_face(toned.astype(np.uint8), face())


@given(cast=TINTS, exposure=st.floats(0.3, 1.1))
def test_a_photo_in_coloured_light_is_not_refused(cast, exposure):
    lit = exposure * portrait() * np.array(cast)
    check_face(np.clip(lit, 0, 255).astype(np.uint8), face())


def test_a_photo_too_dark_is_refused_a_dim_one_is_not():
    with pytest.raises(PhotoError, match="too dark to tell its colours"):
        estimate_look((0.06 * portrait()).astype(np.uint8), face())
    check_face((0.25 * portrait()).astype(np.uint8), face())


def test_overexposed_lips_are_refused_bright_ones_are_not():
    bright = np.clip(1.2 * portrait().astype(float), 0, 255).astype(np.uint8)
    check_face(bright, face())
    red = apply_look(portrait(), Look(lips=product((255, 40, 60), "gloss")), [face()])
    check_face(red, face())
    washed = np.clip(4.0 * portrait().astype(float), 0, 255).astype(np.uint8)
    with pytest.raises(PhotoError, match="the lips are overexposed"):
        estimate_look(washed, face())
