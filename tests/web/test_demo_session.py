"""The demo: a portrait and a look per page; the newest look wins; pages reconnect and leave."""

import asyncio
import base64
import threading
import time
from dataclasses import replace

import cv2
import httpx
import numpy as np
import pytest
from makeup_video.pipeline import (
    InputError,
    InstallError,
    Look,
    UsageError,
    apply_look,
    find_faces,
    lip_mask,
)
from makeup_video.pipeline.images.photo_file import read_photo
from makeup_video.web import demo_session
from makeup_video.web.app import PAGE
from makeup_video.web.demo_session import MOST_SESSIONS, DemoShow
from makeup_video.web.portrait import SHOWN_PX, THUMBNAIL_PX, WHOLE_PX, Portrait
from makeup_video.web.slow_jobs import SlowJobs
from people import SAMPLES, clip, grey, portrait
from shows import BLUE, RED, Page, post, serving

OURS = PAGE / "portrait.jpg"


@pytest.fixture(scope="module")
def own_portrait():
    return Portrait(read_photo(OURS), "portrait.jpg")


@pytest.fixture
def url(own_portrait):
    slow_jobs = SlowJobs()
    with serving(DemoShow(own_portrait, RED, slow_jobs, print), slow_jobs) as url:
        yield url


def rgb8_of(jpeg):
    return cv2.imdecode(np.frombuffer(jpeg, np.uint8), cv2.IMREAD_COLOR)[..., ::-1]


def png_of(rgb8):
    return cv2.imencode(".png", np.ascontiguousarray(rgb8[..., ::-1]))[1].tobytes()


def lips_of(rgb8, faces=None):
    """The mean colour of the lips."""
    face = (faces or find_faces(np.ascontiguousarray(rgb8)))[0]
    return rgb8[lip_mask(np.ascontiguousarray(rgb8), face) > 0.9].mean(0)


# -- a portrait


def test_our_own_portrait_is_painted_as_apply_look_paints_it(own_portrait):
    bare = rgb8_of(OURS.read_bytes())
    wanted = apply_look(np.ascontiguousarray(bare), RED)
    got = rgb8_of(own_portrait.painted(RED))
    assert np.abs(got.astype(int) - wanted).mean() < 2  # encoded as JPEG once more
    assert np.abs(rgb8_of(own_portrait.bare).astype(int) - bare).mean() < 2
    assert lips_of(got)[1] < lips_of(bare)[1] - 20


def test_a_large_portrait_is_shown_small_and_kept_large():
    large = cv2.resize(portrait(), None, fx=5, fy=5)
    large_portrait = Portrait(large, "large.png")
    whole = large_portrait.painted_whole(RED)
    assert (
        max(whole.shape) == WHOLE_PX and max(rgb8_of(large_portrait.painted(RED)).shape) == SHOWN_PX
    )
    shown = cv2.resize(whole, None, fx=0.5, fy=0.5, interpolation=cv2.INTER_AREA)
    off = np.abs(rgb8_of(large_portrait.painted(RED)).astype(int) - shown)
    assert off.mean() < 2 and np.percentile(off, 99.5) < 25  # faces lie as in the large portrait


def test_a_thumbnail_is_the_face_with_the_look(own_portrait):
    bare, red, blue = (rgb8_of(own_portrait.thumbnail(look)) for look in (Look(), RED, BLUE))
    assert bare.shape == red.shape == (THUMBNAIL_PX, THUMBNAIL_PX, 3)
    (face,) = find_faces(np.ascontiguousarray(bare))
    low, high = face.points_px[:, :2].min(0), face.points_px[:, :2].max(0)
    assert (high - low).max() > 0.85 * THUMBNAIL_PX
    assert np.abs((low + high) / 2 - THUMBNAIL_PX / 2).max() < 0.05 * THUMBNAIL_PX
    lips = lip_mask(np.ascontiguousarray(bare), face) > 0.9
    assert red[lips].mean(0)[0] > blue[lips].mean(0)[0] + 30
    assert own_portrait.thumbnail(RED) is own_portrait.thumbnail(RED)  # painted once


@pytest.mark.parametrize("cut", [np.s_[200:470], np.s_[:, 130:390], np.s_[150:, 100:]])
def test_a_thumbnail_is_square_however_the_photo_is_cut(cut):
    cropped = Portrait(read_photo(png_of(rgb8_of(OURS.read_bytes())[cut])), "cut.png")
    thumbnail = rgb8_of(cropped.thumbnail(RED))
    assert thumbnail.shape == (THUMBNAIL_PX, THUMBNAIL_PX, 3)
    assert find_faces(np.ascontiguousarray(thumbnail))


