"""Connections that nobody uses: they are closed beyond a number, and faults are one line."""

import asyncio
import contextlib
import errno
import os
import socket
from urllib.parse import urlsplit

import httpx
import pytest
from makeup_video.web.certificate import load_context, own_certificate
from makeup_video.web.connection import ListeningSocket
from makeup_video.web.server import Server
from makeup_video.web.slow_jobs import SlowJobs
from shows import Page, StandIn, serving

MOST = 8


@pytest.fixture
def few(monkeypatch):
    monkeypatch.setattr(ListeningSocket, "most", MOST)


def idle(url, stack):
    parts = urlsplit(url)
    raw = socket.create_connection((parts.hostname, parts.port), timeout=20)
    return stack.enter_context(raw)


def is_closed(raw):
    with contextlib.suppress(ConnectionResetError):
        return raw.recv(1) == b""
    return True


@pytest.fixture(params=["http", "https"])
def tls(request, tmp_path):
    return (
        load_context(own_certificate("localhost", tmp_path)) if request.param == "https" else None
    )


def test_idle_connections_beyond_a_number_are_closed(few, tls):
    log_lines = []
    with serving(StandIn(), log=log_lines, tls=tls) as url, contextlib.ExitStack() as stack:
        for _ in range(MOST):
            idle(url, stack)
        assert all(is_closed(idle(url, stack)) for _ in range(20))
    assert not log_lines


def test_the_loop_is_one_that_accepts_by_the_listening_socket(monkeypatch):
    """On Windows asyncio prefers another kind of loop, which would bypass the limit."""
    monkeypatch.setattr(asyncio.events, "new_event_loop", lambda: 1 / 0)
    with serving(StandIn()) as url:
        assert httpx.get(url).status_code == 200


def test_a_page_goes_on_beside_idle_connections_and_after(few):
    show = StandIn()
    with serving(show) as url, Page(url) as page:
        with contextlib.ExitStack() as stack:
            raws = [idle(url, stack) for _ in range(MOST)]
            assert is_closed(raws[-1])
            show.show(7)
            assert page.picture()[0] == 7
        with httpx.Client(transport=httpx.HTTPTransport(retries=20)) as client:
            assert client.get(url).status_code == 200


def test_a_fault_of_the_loop_is_logged_once_in_one_line():
    log_lines = []
    server = Server(StandIn(), SlowJobs(), log=log_lines.append)
    full = OSError(errno.EMFILE, os.strerror(errno.EMFILE))
    for _ in range(3):
        server._log_fault(None, {"message": "socket.accept() out of resource", "exception": full})
    server._log_fault(None, {"message": "never retrieved", "exception": ValueError("ours")})
    server._log_fault(None, {"message": "something"})
    no_more, *internal = log_lines
    assert no_more.startswith("the page takes no new connections for now: Too many open files; ")
    assert internal == [
        "internal error of the page's server: never retrieved: ValueError: ours",
        "internal error of the page's server: something",
    ]


def test_the_loop_reports_its_faults_to_the_log():
    log_lines = []
    server = Server(StandIn(), SlowJobs(), log=log_lines.append)
    server.start()
    try:
        server._loop.call_soon_threadsafe(lambda: 1 / 0)
    finally:
        server.stop()
    (line,) = log_lines
    assert "\n" not in line and line.endswith("ZeroDivisionError: division by zero")
