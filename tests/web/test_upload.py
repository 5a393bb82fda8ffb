"""Photos that pages upload: their limits, their formats and their names."""

import asyncio
import os
import queue
import struct
import sys
import threading
import time
import zlib

import cv2
import httpx
import pytest
from makeup_video.pipeline import Layer, Look, PhotoError, look_from_photo
from makeup_video.pipeline.reference import estimate as reference
from makeup_video.web import upload
from makeup_video.web.read_look import read_look
from makeup_video.web.session import PHOTO_BYTES
from makeup_video.web.slow_jobs import SlowJobs
from people import SAMPLES, grey
from shows import BLUE, RED, Page, StandIn, as_read, noise, serving
from starlette.exceptions import HTTPException
from starlette.requests import Request

LOOK = SAMPLES / "look.jpg"


@pytest.fixture
def show():
    return StandIn()


@pytest.fixture
def page(show):
    with serving(show) as url, Page(url) as page:
        yield page


def test_a_photo_changes_the_look_of_all_pages_in_words_too(show, page):
    with Page(page.url) as other:
        answer = page.post("/photo", b"bytes", x_file_name="anna.jpg")
        words = as_read(BLUE).in_words()
        assert words.startswith("lips #1400C8, glossy, opaque (almost certain); eyes bare (likely)")
        assert answer.status_code == 200
        assert answer.json() == {"name": "anna.jpg", "look": BLUE.to_dict(), "words": words}
        for viewer in (page, other):
            got = viewer.message("look")
            photo = {"name": "anna.jpg", "look": BLUE.to_dict(), "words": words}
            assert (got["look"], got["photo"]) == (BLUE.to_dict(), photo)
    assert show.look == BLUE and show.photos == [(b"bytes", "anna.jpg")]


def test_a_page_that_reconnects_gets_the_look_of_its_photo(show):
    reading, go_on = threading.Event(), threading.Event()

    def read(photo, name):
        reading.set()
        go_on.wait(20)
        return BLUE

    show.reads = read
    with serving(show) as url:
        with Page(url) as page:
            posting = threading.Thread(target=page.post, args=("/photo", b"bytes"))
            posting.start()
            assert reading.wait(20)
        until = time.monotonic() + 20
        while show.watched.is_set():
            assert time.monotonic() < until
            time.sleep(0.005)
        with Page(url) as again:
            go_on.set()
            assert again.message("look")["look"] == BLUE.to_dict()
        posting.join(20)


def test_the_strength_stays_as_the_user_has_set_it(show, page):
    show.look = Look([Layer("lipstick", RED.lips, {"gradient": 0.6}, 0.25)], 0.5)
    page.post("/photo", b"bytes")
    assert show.look == Look(BLUE.layers, 0.5)


def test_a_photo_as_large_as_allowed_comes_through_whole(show, page):
    data = noise(PHOTO_BYTES)
    assert page.post("/photo", data).status_code == 200
    assert show.photos[0][0] == data


def test_a_photo_one_byte_too_large_is_refused(show, page):
    answer = page.post("/photo", bytes(PHOTO_BYTES + 1), x_file_name="large.jpg")
    assert answer.status_code == 413
    assert answer.json()["error"] == "large.jpg is larger than 64 MB: make it smaller"
    assert not show.photos


def test_a_photo_without_a_declared_size_is_limited_too(show, page):
    answer = page.post("/photo", (bytes(1_000_000) for _ in range(80)))  # sent in chunks
    assert answer.status_code == 413 and not show.photos


@pytest.mark.parametrize(
    ("sent", "known"),
    [
        ("look%20of%20Anna.jpg", "look of Anna.jpg"),
        ("%C3%A4rger.png", "ärger.png"),
        ("..%2F..%2Fetc%2Fpasswd", "passwd"),
        ("C%3A%5Cphotos%5Cme.jpg", "me.jpg"),
        ("a%0D%0ASet-Cookie%3A%20x%1B%5B31m.jpg", "aSet-Cookie: x[31m.jpg"),
        ("%E2%80%AEgpj.exe", "gpj.exe"),
        ("%FF%FE", "\ufffd\ufffd"),
        ("", "the photo"),
        ("%2F", "the photo"),
    ],
)
def test_a_photo_keeps_the_visitors_name_for_it(show, page, sent, known):
    page.post("/photo", b"x", x_file_name=sent)
    assert show.photos[0][1] == known