@pytest.mark.parametrize(
    ("photo", "words"),
    [
        (b"", "me.png is empty"),
        (b"words", "me.png is no photo"),
        (png_of(grey()), "me.png: no face"),
    ],
)
def test_an_unusable_portrait_is_one_line_with_its_name(photo, words):
    with pytest.raises(InputError) as caught:
        Portrait(read_photo(photo, "me.png"), "me.png")
    assert str(caught.value).startswith(words) and "\n" not in str(caught.value)


# -- pages


def test_a_page_sees_the_portrait_and_each_look_painted_on_it(url):
    with Page(url) as page:
        red = rgb8_of(page.picture()[2])
        page.send("look", look=BLUE.to_dict(), n=1)
        blue = rgb8_of(page.picture()[2])
        assert page.hello["look"] == RED.to_dict()
    faces = find_faces(np.ascontiguousarray(red))
    assert lips_of(red, faces)[0] > lips_of(blue, faces)[0] + 30
    assert lips_of(blue, faces)[2] > lips_of(red, faces)[2] + 30


def test_a_page_that_compares_gets_the_bare_portrait_too(url):
    with Page(url) as page:
        assert page.picture()[3] == b""
        page.send("compare", on=True)
        _, _, jpeg, before = page.picture()
        assert rgb8_of(before).shape == rgb8_of(jpeg).shape and before != jpeg


def test_each_page_has_its_own_look_and_its_own_portrait(url):
    with Page(url) as page, Page(url) as other:
        first, same = page.picture(), other.picture()
        assert first[2] == same[2] and page.hello["session"] != other.hello["session"]
        page.send("look", look=BLUE.to_dict(), n=1)
        assert page.picture()[2] != first[2]
        answer = page.post("/portrait", png_of(clip(1)[0]), x_file_name="her.png")
        assert answer.status_code == 200, answer.text
        assert rgb8_of(page.picture()[2]).shape == clip(1)[0].shape
        other.send("compare", on=True)
        assert other.picture()[2] == same[2]


def test_of_two_people_in_a_photo_one_is_chosen(url):
    made_up = apply_look(portrait(), BLUE)
    both = np.hstack([portrait(), made_up])
    with Page(url) as page:
        answer = page.post("/photo", png_of(both), x_file_name="both.png")
        assert answer.status_code == 409
        choice = answer.json()
        assert choice["error"] == "both.png shows 2 faces: choose one"
        picture = rgb8_of(base64.b64decode(choice["picture"]))
        assert max(picture.shape) == 800
        assert picture.shape[1] / picture.shape[0] == pytest.approx(
            both.shape[1] / both.shape[0], 0.01
        )
        left, right = sorted(choice["faces"], key=lambda face: face["left"])
        assert 0 < left["left"] < left["left"] + left["width"] < 0.5 < right["left"]
        assert right["left"] + right["width"] < 1 and 0 < right["top"] < 0.5
        where = f"/photo?session={page.hello['session']}&face={right['number']}"
        answer = post(url, where, png_of(both), x_file_name="both.png")
        assert answer.status_code == 200, answer.text
        lips = Look.from_dict(answer.json()["look"]).lips
        assert lips.blue > 1.5 * lips.red  # of the face on the right
        where = where.replace(f"face={right['number']}", "face=9")
        assert "there is no face 9" in post(url, where, png_of(both)).json()["error"]


def test_a_portrait_without_a_face_leaves_the_old_one(url):
    with Page(url) as page:
        first = page.picture()[2]
        answer = page.post("/portrait", png_of(grey()), x_file_name="wall.png")
        assert answer.status_code == 422
        assert answer.json()["error"].startswith("wall.png: no face was found")
        page.send("compare", on=True)
        assert page.picture()[2] == first


def test_a_dropped_photo_is_read_and_painted(url):
    with Page(url) as page:
        before = rgb8_of(page.picture()[2])
        data = (SAMPLES / "look.jpg").read_bytes()
        answer = page.post("/photo", data, x_file_name="look.jpg")
        assert answer.status_code == 200, answer.text
        assert answer.json()["words"].startswith("lips #")
        assert np.abs(rgb8_of(page.picture()[2]).astype(int) - before).max() > 30


def test_the_whole_picture_is_what_was_painted_last(url):
    with Page(url) as page:
        page.picture()
        page.send("look", look=BLUE.to_dict(), n=1)
        shown = rgb8_of(page.picture()[2])
        answer = httpx.get(f"{url}/picture.png?session={page.hello['session']}", timeout=30)
    assert np.abs(rgb8_of(answer.content).astype(int) - shown).mean() < 2


