"""A look from a photo: whose face, what is refused and why, and that the photo's form is no matter."""

import math
from dataclasses import fields, replace
from functools import cache

import cv2
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from makeup_video.pipeline import (
    FINISHES,
    GraphicsParams,
    Look,
    PhotoError,
    SeveralFacesError,
    UsageError,
    apply_look,
    estimate_look,
    find_faces,
    lip_mask,
    look_from_photo,
    product,
)
from makeup_video.pipeline.faces.net import read_array
from makeup_video.pipeline.look.ciede2000 import ciede2000, lab_of
from makeup_video.pipeline.look.finishes import in_words
from makeup_video.pipeline.reference.checks import (
    MAX_TURN_DEGREES,
    MIN_WIDTH_PX,
    check_face,
    choose_face,
    face_list,
    turn_degrees,
    width_px,
)
from makeup_video.pipeline.reference.crops import NUMBERS, from_targets, to_targets
from makeup_video.pipeline.reference.estimate import (
    BARE_GLOSS,
    BARE_OPACITY,
    BARE_REFLECTION,
    MOST_GLOSS,
    MOST_REFLECTION,
    product_of,
)
from people import SAMPLES, clip, face_of, grey, portrait, put

SEVEN = st.tuples(
    st.floats(0, 1), *[st.floats(0, 255)] * 3, st.floats(0, 16), st.floats(0, 1), st.floats(0, 1)
)


@cache
def face():
    return find_faces(portrait())[0]


@cache
def looked():
    return estimate_look(portrait(), face())


def told(params):
    """What a net tells, all but the gloss: more than a lacquer's looks the same. Colours
    count by opacity: those of sheer products hardly show."""
    if params is None:
        return np.zeros(6)
    targets = to_targets([getattr(params, name) for name in NUMBERS])
    targets[1:4] *= targets[0]
    return np.delete(targets, NUMBERS.index("gloss"))


def off(one, other):
    """How far two estimates differ, at most, on the nets' own scale of 0 to 1."""
    regions = ((one.lips, other.lips), (one.eyes, other.eyes))
    return max(np.abs(told(a) - told(b)).max() for a, b in regions)


def test_a_look_is_estimated_with_all_its_settings():
    look = looked()
    assert (look.strength, look.zone, look.intensity) == (1, "lid", 1)
    assert look == estimate_look(portrait())  # the one face there is
    assert Look.from_dict(look.to_dict()) == look


def test_the_file_gives_the_same_as_its_pixels(tmp_path):
    cv2.imwrite(str(tmp_path / "in.png"), portrait()[..., ::-1])
    assert look_from_photo(tmp_path / "in.png") == estimate_look(portrait())
    assert look_from_photo(tmp_path / "in.png", "0") == look_from_photo(
        tmp_path / "in.png", "largest"
    )


@pytest.mark.parametrize("ground", [(1200, 900), (700, 1500)])
def test_a_bigger_picture_around_the_face_tells_about_the_same(ground):
    picture = put(grey(*ground), portrait(), ground[0] - 520, ground[1] - 640)
    assert off(estimate_look(picture), looked()) < 0.12


def test_the_mirrored_photo_tells_about_the_same():
    photo = clip(1)[0]
    assert off(estimate_look(photo[:, ::-1]), estimate_look(photo)) < 0.12


def test_a_larger_photo_tells_about_the_same():
    twice = cv2.resize(portrait(), None, fx=2, fy=2, interpolation=cv2.INTER_CUBIC)
    assert off(estimate_look(twice), looked()) < 0.12


@pytest.mark.parametrize("hex_rgb", [(180, 0, 30), (20, 40, 160), (15, 12, 14)])
def test_an_opaque_lipstick_is_read_nearer_to_itself_than_bare_lips_are(hex_rgb):
    true = Look(lips=product(hex_rgb, "matte"))
    worn = apply_look(portrait(), true, [face()])
    again = apply_look(portrait(), replace(estimate_look(worn), eyes=None), [face()])
    where = lip_mask(portrait(), face()) > 0.5
    lab = [lab_of(picture[where]) for picture in (worn, again, portrait())]
    assert ciede2000(lab[0], lab[1]).mean() < ciede2000(lab[0], lab[2]).mean()


# -- whose face


def two_faces(left_px, right_px):
    return put(put(grey(1000, 600), face_of(left_px), 30, 60), face_of(right_px), 520, 60)


def test_faces_are_numbered_by_size_as_find_faces_orders_them():
    faces = find_faces(two_faces(110, 170))
    assert [one.track_id for one in faces] == [0, 1]
    assert width_px(faces[0]) > width_px(faces[1])
    assert choose_face(faces, "largest") is choose_face(faces, "0") is faces[0]
    assert choose_face(faces, "1") is faces[1]


def test_inspect_shows_the_same_numbers(tmp_path):
    import json

    from makeup_video.pipeline import inspect_video

    picture = two_faces(110, 170)
    cv2.imwrite(str(tmp_path / "in.png"), picture[..., ::-1])
    inspect_video(tmp_path / "in.png", tmp_path / "out.png", tmp_path / "points.json")
    (frame,) = json.loads((tmp_path / "points.json").read_text())["frames"]
    for shown, one in zip(frame["faces"], find_faces(picture), strict=True):
        assert shown["id"] == one.track_id
        np.testing.assert_allclose(shown["points_px"], one.points_px, atol=2)


