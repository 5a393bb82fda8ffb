"""Frames in memory: painted like a video's, in order, and everything else stays as it was."""

import copy
import pickle
from concurrent.futures import ThreadPoolExecutor
from decimal import Decimal
from fractions import Fraction

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as arrays
from makeup_video.pipeline import (
    Layer,
    Look,
    LookError,
    Painter,
    UsageError,
    apply_look,
    paint_frames,
    paint_pictures,
    process_looks,
    process_video,
    product,
    ready_look,
)
from makeup_video.pipeline.frames.rgb_frame import RgbFrame
from people import clip, clip_points, grey, portrait

BLUE = Look(lips=product("#0A2A8C", "matte"))
RED = Look(lips=product("#B4002E", "matte"))


def mouth_of(number):
    points = clip_points()[number]
    x, y = points[[61, 291]].mean(0).astype(int)[:2]
    return np.s_[y - 12 : y + 12, x - 20 : x + 20]


def close(one, other):
    return np.abs(one.astype(int) - other).mean() < 0.5


@pytest.mark.parametrize("count", [0, 1, 3, 4, 5, 9])
def test_one_painted_frame_for_each_and_in_order(count):
    frames = clip(count) if count else ()
    painted = list(paint_frames(iter(frames), BLUE))
    assert len(painted) == count
    for number, (before, after) in enumerate(zip(frames, painted, strict=True)):
        moved = (before != after).any(-1)
        assert moved[mouth_of(number)].any()
        points = clip_points()[number]
        low, high = points.min(0).astype(int) - 20, points.max(0).astype(int) + 20
        moved[low[1] : high[1], low[0] : high[0]] = False
        assert not moved.any()


def test_frames_look_as_pictures_that_are_painted_alone():
    frames = clip(8)
    painter = Painter(BLUE)
    live = [painter(rgb8, number / 30) for number, rgb8 in enumerate(frames)]
    ahead = list(paint_frames(frames, BLUE))
    for alone, one, other in zip(paint_pictures(frames, BLUE), live, ahead, strict=True):
        assert close(alone, one) and close(alone, other)
    assert painter.painted_frames == 8


def test_a_painter_shows_the_faces_of_its_last_frame():
    painter = Painter(BLUE)
    assert painter.found == ()
    for number, rgb8 in enumerate(clip(3)):
        painter(rgb8, number / 30)
        (face,) = painter.found
        off = face.points_px[:, :2] - clip_points()[number]
        assert face.track_id == 0 and np.abs(off).mean() < 3
    painter(np.zeros_like(rgb8), 1.0)
    assert painter.found == ()
    painter(clip(1)[0], 1.1)
    painter.look = Look()
    painter(clip(1)[0], 1.2)
    assert painter.found == ()


def test_a_frame_may_be_used_again_by_its_owner():
    shared = np.empty_like(clip(1)[0])

    def reused():
        for rgb8 in clip(8):
            shared[:] = rgb8
            yield shared

    want = list(paint_frames(clip(8), BLUE))
    for got, wanted in zip(paint_frames(reused(), BLUE), want, strict=True):
        np.testing.assert_array_equal(got, wanted)


def test_times_may_come_with_the_frames():
    frames = clip(7)
    timed = [(rgb8, number / 25) for number, rgb8 in enumerate(frames)]
    for got, want in zip(
        paint_frames(timed, BLUE), paint_frames(frames, BLUE, fps=25), strict=True
    ):
        np.testing.assert_array_equal(got, want)


def test_an_earlier_time_begins_a_new_video():
    frames, painter = clip(3), Painter(BLUE)
    first = painter(frames[0], 5.0)
    painter(frames[1], 5.03)
    np.testing.assert_array_equal(painter(frames[0], 0.0), first)
    np.testing.assert_array_equal(painter(frames[0], 0.0), first)
    assert painter(portrait(), 0.1).shape == portrait().shape  # so does another size


def test_a_new_video_has_its_own_largest_face():
    large = portrait()
    small = cv2.resize(large, None, fx=0.95, fy=0.95, interpolation=cv2.INTER_AREA)
    small = cv2.copyMakeBorder(small, 0, len(large) - len(small), 0, 0, cv2.BORDER_REPLICATE)
    one, other = np.hstack([large, small]), np.hstack([small, large])
    painter, fresh = (Painter(BLUE, faces="largest") for _ in range(2))
    painter(one, 1.0)
    np.testing.assert_array_equal(painter(other, 0.0), fresh(other, 0.0))


def test_the_look_of_a_painter_may_change():
    frames, painter = clip(2), Painter(BLUE)
    painter(frames[0], 0)
    painter.look = RED
    red = painter(frames[1], 1 / 30)[mouth_of(1)].reshape(-1, 3).mean(0)
    blue = apply_look(frames[1], BLUE)[mouth_of(1)].reshape(-1, 3).mean(0)
    assert red[0] > blue[0] + 20 and red[2] < blue[2] - 20
    assert painter.look is RED