def test_a_page_that_lost_its_connection_finds_its_look_again(url):
    with Page(url) as page:
        page.send("look", look=BLUE.to_dict(), n=1)
        page.send("nothing")
        page.message("error")
    with Page(url, page.hello["session"]) as again:
        assert again.hello["look"] == BLUE.to_dict()
        assert again.hello["session"] == page.hello["session"]


def test_a_second_page_of_the_same_session_compares_too(url):
    with Page(url) as page, Page(url, page.hello["session"]) as other:
        page.picture(), other.picture()
        page.send("compare", on=True)
        assert page.picture()[3] != b""
        assert other.picture()[3] == b""
        other.send("compare", on=True)
        assert other.picture()[3] != b""


# -- sessions


class Bare:
    """A portrait whose painting waits for the test."""

    bare = b"bare"

    def __init__(self, fails=None):
        self.fails, self.painted_looks = fails, []
        self.begun, self.go_on = threading.Event(), threading.Event()

    def painted(self, look):
        self.begun.set()
        assert self.go_on.wait(20)
        if self.fails:
            raise self.fails
        self.painted_looks.append(look)
        return b"painted"


def test_while_one_look_is_painted_only_the_newest_waits():
    slow, slow_jobs, pictures = Bare(), SlowJobs(), []
    session = DemoShow(slow, RED, slow_jobs, print).enter("")
    session.watch(pictures.append)
    assert slow.begun.wait(20)
    looks = [replace(RED, strength=percent / 100) for percent in range(50)]
    for look in looks:
        session.set_look(look)
    slow.go_on.set()
    slow_jobs.submit(lambda: None).result(20)
    assert slow.painted_looks in ([RED, looks[-1]], [looks[-1], looks[-1]])
    assert [pushed.pts_us for pushed in pictures] == sorted(pushed.pts_us for pushed in pictures)


def test_a_look_that_is_the_same_is_not_painted_again():
    quick, slow_jobs, pictures = Bare(), SlowJobs(), []
    quick.go_on.set()
    session = DemoShow(quick, RED, slow_jobs, print).enter("")
    session.watch(pictures.append)
    session.set_look(Look.from_dict(RED.to_dict()))
    slow_jobs.submit(lambda: None).result(20)
    assert len(pictures) == 1


def test_nothing_is_painted_while_nobody_watches():
    quick, slow_jobs = Bare(), SlowJobs()
    session = DemoShow(quick, RED, slow_jobs, print).enter("")
    session.set_look(BLUE)
    slow_jobs.submit(lambda: None).result(20)
    assert not quick.begun.is_set()


@pytest.mark.parametrize(
    ("error", "line"),
    [
        (InstallError("no OpenCL"), "InstallError: no OpenCL"),
        (ZeroDivisionError("0"), "internal error while painting: ZeroDivisionError: 0"),
    ],
)
def test_an_error_of_the_painter_is_logged(error, line):
    slow_jobs, log_lines = SlowJobs(), []
    broken = Bare(error)
    broken.go_on.set()
    DemoShow(broken, RED, slow_jobs, log_lines.append).enter("").watch(print)
    slow_jobs.submit(lambda: None).result(20)
    assert log_lines == [line]


def test_sessions_end_after_their_page_and_are_limited():
    async def pages():
        show = DemoShow(Bare(), RED, SlowJobs(), print, grace_seconds=0.01)
        short = show.enter("")
        show.leave(short)
        until = time.monotonic() + 20
        while show.find(short.name) is not None:
            assert time.monotonic() < until
            await asyncio.sleep(0.001)
        show = DemoShow(Bare(), RED, SlowJobs(), print, grace_seconds=100)
        sessions = [show.enter("") for _ in range(MOST_SESSIONS)]
        with pytest.raises(UsageError, match=f"{MOST_SESSIONS} pages are open already"):
            show.enter("")
        show.leave(sessions[3])
        show.leave(sessions[5])
        assert show.enter(sessions[3].name) is sessions[3]  # its page came back in time
        show.leave(sessions[3])
        show.enter("")  # the session whose page left first gives way
        assert show.find(sessions[5].name) is None and show.find(sessions[3].name) is sessions[3]

    asyncio.run(pages())


def test_names_of_sessions_cannot_be_guessed():
    show = DemoShow(Bare(), RED, SlowJobs(), print)
    names = {show.enter("mine").name for _ in range(5)}
    assert len(names) == 5 and "mine" not in names and min(map(len, names)) >= 20


def test_the_limits_keep_memory_in_bounds():
    assert MOST_SESSIONS * WHOLE_PX**2 * 3 < 300e6
    assert demo_session.GRACE_SECONDS < 120
