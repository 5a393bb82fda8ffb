"""The answers of the server's addresses."""

import json
import threading
import time
import urllib.error
import urllib.request
from concurrent.futures import ThreadPoolExecutor

import cv2
import httpx
import numpy as np
import pytest
from makeup_video.pipeline.look.ready import ready_looks
from makeup_video.web.app import PAGE
from makeup_video.web.slow_jobs import SlowJobs
from shows import Page, StandIn, get, post, serving


@pytest.fixture
def show():
    return StandIn()


@pytest.fixture
def url(show):
    with serving(show) as url:
        yield url


@pytest.fixture(scope="module")
def same_url():
    """The page's address for tests that change nothing: they share a server, which saves time."""
    with serving(StandIn()) as url:
        yield url


@pytest.mark.parametrize("name", sorted(path.name for path in PAGE.iterdir()))
def test_every_file_of_the_page_is_there_by_its_name(same_url, name):
    answer = get(f"{same_url}/static/{name}")
    assert answer.status_code == 200 and answer.content == (PAGE / name).read_bytes()
    assert answer.headers["content-type"] != "application/octet-stream"


def test_the_page_is_at_the_root(same_url):
    answer = get(same_url + "/")
    assert answer.content == (PAGE / "index.html").read_bytes()
    assert answer.headers["content-type"].startswith("text/html")


@pytest.mark.parametrize(
    "path",
    [
        "/static/..%2fguard.py", "/static/..%2F..%2Fpyproject.toml", "/static/%2e%2e%2fguard.py",
        "/static/..\\guard.py", "/static/", "/static", "/static/.", "/static/..", "/static/%00",
        "/static//etc/passwd", "/static/index.html/", "/guard.py", "/index.html", "/photo/", "//",
    ],
)  # fmt: skip
def test_nothing_else_is_there(same_url, path):
    with pytest.raises(urllib.error.HTTPError) as caught:  # httpx would normalise the path
        urllib.request.urlopen(same_url + path)
    assert caught.value.code == 404 and b"error" in caught.value.read()


@pytest.mark.parametrize(
    ("method", "path"),
    [
        ("POST", "/"), ("PUT", "/photo"), ("GET", "/photo"), ("DELETE", "/picture.png"),
        ("POST", "/static/index.html"),
    ],
)  # fmt: skip
def test_other_methods_are_refused(same_url, method, path):
    answer = httpx.request(method, same_url + path, headers={"origin": same_url})
    assert answer.status_code == 405 and "error" in answer.json()


def test_the_whole_picture_is_a_png_to_download(show, url):
    show.picture = np.random.default_rng(1).integers(0, 256, (40, 30, 3), np.uint8)
    with Page(url):
        answer = get(f"{url}/picture.png?session=stand-in")
    assert answer.headers["content-type"] == "image/png"
    assert answer.headers["content-disposition"].startswith("attachment")
    stored = cv2.imdecode(np.frombuffer(answer.content, np.uint8), cv2.IMREAD_COLOR)
    np.testing.assert_array_equal(stored[..., ::-1], show.picture)


@pytest.mark.parametrize("query", ["", "&both"])
def test_without_a_picture_there_is_nothing_to_download(url, query):
    with Page(url):
        address = f"{url}/picture.png?session=stand-in{query}"
        answer, head = get(address), httpx.head(address)
    assert answer.status_code == 404 and answer.json() == {"error": "there is no picture yet"}
    assert head.status_code == 404 and not head.content


@pytest.mark.parametrize(
    ("session", "code", "advice"),
    [
        ("", 404, "reload the page"),
        ("unknown", 404, "reload the page"),
        ("stand-in", 503, "try again"),  # its page lost the connection, and reconnects by itself
    ],
)
def test_a_session_that_no_page_watches_is_reported(url, session, code, advice):
    answers = [
        post(url, f"/photo?session={session}", b"x"),
        post(url, f"/portrait?session={session}", b"x"),
        get(f"{url}/picture.png?session={session}"),
        post(url, f"/look-thumbnail?session={session}", b"{}"),
        get(f"{url}/photo-thumbnail?session={session}"),
        get(f"{url}/portrait-thumbnail?session={session}"),
        post(url, f"/shades?session={session}", b"x"),
    ]
    for answer in answers:
        assert answer.status_code == code and advice in answer.json()["error"]