@pytest.mark.parametrize("name", ["faces", "device", "smooth"])
def test_a_painter_refuses_what_it_would_not_heed(name):
    with pytest.raises(AttributeError, match=name):
        setattr(Painter(BLUE), name, "largest")


def test_frames_are_counted_over_all_videos_of_a_painter():
    frames, painter = clip(2), Painter(BLUE)
    for seconds in (1.0, 0.0, 0.0):
        painter(frames[0], seconds)
    assert painter.painted_frames == 3


def test_a_bare_look_and_a_picture_without_face_stay():
    frames = [grey(), grey()]
    for look in (Look(), BLUE):
        for got in (*paint_frames(frames, look), Painter(look)(frames[0], 0)):
            np.testing.assert_array_equal(got, frames[0])
            assert got is not frames[0]


BAD_FRAMES = [
    (np.zeros((4, 4), np.uint8), "must be \\(H, W, 3\\) uint8"),
    (np.zeros((4, 4, 3), np.float32), "must be \\(H, W, 3\\) uint8"),
    (
        (np.zeros((4, 4, 3), np.uint8), float("nan")),
        "finite number of seconds, at most 1e\\+12, got nan",
    ),
    ((np.zeros((4, 4, 3), np.uint8), 1e305), "at most 1e\\+12, got 1e\\+305"),
]


@pytest.mark.parametrize(("frame", "words"), BAD_FRAMES)
def test_a_frame_of_another_kind_is_one_line(frame, words):
    with pytest.raises(ValueError, match=words):
        list(paint_frames([frame], BLUE))
    with pytest.raises(ValueError, match=words):
        Painter(BLUE)(*(frame if isinstance(frame, tuple) else (frame, 0.0)))


def test_a_single_picture_is_not_several():
    for paint in (paint_frames, paint_pictures):
        with pytest.raises(ValueError, match=r"got one of shape .*: apply_look paints one"):
            paint(portrait(), BLUE)
        with pytest.raises(TypeError, match=r"must be several arrays, got int: put it in \[\]"):
            paint(5, BLUE)


@pytest.mark.parametrize("size", [(1, 3_000_000), (16_400, 16_400)])
def test_a_picture_too_large_for_a_frame_is_one_line(size):
    huge = np.broadcast_to(np.zeros((1, 1, 3), np.uint8), (*size, 3))
    for paint in (lambda: apply_look(huge, BLUE), lambda: Painter(BLUE)(huge, 0)):
        with pytest.raises(ValueError, match="must have less than 268 million px") as caught:
            paint()
        assert "\n" not in str(caught.value)


@pytest.mark.parametrize("look", [BLUE, Look()])
def test_what_is_painted_is_a_plain_array(look):
    picture = np.ma.masked_array(portrait(), mask=False)
    painted = [Painter(look)(picture, 0), apply_look(picture, look), *paint_frames([picture], look)]
    assert {type(one) for one in painted} == {np.ndarray}


def test_a_painter_refuses_a_second_thread(monkeypatch):
    painter, frame = Painter(BLUE), clip(1)[0]
    painted, refused = RgbFrame.painted, []

    def meanwhile(self):
        with ThreadPoolExecutor(1) as pool:
            refused.append(pool.submit(painter, frame, 1).exception())
        return painted(self)

    monkeypatch.setattr(RgbFrame, "painted", meanwhile)
    painter(frame, 0)
    assert isinstance(refused[0], RuntimeError) and "one thread at a time" in str(refused[0])
    monkeypatch.undo()
    assert painter(frame, 2).shape == frame.shape


@pytest.mark.parametrize(
    "seconds", [Decimal("0.5"), Fraction(1, 2), np.float32(0.5), np.array(0.5)]
)
def test_a_time_may_be_any_type_of_number(seconds):
    frame = portrait()
    painter = Painter(BLUE)
    np.testing.assert_array_equal(painter(frame, seconds), Painter(BLUE)(frame, 0.5))
    assert not np.array_equal(painter(frame, 1), frame)


@pytest.mark.parametrize("seconds", ["1", None, 1j])
def test_a_time_that_is_no_number_is_one_line(seconds):
    with pytest.raises(TypeError, match="time of a frame must be a number of seconds, got"):
        Painter(BLUE)(np.zeros((4, 4, 3), np.uint8), seconds)


@pytest.mark.parametrize("fps", ["30", None, 1j, [30]])
def test_a_frame_rate_that_is_no_number_is_one_line(fps):
    with pytest.raises(TypeError, match="fps must be a number, got"):
        paint_frames([np.zeros((4, 4, 3), np.uint8)], BLUE, fps=fps)


