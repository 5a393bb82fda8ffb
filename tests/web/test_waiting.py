"""Downloads that pages give up: they neither wait nor keep others waiting."""

import queue
import socket
import threading
from urllib.parse import urlsplit

import httpx
import numpy as np
import pytest
from makeup_video.web.slow_jobs import SlowJobs
from shows import Page, StandIn, post, serving


class Slow(StandIn):
    """A session whose downloads wait until they may go on."""

    def __init__(self):
        super().__init__()
        self.begun, self.go_on, self.made = queue.Queue(), threading.Event(), []

    def _make(self, what):
        self.made.append(what)
        self.begun.put(what)
        assert self.go_on.wait(20)

    has_picture = True

    def whole_picture(self, both):
        self._make("picture")
        return np.zeros((2, 2, 3), np.uint8)

    def portrait_thumbnail(self):
        self._make("portrait")
        return b"a portrait"

    def cameras(self):
        self._make("cameras")
        return {}


@pytest.mark.parametrize("path", ["/picture.png", "/portrait-thumbnail", "/camera"])
def test_downloads_that_a_page_gives_up_are_left_out(path):
    show, slow_jobs = Slow(), SlowJobs()
    with serving(show, slow_jobs) as url, Page(url):
        parts = urlsplit(url)
        for _ in range(20):
            with socket.create_connection((parts.hostname, parts.port), timeout=20) as raw:
                request = f"GET {path}?session=stand-in HTTP/1.1\r\nHost: {parts.netloc}\r\n\r\n"
                raw.sendall(request.encode())
                if not show.made:
                    show.begun.get(timeout=20)
        # the server, on its one loop, answers these after it has read the requests above
        answers = [queue.Queue() for _ in range(2)]
        for answer in answers:
            threading.Thread(
                target=lambda answer=answer: answer.put(
                    httpx.get(f"{url}/portrait-thumbnail?session=stand-in", timeout=20)
                )
            ).start()
        httpx.get(url)
        show.go_on.set()
        assert all(answer.get(timeout=20).content == b"a portrait" for answer in answers)
        assert post(url, "/photo?session=stand-in", b"x").status_code == 200
    # the one in work, and perhaps one whose end the server saw only after the next one's turn
    assert len(show.made) <= 2 + len(answers)


def test_a_head_of_the_picture_is_answered_without_a_picture():
    show = Slow()
    with serving(show) as url, Page(url):
        answer = httpx.head(f"{url}/picture.png?session=stand-in")
    assert answer.status_code == 200 and answer.headers["content-type"] == "image/png"
    assert "content-length" not in answer.headers and not show.made


@pytest.mark.parametrize("path", ["/picture.png", "/portrait-thumbnail", "/camera"])
def test_a_download_that_a_stop_cuts_off_is_answered_with_503(path):
    show, answer = Slow(), queue.Queue()
    with serving(show, SlowJobs()) as url, Page(url):
        ask = f"{url}{path}?session=stand-in"
        threading.Thread(target=lambda: answer.put(httpx.get(ask, timeout=20))).start()
        show.begun.get(timeout=20)
    cut_off = answer.get(timeout=20)
    show.go_on.set()
    assert cut_off.status_code == 503 and "is stopping" in cut_off.json()["error"]
