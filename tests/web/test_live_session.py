"""A live run as pages receive it: in right colours, upright, and only while pages watch."""

import threading
from contextlib import contextmanager
from dataclasses import dataclass, replace
from fractions import Fraction

import cv2
import httpx
import numpy as np
import pytest
from live_doubles import List
from makeup_video.pipeline import InputError, UsageError
from makeup_video.pipeline.images.jpeg import PreviewJpeg
from makeup_video.pipeline.live.interfaces import LIVE_TIME_BASE, LivePicture
from makeup_video.pipeline.live.run import SinkFigures
from makeup_video.web import live_session
from makeup_video.web.live_session import LiveShow
from makeup_video.web.portrait import own_portrait
from makeup_video.web.preview_sink import PreviewSink
from people import clip, frame_of, portrait
from shows import BLUE, RED, Page, post, serving


@dataclass
class Figures:
    fps: float = 30.0
    notice: str = ""
    sinks: tuple = ()


class Run:
    def __init__(self):
        self.compare, self.look = False, RED
        self.sinks = []

    def add_sink(self, sink):
        self.sinks.append(SinkFigures(sink.name, 0, 0, "recording"))

    def end_sink(self, sink):
        self.sinks[-1] = replace(self.sinks[-1], is_over=True)

    def set_look(self, look):
        self.look = look

    def figures(self):
        return Figures(sinks=tuple(self.sinks))


class Counted(PreviewJpeg):
    made = 0

    def __call__(self, *args):
        self.made += 1
        return super().__call__(*args)


@pytest.fixture
def parts():
    run, jpeg = Run(), Counted(90)
    sink = PreviewSink(jpeg)
    return run, jpeg, sink, LiveShow(run, sink)