def test_times_and_sizes_that_do_not_fit_name_the_frame():
    small, large = np.zeros((4, 4, 3), np.uint8), np.zeros((4, 6, 3), np.uint8)
    with pytest.raises(
        ValueError, match=r"frame 1: its time must be later than 0\.5 s, got 0\.5 s"
    ):
        list(paint_frames([(small, 0.5), (small, 0.5)], BLUE))
    with pytest.raises(
        ValueError, match=r"frame 1: its shape must be that of the first, \(4, 4, 3\)"
    ):
        list(paint_frames([small, large], BLUE))
    with pytest.raises(ValueError, match="several pictures, got one of shape"):
        paint_frames(small, BLUE)
    with pytest.raises(ValueError, match="fps must be more than 0, got 0"):
        paint_frames([small], BLUE, fps=0)
    with pytest.raises(UsageError, match="faces must be all, largest, or the number"):
        Painter(BLUE, faces="biggest")


NO_LOOKS = [
    (BLUE.to_dict(), r"got dict: Look\.from_dict"),
    ("look.json", r"got str: Look\.load"),
    (None, r"got NoneType: Look\(lips="),
    (product("#fff", "matte"), r"got GraphicsParams: Look\(lips="),
    (ready_look("cat-eye"), "got ReadyLook: give its attribute look"),
]


@pytest.mark.parametrize(("given_look", "words"), NO_LOOKS)
def test_what_is_no_look_is_refused_with_a_hint(tmp_path, given_look, words):
    rgb8, src = grey(), tmp_path / "in.png"
    calls = [
        lambda: Painter(given_look), lambda: paint_frames([rgb8], given_look),
        lambda: paint_pictures([rgb8], given_look), lambda: apply_look(rgb8, given_look),
        lambda: process_looks(src, {"out.png": given_look}),
    ]  # fmt: skip
    if given_look is not None:  # process_video paints nothing then
        calls.append(lambda: process_video(src, tmp_path / "out.png", given_look))
    for call in calls:
        with pytest.raises(TypeError, match=words):
            call()


def test_products_take_the_colours_that_people_write():
    want = product((180, 0, 46), "gloss")
    assert product("#B4002E", "gloss") == product("b4002e", "Glossy") == want
    assert product(np.array([180, 0, 46], np.uint8), "gloss") == want
    assert product("dark red", "matt").hex == "#8B0000"
    with pytest.raises(UsageError, match=r"a colour is '#B4002E', a name .* did you mean darkred"):
        product("darkredd", "matte")
    with pytest.raises(UsageError, match=r"finish must be one of .* did you mean gloss"):
        product("red", "glos")
    with pytest.raises(LookError, match=r"red must be a number in 0\.\.255, got 256"):
        product((256, 0, 0), "matte")
    with pytest.raises(TypeError, match=r"must be GraphicsParams, got str: product\('#B4002E'"):
        Layer("lipstick", "#B4002E")


PICTURES = arrays.arrays(np.uint8, st.tuples(st.integers(1, 9), st.integers(1, 9), st.just(3)))


@settings(deadline=None)
@given(PICTURES)
def test_an_unpainted_rgb_frame_is_the_picture(rgb8):
    opened = RgbFrame(rgb8, 0.25)
    assert opened.frame.seconds == 0.25
    np.testing.assert_array_equal(opened.painted(), rgb8)


@settings(deadline=None)
@given(PICTURES, st.data())
def test_only_pixels_that_change_are_converted_back(rgb8, data):
    opened = RgbFrame(rgb8, 0)
    height, width = rgb8.shape[:2]
    y, x = data.draw(st.integers(0, height - 1)), data.draw(st.integers(0, width - 1))
    luma = opened.frame.writable_planes()[0]
    luma[y, x] ^= 1
    painted = opened.painted()
    # one code of luma, and the rounding of both conversions
    assert np.abs(painted[y, x].astype(int) - rgb8[y, x]).max() <= 3
    painted[y, x] = rgb8[y, x]
    np.testing.assert_array_equal(painted, rgb8)


def test_a_wrong_frame_is_named_by_its_number():
    frames = [portrait()] * 2
    for bad, words in (
        (None, "an array"),
        (portrait()[..., 0], "8-bit RGB"),
        ("a.png", "an array"),
    ):
        with pytest.raises(ValueError, match=f"^frame 2: a picture must be .*{words}"):
            list(paint_frames([*frames, bad], Look()))
    with pytest.raises(TypeError, match=r"^frame 2: .* number of seconds, got '3'"):
        list(paint_frames([*zip(frames, (1, 2), strict=True), (portrait(), "3")], Look()))


@pytest.mark.parametrize("copied", [copy.copy, copy.deepcopy, pickle.dumps])
def test_a_painter_is_not_copied(copied):
    with pytest.raises(TypeError, match="cannot be copied or pickled: make another"):
        copied(Painter(BLUE))


def test_none_stands_for_all_faces_and_the_processor():
    frames = clip(1)
    one = Painter(BLUE, faces=None, device=None)(frames[0], 0)
    assert (one == Painter(BLUE)(frames[0], 0)).all()
    assert len(list(paint_frames(frames, BLUE, faces=None, device=None))) == 1