def test_a_long_name_is_shortened(show, page):
    page.post("/photo", b"x", x_file_name="a" * 4000 + ".jpg")
    name = show.photos[0][1]
    assert len(name) == 80 and name.endswith("a.jpg")


def test_the_page_that_asked_gets_the_reason_of_a_refusal(show, page):
    def refuses(photo, name):
        raise PhotoError(f"{name}: no face was found")

    show.reads = refuses
    answer = page.post("/photo", b"x", x_file_name="cat.jpg")
    assert (answer.status_code, answer.json()) == (422, {"error": "cat.jpg: no face was found"})
    assert show.look == RED


def test_a_photo_that_stalls_on_its_way_is_let_go(show, page, monkeypatch):
    monkeypatch.setattr(upload, "_SILENT_SECONDS", 0.1)

    def stalling():
        yield b"begun"
        time.sleep(1)
        yield b"ended"

    answer = page.post("/photo", stalling())
    assert (answer.status_code, show.photos) == (408, [])
    assert answer.json() == {"error": "the upload was too slow: try again"}
    assert page.post("/photo", b"another").status_code == 200


def test_a_third_photo_at_once_is_busy_and_pictures_go_on(show, page):
    go_on, answers = threading.Event(), queue.Queue()

    def slow(photo, name):
        assert go_on.wait(20)
        return BLUE

    show.reads = slow
    threads = [
        threading.Thread(target=lambda: answers.put(page.post("/photo", b"x"))) for _ in range(3)
    ]
    for thread in threads:
        thread.start()
    busy = answers.get(timeout=10)  # the other two wait
    assert busy.status_code == 503 and "try again" in busy.json()["error"]
    show.show(1)
    assert page.picture()[0] == 1
    go_on.set()
    assert [answers.get(timeout=20).status_code for _ in range(2)] == [200, 200]
    assert page.post("/photo", b"x").status_code == 200


def test_photos_that_a_page_gives_up_leave_room_and_no_look(show, page):
    """The newest photo wins: those before it are not painted, and do not keep it waiting."""
    begun, go_on, read_names = queue.Queue(), threading.Event(), []

    def slow(photo, name):
        read_names.append(name)
        begun.put(name)
        assert go_on.wait(20)
        return BLUE

    show.reads = slow

    def give_up(name):
        with pytest.raises(httpx.ReadTimeout):
            page.post("/photo", b"x", timeout_s=0.3, x_file_name=name)

    give_up("read.jpg")
    assert begun.get(timeout=20) == "read.jpg"
    give_up("waits.jpg")
    give_up("waits too.jpg")
    answer = queue.Queue()
    newest = threading.Thread(
        target=lambda: answer.put(page.post("/photo", b"x", x_file_name="newest.jpg"))
    )
    newest.start()
    time.sleep(0.3)  # its request arrives behind the others
    assert show.look == RED
    go_on.set()
    assert answer.get(timeout=20).status_code == 200
    assert read_names == ["read.jpg", "newest.jpg"]
    assert page.message("look")["photo"]["name"] == "newest.jpg"


def test_a_job_left_out_is_never_done_without_its_body():
    jobs, go_on, seen = SlowJobs(), threading.Event(), []
    jobs.submit(lambda: go_on.wait(20))
    messages = [{"type": "http.disconnect"}, {"type": "http.request", "body": b"photo"}]

    async def receive():
        return messages.pop()

    async def give_up():
        request = Request({"type": "http", "headers": []}, receive)
        with pytest.raises(HTTPException, match="given up"):
            await upload.Uploads(jobs).run(request, seen.append)
        go_on.set()  # on the same turn of the loop
        jobs.submit(lambda: None).result(20)

    asyncio.run(give_up())
    assert seen == []


# -- content


def test_the_look_of_a_real_photo_is_read_from_its_bytes():
    assert read_look(LOOK.read_bytes(), "look.jpg").look == look_from_photo(LOOK)


