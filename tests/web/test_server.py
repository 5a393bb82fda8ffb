"""The server from a page's view: pictures, looks, slow pages, bad messages, start and stop."""

import contextlib
import json
import socket
import threading
import time
from unittest.mock import Mock

import httpx
import pytest
from makeup_video.pipeline import InstallError, UsageError
from makeup_video.web.rooms import MOST_VIEWERS
from makeup_video.web.server import Server
from makeup_video.web.slow_jobs import SlowJobs
from shows import BLUE, RED, Page, StandIn, noise, serving, stalled
from websockets.exceptions import ConnectionClosed


@pytest.fixture
def show():
    return StandIn()


@pytest.fixture
def url(show):
    with serving(show) as url:
        yield url


def until(holds):
    end = time.monotonic() + 20
    while not holds():
        assert time.monotonic() < end
        time.sleep(0.005)


# -- pictures


def test_a_picture_arrives_with_its_time_and_turn(show, url):
    with Page(url) as page:
        show.show(7)
        assert page.picture() == (7, 90, b"painted", b"")


def test_two_pages_see_every_picture_and_one_compares(show, url):
    with Page(url) as page, Page(url) as other:
        other.send("compare", on=True)
        until(lambda: show.compares)
        for pts_us in range(1, 20):
            show.show(pts_us)
            assert page.picture() == (pts_us, 90, b"painted", b"")
            assert other.picture() == (pts_us, 90, b"painted", b"bare")
        other.send("compare", on=False)
        until(lambda: not show.compares)


def test_before_is_made_until_the_last_comparing_page_leaves(show, url):
    with Page(url):
        with Page(url) as other:
            other.send("compare", on=True)
            until(lambda: show.compares)
        until(lambda: not show.compares)


def test_pictures_are_made_only_while_somebody_watches(show, url):
    assert not show.watched.is_set()
    with Page(url):
        assert show.watched.wait(10)
    until(lambda: not show.watched.is_set())


def test_a_page_that_joins_later_sees_the_newest_picture(show, url):
    with Page(url) as page:
        show.show(5)
        page.picture()
        with Page(url) as other:
            assert other.picture()[0] == 5


def test_at_most_two_pictures_are_in_flight_then_the_newest(show, url):
    with Page(url) as page, Page(url) as quick:
        for pts_us in range(1, 10):
            show.show(pts_us)
            assert quick.picture()[0] == pts_us  # so the server has sent every picture
        assert [page.picture(shown=False)[0] for _ in range(2)] == [1, 2]
        page.send("shown", pts_us=2)  # the page never shows 1
        assert page.picture(shown=False)[0] == 9


@pytest.mark.parametrize("pts_us", [3, 0, 2**62])
def test_what_was_never_sent_cannot_be_shown(show, url, pts_us):
    with Page(url) as page, Page(url) as quick:
        for sent_us in (1, 2, 4):
            show.show(sent_us)
            assert quick.picture()[0] == sent_us
        page.send("shown", pts_us=pts_us)
        page.send("look", look=BLUE.to_dict())  # read after "shown", and passed on to `quick`
        quick.message("look")
        assert [page.picture(shown=False)[0] for _ in range(2)] == [1, 2]
        page.send("shown", pts_us=1)
        assert page.picture(shown=False)[0] == 4


def test_a_page_that_never_reads_delays_nobody(show, url):
    with stalled(url), Page(url) as page:
        for pts_us in range(1, 60):
            show.show(pts_us, noise(1_000_000))
            assert page.picture()[0] == pts_us


def test_a_page_that_never_reads_is_disconnected(show):
    show.latest_figures = {}
    with serving(show, ping_seconds=1) as url, Page(url) as page, stalled(url):
        while page.message("figures")["viewers"] != 2:
            pass
        show.show(1, noise(8_000_000))  # more than the kernel buffers
        while page.message("figures")["viewers"] != 1:
            pass