def test_faces_about_as_large_are_numbered_from_left_to_right_by_all(tmp_path):
    """The right one measures a little larger."""
    import json

    from makeup_video.pipeline import inspect_video

    picture = two_faces(150, 152)
    cv2.imwrite(str(tmp_path / "in.png"), picture[..., ::-1])
    inspect_video(tmp_path / "in.png", tmp_path / "out.png", tmp_path / "points.json")
    (frame,) = json.loads((tmp_path / "points.json").read_text())["frames"]
    shown = {one["id"]: np.mean(one["points_px"], 0)[0] for one in frame["faces"]}
    found = {one.track_id: one.points_px.mean(0)[0] for one in find_faces(picture)}
    assert shown[0] < shown[1] and found[0] < found[1]


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


def test_somebody_small_in_the_background_is_not_meant():
    picture = put(put(grey(1000, 700), face_of(260), 20, 60), face_of(60), 760, 60)
    assert len(find_faces(picture)) == 2
    assert isinstance(estimate_look(picture), Look)


def test_no_face_and_a_number_that_is_not_there_are_refused():
    with pytest.raises(PhotoError, match="no face was found: give a photo that shows one upright"):
        estimate_look(grey())
    with pytest.raises(PhotoError, match="there is no face 3; there are 0 at"):
        choose_face([face()], "3")


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
    """The mean face, 200 px from eye to eye, turned."""
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


def test_a_face_turned_too_far_is_refused_and_a_tilted_one_is_not():
    colourful = np.full((600, 600, 3), (200, 120, 90), np.uint8)
    with pytest.raises(PhotoError, match=f"at most {MAX_TURN_DEGREES} are read"):
        check_face(colourful, turned(MAX_TURN_DEGREES + 5))
    check_face(colourful, turned(MAX_TURN_DEGREES - 5, 0, 90))


def test_a_covered_mouth_is_refused():
    with pytest.raises(PhotoError, match="the mouth is covered"):
        estimate_look(portrait(), replace(face(), mouth_visible=0.1))


def test_a_mouth_beyond_the_border_is_refused_and_eyes_there_are_bare():
    chin = int(face().points_px[13, 1])
    with pytest.raises(PhotoError, match="the mouth is covered, cut off"):
        estimate_look(portrait()[:chin], face())
    lids = int(face().points_px[145, 1])
    below = replace(face(), points_px=face().points_px - np.float32([0, lids, 0]))
    lips = replace(face().lips, to_px=face().lips.to_px - [[0, 0, 0], [0, 0, lids]])
    assert estimate_look(portrait()[lids:], replace(below, lips=lips)).eyes is None


def test_a_photo_without_colours_is_refused():
    luma = cv2.cvtColor(portrait(), cv2.COLOR_RGB2GRAY)
    with pytest.raises(PhotoError, match="the photo is grey"):
        estimate_look(cv2.merge([luma] * 3))


def test_a_photo_that_is_too_dark_is_refused_and_a_dim_one_is_not():
    with pytest.raises(PhotoError, match="too dark to tell its colours"):
        estimate_look((0.06 * portrait()).astype(np.uint8), face())
    check_face((0.25 * portrait()).astype(np.uint8), face())


def test_overexposed_lips_are_refused_and_bright_or_red_ones_are_not():
    bright = np.clip(1.2 * portrait().astype(float), 0, 255).astype(np.uint8)
    check_face(bright, face())
    red = apply_look(portrait(), Look(lips=product((255, 40, 60), "gloss")), [face()])
    check_face(red, face())
    washed = np.clip(4.0 * portrait().astype(float), 0, 255).astype(np.uint8)
    with pytest.raises(PhotoError, match="the lips are overexposed"):
        estimate_look(washed, face())


def test_a_file_is_named_in_its_refusal(tmp_path):
    cv2.imwrite(str(tmp_path / "in.png"), np.dstack([grey(), np.full((360, 640), 255, np.uint8)]))
    with pytest.raises(PhotoError, match=r"in.png: no face was found"):
        look_from_photo(tmp_path / "in.png")


@pytest.mark.parametrize("bad", [portrait()[..., 0], portrait() / 255.0, portrait()[:0]])
def test_what_is_no_rgb_picture_is_a_value_error(bad):
    with pytest.raises(ValueError, match="8-bit RGB"):
        estimate_look(bad)


# -- seven numbers -> a product


@given(SEVEN, st.sampled_from(["lips", "eyes"]))
def test_the_numbers_are_kept_and_the_rest_is_a_finishs(numbers, region):
    got = product_of(np.array(numbers), region)
    opacity, _, _, _, gloss, _, reflection = numbers
    nothing = opacity < BARE_OPACITY - 1e-3 and gloss < BARE_GLOSS - 1e-3
    if got is None:
        assert opacity < BARE_OPACITY and gloss < BARE_GLOSS and reflection < BARE_REFLECTION
        return
    assert not (nothing and reflection < BARE_REFLECTION - 1e-3)
    most = [1, 255, 255, 255, MOST_GLOSS, 1, MOST_REFLECTION]
    kept = np.minimum(numbers, most)
    np.testing.assert_allclose([getattr(got, name) for name in NUMBERS], kept, atol=5.1e-4)
    rest = {spec.name: getattr(got, spec.name) for spec in fields(GraphicsParams)[7:]}
    assert rest["shimmer"] == 0
    assert rest in [{name: one[region][name] for name in rest} for one in FINISHES.values()]


@given(st.lists(st.floats(-3, 9), min_size=7, max_size=7))
def test_whatever_a_net_tells_is_a_look(targets):
    for region in ("lips", "eyes"):
        got = product_of(from_targets(np.array(targets)), region)
        assert got is None or in_words(got, region)


@pytest.mark.parametrize(
    ("finish", "words"),
    [
        ("matte", "matte, opaque"),
        ("gloss", "glossy, opaque"),
        ("sheer", "soft sheen, fairly sheer"),
    ],
)
def test_a_product_is_told_in_words(finish, words):
    assert in_words(product((1, 2, 3), finish)) == words