def picture(pts=5, rotation_degrees=0, before=False, **options):
    frame = frame_of(clip(1)[0], pts, time_base=LIVE_TIME_BASE, rotation_degrees=rotation_degrees, **options)  # fmt: skip
    planes = tuple(plane // 2 for plane in frame.planes) if before else None
    return LivePicture(frame, planes)


@contextmanager
def filming(sink, shown):
    """A camera that sends this picture again and again."""
    ended = threading.Event()

    def film():
        while not ended.wait(0.01):
            sink(LivePicture(shown.frame, shown.before))

    thread = threading.Thread(target=film)
    thread.start()
    try:
        yield
    finally:
        ended.set()
        thread.join()


def rgb8_of(data):
    return cv2.imdecode(np.frombuffer(data, np.uint8), cv2.IMREAD_COLOR)[..., ::-1].astype(int)


def test_all_pages_share_one_look_which_the_run_paints(parts):
    run, _, _, show = parts
    with serving(show) as url, Page(url) as page, Page(url) as other:
        assert page.hello["mode"] == "live"
        assert page.hello["session"] == other.hello["session"]
        page.send("look", look=BLUE.to_dict(), n=1)
        assert other.message("look")["look"] == BLUE.to_dict()
    assert run.look == BLUE


def test_pictures_become_jpegs_only_while_somebody_watches(parts):
    _, jpeg, sink, show = parts
    sink(picture())
    assert jpeg.made == 0
    with serving(show) as url, Page(url) as page:
        page.message("figures")  # the page is connected
        sink(picture(pts=123))
        pts_us, rotation, data, before = page.picture()
    assert (pts_us, rotation, before, jpeg.made) == (123, 0, b"", 1)
    assert np.abs(rgb8_of(data) - clip(1)[0]).mean() < 4


def test_before_is_made_only_while_somebody_compares(parts):
    run, jpeg, sink, show = parts
    with serving(show) as url, Page(url) as page:
        page.message("figures")
        sink(picture(before=True))  # from a run that has not noticed the end of the comparison yet
        assert page.picture()[3] == b"" and jpeg.made == 1
        page.send("compare", on=True)
        page.send("nothing")
        page.message("error")
        assert run.compare
        sink(picture(pts=6, before=True))
        _, _, data, before = page.picture()
        assert rgb8_of(before).mean() < rgb8_of(data).mean() * 0.8
    assert not run.compare


def test_pages_that_begin_to_compare_now_keep_the_planes():
    """A page begins to compare just as a request for one picture of before and after ends."""

    class Sink(PreviewSink):
        @property
        def compares(self):
            read = self.__dict__["compares"]
            if begins:
                begins.pop().start()
                threads[0].join(0.5)  # waits in vain where the planes are under a lock
            return read

        @compares.setter
        def compares(self, on):
            self.__dict__["compares"] = on

    begins = []
    run, sink = Run(), Sink(Counted(90))
    session = LiveShow(run, sink).enter("")
    threads = [threading.Thread(target=session.compare, args=(True,))]
    begins += threads
    with filming(sink, picture(before=True)):
        session.whole_picture(both=True)
    threads[0].join(20)
    assert run.compare


def test_times_become_microseconds_from_any_time_base(parts):
    _, _, sink, _ = parts
    got = []
    sink.push = got.append
    sink(LivePicture(frame_of(clip(1)[0], 90_000, time_base=Fraction(1, 90_000))))
    assert got[0].pts_us == 1_000_000


def test_figures_are_those_of_the_run(parts):
    with serving(parts[3]) as url, Page(url) as page:
        message = page.message("figures")
    assert message["fps"] == 30.0 and message["notice"] == "" and message["viewers"] == 1


@pytest.mark.parametrize("rotation_degrees", [0, 90, 180, 270])
@pytest.mark.parametrize("colours", [(1, False), (1, True), (5, False)])
def test_the_whole_picture_is_upright_and_in_right_colours(parts, rotation_degrees, colours):
    _, _, sink, show = parts
    matrix, full_range = colours
    sink(picture(rotation_degrees=rotation_degrees, matrix=matrix, full_range=full_range))
    with serving(show) as url, Page(url):
        answer = httpx.get(f"{url}/picture.png?session=live")
    assert rgb8_of(answer.content).shape == clip(1)[0].shape
    assert np.abs(rgb8_of(answer.content) - clip(1)[0]).mean() < 3


def test_before_the_first_frame_there_is_no_picture(parts):
    with serving(parts[3]) as url, Page(url):
        assert httpx.get(f"{url}/picture.png?session=live").status_code == 404
        assert httpx.head(f"{url}/picture.png?session=live&both").status_code == 404


def test_a_camera_takes_no_portrait(parts):
    with pytest.raises(UsageError, match="makeup-video demo"):
        parts[3].enter("").take_portrait(b"x", "me.jpg")


def test_thumbnails_show_our_portrait(parts):
    assert parts[-1].enter("").thumbnail(RED) == own_portrait().thumbnail(RED)


def test_the_looks_are_shown_on_whom_the_camera_sees(parts):
    run, _, sink, show = parts
    session = show.enter("")
    ours = session.portrait_thumbnail()
    frame = frame_of(portrait(), 5, time_base=LIVE_TIME_BASE)
    with filming(sink, LivePicture(frame, tuple(plane.copy() for plane in frame.planes))):
        session.take_portrait(b"", "the camera")
    assert session.portrait_thumbnail() != ours and session.thumbnail(RED) != ours
    assert not run.compare  # as before


def test_without_a_picture_the_camera_gives_no_portrait(parts, monkeypatch):
    monkeypatch.setattr(live_session, "_BARE_SECONDS", 0.05)
    with pytest.raises(InputError, match="the camera sends no frames now"):
        parts[3].enter("").take_portrait(b"", "")
    with pytest.raises(InputError, match="the camera sends no frames now"):
        parts[3].enter("").whole_picture(True)


def test_the_last_picture_of_a_lost_camera_is_not_new(parts, monkeypatch):
    monkeypatch.setattr(live_session, "_BARE_SECONDS", 0.05)
    _, _, sink, show = parts
    sink(picture(before=True))
    session = show.enter("")
    with pytest.raises(InputError, match="the camera sends no frames now"):
        session.take_portrait(b"", "")
    with pytest.raises(InputError, match="the camera sends no frames now"):
        session.whole_picture(True)
    assert session.whole_picture(False).shape == clip(1)[0].shape  # the picture that pages show


def test_a_page_starts_and_stops_recordings_one_at_a_time():
    run, names = Run(), iter("ab")
    show = LiveShow(run, PreviewSink(PreviewJpeg()), None, lambda: List(next(names)))
    with serving(show) as url, Page(url) as page:
        where = "/recording?session=live&on="
        for on in "110":
            assert post(url, where + on, b"").json() == {"on": on == "1"}
        assert [(one.name, one.is_over) for one in run.sinks] == [("a", True)]
        post(url, where + "1", b"")
        assert [(one.name, one.is_over) for one in run.sinks] == [("a", True), ("b", False)]
        while not (sinks := page.message("figures")["sinks"]):
            pass  # figures from before the recording
        assert sinks[-1]["kind"] == "recording"


def test_a_recording_that_failed_can_be_started_again():
    run, names = Run(), iter("ab")
    session = LiveShow(run, PreviewSink(PreviewJpeg()), None, lambda: List(next(names))).enter("")
    session.record(True)
    run.end_sink(None)  # as when the disk is full
    session.record(True)
    assert [one.name for one in run.sinks] == ["a", "b"]


def test_a_page_knows_its_recordings_from_the_user_s():
    run = Run()
    run.add_sink(List("makeup-20260101-101010.mkv"))  # -o with a name like those of a page
    session = LiveShow(run, PreviewSink(PreviewJpeg()), None, lambda: List("talk.mkv")).enter("")
    for on in (True, False):  # while it runs, and once it is over
        session.record(on)
        sinks = [(sink["by_page"], sink["is_over"]) for sink in session.figures()["sinks"]]
        assert sinks == [(False, False), (True, not on)]


def test_another_machine_starts_no_recording(parts, monkeypatch):
    monkeypatch.setattr("makeup_video.web.app.is_this_machine", lambda scope: False)
    with serving(parts[3]) as url, Page(url) as page:
        answer = page.post("/recording", b"")
        assert answer.status_code == 403 and "machine of the camera" in answer.json()["error"]
        where = f"{url}/camera?session={page.hello['session']}"
        assert httpx.get(where).json() == {"is_owner": False}
        monkeypatch.undo()
        assert "records nothing" in page.post("/recording", b"").json()["error"]


class Cameras:
    chosen = ()

    def choices(self):
        return {
            "names": ["/dev/video0", "/dev/video1"], "name": "video.mp4",
            "sizes": ["640x480"], "size": "1280x720",
        }  # fmt: skip

    def choose(self, name, size):
        self.chosen += ((name, size),)


def test_the_camera_is_chosen_while_nothing_needs_its_size():
    run, cameras = Run(), Cameras()
    session = LiveShow(run, PreviewSink(PreviewJpeg()), None, lambda: List("talk.mkv"), cameras)
    with serving(session) as url, Page(url) as page:
        chosen = {"is_owner": True, **cameras.choices()}
        assert httpx.get(f"{url}/camera?session=live").json() == chosen
        where = "/camera?session=live&name=/dev/video1&size=640x480"
        assert post(url, where, b"").json() == chosen
        page.post("/recording", b"")
        post(url, "/recording?session=live&on=1", b"")
        answer = post(url, where, b"")
        assert answer.json()["error"] == "talk.mkv needs frames of one size: end it first"
        post(url, "/recording?session=live&on=0", b"")
        assert post(url, where, b"").status_code == 200
    assert cameras.chosen == (("/dev/video1", "640x480"),) * 2


@pytest.mark.parametrize(
    ("name", "size"), [("/home/me/private.mp4", "640x480"), ("/dev/video1", "9000x9000"), ("", "")]
)
def test_pages_choose_what_is_offered_and_no_other_file(name, size):
    cameras = Cameras()
    session = LiveShow(Run(), PreviewSink(PreviewJpeg()), None, None, cameras).enter("")
    with pytest.raises(UsageError, match="is not offered: choose one of"):
        session.choose_camera(name, size)
    for own in ("1280x720", ""):  # the present size, and the one that the user asked for
        session.choose_camera("video.mp4", own)
    assert cameras.chosen == (("video.mp4", "1280x720"), ("video.mp4", ""))


def test_a_page_that_changes_the_size_alone_leaves_the_camera():
    cameras = Cameras()
    session = LiveShow(Run(), PreviewSink(PreviewJpeg()), None, None, cameras).enter("")
    session.choose_camera("", "640x480")
    assert cameras.chosen == (("video.mp4", "640x480"),)


def test_all_pages_are_told_that_another_camera_is_used():
    show = LiveShow(Run(), PreviewSink(PreviewJpeg()), None, None, Cameras())
    with serving(show) as url, Page(url) as page, Page(url) as other:
        assert post(url, "/camera?session=live&size=640x480", b"").status_code == 200
        for one in (page, other):
            assert "camera" in {one.message("camera", "figures")["type"] for _ in range(4)}


def test_both_are_the_camera_s_picture_beside_the_painted_one(parts):
    _, _, sink, show = parts
    with filming(sink, picture(before=True, rotation_degrees=90)):
        rgb8 = show.enter("").whole_picture(True).astype(int)
    bare, painted = np.hsplit(rgb8, 2)
    assert np.abs(painted - show.enter("").whole_picture(False)).max() == 0
    assert bare.mean() < 0.6 * painted.mean()  # the test's camera is darker


def test_both_numbers_of_the_same_matrix_look_alike(parts):
    _, _, sink, show = parts
    for matrix in (5, 6):
        shown = picture(matrix=5)
        shown.frame.tags = replace(shown.frame.tags, matrix=matrix)
        sink(shown)
        rgb8 = show.enter("").whole_picture(False)
        assert np.abs(rgb8.astype(int) - clip(1)[0]).mean() < 3