def test_a_page_that_pings_and_never_reads_is_disconnected(url, monkeypatch):
    monkeypatch.setattr("makeup_video.web.connection._MOST_BYTES", 2_000_000)  # read in a second
    ping = b"\x89\xfd\0\0\0\0" + bytes(125)
    with stalled(url) as pinging, pytest.raises(OSError):
        pinging.sendall(ping * 100_000)  # 12 MB of answers


# -- looks


def test_a_change_reaches_other_pages_and_does_not_come_back(show, url):
    with Page(url) as page, Page(url) as other:
        for red in range(10):
            look = RED.to_dict()
            look["layers"][0]["product"]["red"] = red
            page.send("look", look=look, n=red)
            got = other.message("look")
            assert got["look"] == look and got["photo"] is None and got["seen"] is None
        page.send("nothing")
        page.message("error")  # by now the server has handled all looks
        other.send("look", look=BLUE.to_dict(), n=0)
        got = page.message("look")
        assert got["look"] == BLUE.to_dict() and got["seen"] == 9
    assert show.look == BLUE


def test_a_look_without_a_count_returns_as_it_was_understood(show, url):
    short = RED.to_dict()
    del short["strength"], short["layers"][0]["shape"], short["layers"][0]["product"]["shimmer"]
    with Page(url) as page:
        page.send("look", look=short)
        assert page.message("look")["look"] == RED.to_dict()


def test_a_look_of_version_1_returns_as_one_of_version_2(show, url):
    (lips,) = RED.to_dict()["layers"]
    old = {"version": 1, "lips": lips["product"], "eyes": lips["product"], "zone": "crease"}
    with Page(url) as page:
        page.send("look", look={**old, "intensity": 0.5})
        look = page.message("look")["look"]
    assert look == show.look.to_dict() and look["version"] == 2
    shadow, lipstick = look["layers"]
    assert lipstick == lips
    assert (shadow["shape"], shadow["strength"]) == ({"slot": "crease"}, 0.5)


def test_a_refused_layer_is_named_in_one_line(show, url):
    look = RED.to_dict()
    look["layers"][0]["shape"] = {"gradient": 3}
    with Page(url) as page:
        page.send("look", look=look)
        text = page.message("error")["text"]
    assert text == "layers[0].shape.gradient must be a number in 0..1, got 3"


def test_a_refused_look_is_answered_with_the_current_one(show, url):
    with Page(url) as page:
        page.send("look", look={**RED.to_dict(), "strength": 7})
        replies = [page.message("error", "look") for _ in range(2)]
    reply_of = {reply["type"]: reply for reply in replies}
    assert reply_of["error"]["text"] == "strength must be a number in 0..1, got 7"
    assert reply_of["look"]["look"] == RED.to_dict() and show.look == RED


# -- figures