def test_ready_looks_are_listed_and_painted(show, url):
    show.thumbnail_of = lambda look: json.dumps(look.to_dict()).encode()
    listed = get(f"{url}/looks").json()
    assert [one["name"] for one in listed] == [one.name for one in ready_looks()]
    with Page(url) as page:
        for one in listed:
            answer = page.post("/look-thumbnail", json.dumps(one["look"]))
            assert answer.headers["content-type"] == "image/jpeg"
            assert answer.json() == one["look"] and one["words"]


@pytest.mark.parametrize("body", [b"", b"\xff", b"[]", b'{"version": 2, "layers": 3}', b"{" * 9999])
def test_a_thumbnail_of_no_look_is_refused_in_one_line(url, body):
    with Page(url) as page:
        answer = page.post("/look-thumbnail", body)
    assert answer.status_code == 400 and "\n" not in answer.json()["error"]


def test_a_thumbnail_of_too_large_a_look_is_refused(url):
    with Page(url) as page:
        answer = page.post("/look-thumbnail", b" " * 70_000)
    assert answer.status_code == 413 and answer.json()["error"] == (
        "the look is larger than 66 kB: make it smaller"
    )


def test_thumbnails_of_photo_and_portrait_are_served(show, url):
    with Page(url) as page:
        first = get(f"{url}/photo-thumbnail?session=stand-in")
        assert (first.status_code, first.json()) == (404, {"error": "no photo has been read yet"})
        page.post("/photo", b"x", x_file_name="anna.jpg")
        assert get(f"{url}/photo-thumbnail?session=stand-in").content == b"a thumbnail"
        answer = get(f"{url}/portrait-thumbnail?session=stand-in")
    assert (answer.content, answer.headers["content-type"]) == (b"a portrait", "image/jpeg")


def test_before_and_after_are_saved_side_by_side(show, url):
    show.picture = np.random.default_rng(1).integers(0, 256, (40, 30, 3), np.uint8)
    with Page(url):
        answer = get(f"{url}/picture.png?session=stand-in&both")
    stored = cv2.imdecode(np.frombuffer(answer.content, np.uint8), cv2.IMREAD_COLOR)[..., ::-1]
    np.testing.assert_array_equal(stored, np.hstack([show.picture // 2, show.picture]))


def test_one_thumbnail_at_a_time_waits_for_slow_jobs(show):
    begun, go_on = threading.Event(), threading.Event()

    def slow(look):
        begun.set()
        assert go_on.wait(20)
        return b"a face"

    show.thumbnail_of, slow_jobs = slow, SlowJobs()
    looks = [json.dumps(one.look.to_dict()) for one in ready_looks()]
    with (
        serving(show, slow_jobs) as url,
        Page(url) as page,
        ThreadPoolExecutor(len(looks)) as asking,
    ):
        answers = [asking.submit(page.post, "/look-thumbnail", look) for look in looks]
        assert begun.wait(20)
        time.sleep(0.2)  # for all requests to arrive
        painted = slow_jobs.submit(lambda: sum(answer.done() for answer in answers))
        go_on.set()
        assert painted.result(20) <= 1  # a picture comes right after the thumbnail in work
        assert all(answer.result(20).status_code == 200 for answer in answers)


def test_a_portrait_goes_to_the_session_with_its_name(show, url):
    with Page(url) as page:
        assert page.post("/portrait", b"x").status_code == 200
    assert show.portraits == [(b"x", "the photo")]


def test_a_bug_of_ours_is_one_line_on_page_and_terminal(show):
    def fails(photo, name):
        raise ZeroDivisionError("ours")

    show.reads, log_lines = fails, []
    with serving(show, log=log_lines) as url, Page(url) as page:
        answer = page.post("/photo", b"x")
        assert answer.status_code == 500 and "\n" not in answer.json()["error"]
        assert page.post("/photo", b"x").status_code == 500  # the server goes on
    assert log_lines[0] == "internal error at /photo: ZeroDivisionError: ours"