def test_a_bare_face_is_refused_as_the_command_does(monkeypatch):
    monkeypatch.setattr(reference, "estimate", lambda *_: as_read(Look()))
    with pytest.raises(PhotoError, match=r"^me.jpg: nothing is worn, or too little to see"):
        read_look(LOOK.read_bytes(), "me.jpg")


def test_a_photo_without_a_face_is_refused_by_its_own_name():
    wall = cv2.imencode(".png", grey())[1].tobytes()
    with pytest.raises(PhotoError, match=r"^wall.png: no face was found"):
        read_look(wall, "wall.png")


def png_of(width, height):
    """A PNG that declares a size but holds almost no data."""
    head = struct.pack(">IIBBBBB", width, height, 8, 2, 0, 0, 0)
    chunks = [(b"IHDR", head), (b"IDAT", zlib.compress(bytes(100_000))), (b"IEND", b"")]
    return b"\x89PNG\r\n\x1a\n" + b"".join(
        struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))
        for name, data in chunks
    )


@pytest.mark.parametrize(
    ("photo", "words"),
    [
        (b"", "x.jpg is empty (0 bytes): give a photo file"),
        (png_of(50_000, 50_000), "x.jpg has 50000 x 50000 px, more than 52 million px: make it"),
        (png_of(7_212, 7_211), "x.jpg has 7212 x 7211 px, more than 52 million px: make it"),
        (png_of(600, 500), "x.jpg is damaged or cut short"),
        (b"%PDF-1.7 and more", "x.jpg is no photo that can be read: give a JPEG, PNG, WebP"),
        (b"<svg xmlns='http://www.w3.org/2000/svg'/>", "x.jpg is no photo that can be read"),
        (b"%!PS-Adobe-3.0 EPSF-3.0\n%%BoundingBox: 0 0 9 9\n", "x.jpg is no photo that can be"),
        (b"\0\0\0\x18ftypheic" + bytes(80), "x.jpg is damaged or cut short"),
        (b"\0\0\0\x18ftypisom" + bytes(80), "x.jpg is a video, and a photo is needed: "),
        (LOOK.read_bytes()[:20_000], "x.jpg is damaged or cut short: save the photo again"),
        (noise(3_000_000), "x.jpg is no photo that can be read"),
    ],
)  # fmt: skip
def test_anything_but_a_photo_is_refused_and_the_look_stays(show, page, photo, words):
    show.reads = read_look
    answer = page.post("/photo", photo, x_file_name="x.jpg")
    assert answer.status_code == 422 and answer.json()["error"].startswith(words)
    assert "\n" not in answer.json()["error"] and show.look == RED


written: list[str] | None = None


def note_writing(event, args):
    if written is not None and event == "open":
        path, mode, flags = args
        if path == os.devnull or isinstance(path, int):  # pipes of the decoding process
            return
        if "kcache" in str(path):  # the check for room for kernels, once per process
            return
        if set(str(mode or "")) & set("wax+") or flags & (os.O_WRONLY | os.O_RDWR | os.O_CREAT):
            written.append(str(path))


def test_nothing_of_a_photo_is_written_to_disk(show, page, monkeypatch):
    sys.addaudithook(note_writing)
    monkeypatch.setattr(sys.modules[__name__], "written", [])
    show.reads = read_look
    large = cv2.imencode(".png", cv2.imread(str(LOOK)))[1].tobytes()  # a form would go to the disk
    assert len(large) > 1_500_000
    assert page.post("/photo", large).status_code == 200
    assert page.post("/photo", noise(3_000_000)).status_code == 422
    assert not written


@pytest.mark.parametrize(("declared", "parts"), [(None, 6), ("1e2", 6), ("99", 6)])
def test_a_body_without_end_is_not_read_to_its_end(monkeypatch, declared, parts):
    monkeypatch.setattr(upload, "_THROWN_AWAY", 5000)
    read = []

    async def receive():
        read.append(1000)
        return {"type": "http.request", "body": bytes(1000), "more_body": len(read) < 50}

    headers = [] if declared is None else [(b"content-length", declared.encode())]
    request = Request({"type": "http", "method": "POST", "headers": headers}, receive)
    with pytest.raises(HTTPException, match="413"):
        asyncio.run(upload.read_body(request, 100, "the look"))
    assert len(read) == parts