def test_figures_come_with_the_delay_to_the_screen(show, url):
    show.latest_figures = {"fps": 29.9, "notice": None}
    with Page(url) as page:
        assert page.message("figures") == {
            "type": "figures", "fps": 29.9, "notice": None, "viewers": 1, "screen_ms": None,
        }  # fmt: skip
        show.show(time.monotonic_ns() // 1000 - 50_000)
        page.picture()
        while (late := page.message("figures")["screen_ms"]) is None:
            pass
        assert 50 <= late < 20_000


# -- bad pages


@pytest.mark.parametrize(
    "message", ["{", "[" * 60_000, b"\0\xff", "", '{"type": "look", "look": NaN}']
)
def test_garbage_is_answered_with_one_line_and_pictures_go_on(show, url, message):
    with Page(url) as page:
        page.socket.send(message)
        assert "\n" not in page.message("error")["text"]
        show.show(3)
        assert page.picture()[0] == 3


def test_a_huge_message_ends_that_page_alone(show, url):
    with Page(url) as page, Page(url) as other:
        with pytest.raises(ConnectionClosed):
            page.socket.send(json.dumps({"type": "look", "look": "x" * 100_000}))
            page.message("nothing")
        show.show(3)
        assert other.picture()[0] == 3


def test_a_thousand_bad_messages_cost_a_few_answers(show, url):
    with Page(url) as page:
        for _ in range(1000):
            page.socket.send("{")
        page.send("shown", pts_us=1)
        show.show(9)
        assert page.picture()[0] == 9


def test_one_page_too_many_is_refused_with_the_reason(url):
    with contextlib.ExitStack() as stack:
        pages = [stack.enter_context(Page(url)) for _ in range(MOST_VIEWERS)]
        with Page(url) as one_more:
            assert f"{MOST_VIEWERS} pages are open already" in one_more.hello["text"]
        pages[0].close()
        until(lambda: comes_in(url))


def comes_in(url):
    with Page(url) as page:
        return page.hello["type"] == "hello"


# -- start and end


def test_a_port_that_is_taken_is_one_line_that_names_it():
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        with pytest.raises(
            UsageError, match=rf"port {port} on 127.0.0.1 is taken: give another port, or port=0 "
        ):
            Server(StandIn(), SlowJobs(), port=port, log=print).start()


@pytest.mark.parametrize("error", [ImportError("no websockets"), OSError("too many files")])
def test_a_server_that_cannot_begin_says_why(monkeypatch, error):
    monkeypatch.setattr("uvicorn.Config.load", Mock(side_effect=error))
    with pytest.raises((InstallError, OSError), match=str(error)):
        Server(StandIn(), SlowJobs(), log=print).start()


@pytest.mark.parametrize(
    ("host", "port", "words"),
    [
        ("no-such-name.invalid", 0, "host=.no-such-name.invalid. is not an address"),
        ("203.0.113.9", 0, "host=.203.0.113.9. is not an address"),
        ("", 70000, "port"),
        ("127.0.0.1", -1, "port"),
        ("x" * 300, 0, "not an address"),
    ],
)
def test_an_address_that_cannot_be_bound_is_one_line(host, port, words):
    with pytest.raises(UsageError, match=words):
        Server(StandIn(), SlowJobs(), host, port, log=print).start()


def test_the_server_listens_on_loopback_alone(url):
    assert url.startswith("http://127.0.0.1:")


def test_every_page_gets_bye_and_the_thread_ends():
    server = Server(StandIn(), SlowJobs(), log=print)
    with contextlib.ExitStack() as stack:
        url = server.start().rstrip("/")
        pages = [stack.enter_context(Page(url)) for _ in range(3)]
        server.stop()
        assert all(page.message("bye") for page in pages)
    assert not [thread for thread in threading.enumerate() if thread.name == "web server"]


def test_the_server_stops_though_a_page_never_reads():
    show = StandIn()
    server = Server(show, SlowJobs(), log=print)
    url = server.start().rstrip("/")
    with stalled(url):
        show.show(1, noise(8_000_000))
        server.stop()
        assert not [thread for thread in threading.enumerate() if thread.name == "web server"]


def test_the_server_stops_though_a_photo_is_being_read():
    show, begun, go_on, log_lines = StandIn(), threading.Event(), threading.Event(), []

    def slow(photo, name):
        begun.set()
        assert go_on.wait(20)
        return BLUE

    show.reads = slow
    server = Server(show, SlowJobs(), log=log_lines.append)
    with Page(server.start().rstrip("/")) as page:
        sender = threading.Thread(target=send_in_vain, args=(page,))
        sender.start()
        assert begun.wait(10)
        server.stop()
        assert not [thread for thread in threading.enumerate() if thread.name == "web server"]
    go_on.set()
    sender.join(20)
    assert not log_lines and show.look == RED


def send_in_vain(page):
    with contextlib.suppress(httpx.TransportError):
        page.post("/photo", b"x")


def test_stopping_twice_or_before_the_start_is_harmless():
    Server(StandIn(), SlowJobs(), log=print).stop()
    server = Server(StandIn(), SlowJobs(), log=print)
    server.start()
    server.stop()
    server.stop()


def test_pictures_that_come_after_the_end_are_nobodys():
    show = StandIn()
    server = Server(show, SlowJobs(), log=print)
    with Page(server.start().rstrip("/")):
        assert show.watched.wait(10)
        push = show.push
        server.stop()
    show.push = push
    show.watched.set()
    show.show(1)
