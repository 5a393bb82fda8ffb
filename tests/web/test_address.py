"""The address at which the server listens, and the address that it shows."""

import socket

import httpx
import pytest
from makeup_video.pipeline import UsageError
from makeup_video.web.same_origin import is_name
from makeup_video.web.server import Server
from makeup_video.web.slow_jobs import SlowJobs
from shows import StandIn


def started(host):
    server = Server(StandIn(), SlowJobs(), host, log=print)
    try:
        return server.start(), server
    finally:
        server.stop()


@pytest.mark.parametrize(
    ("host", "shown", "address"),
    [
        ("127.0.0.1", "127.0.0.1", "127.0.0.1"),
        ("127.1", "127.0.0.1", "127.0.0.1"),
        ("0", "127.0.0.1", "0.0.0.0"),
        ("0.0.0.0", "127.0.0.1", "0.0.0.0"),
        ("LOCALHOST", "LOCALHOST", "127.0.0.1"),
    ],
)
def test_the_page_s_address_is_one_that_a_browser_opens(host, shown, address):
    url, server = started(host)
    assert url.startswith(f"http://{shown}:") and server.address == address


def test_a_host_that_is_no_name_is_shown_as_its_address(monkeypatch):
    everywhere = (socket.AF_INET, socket.SOCK_STREAM, 6, "", ("127.0.0.1", 0))
    monkeypatch.setattr(socket, "getaddrinfo", lambda *_, **__: [everywhere])
    assert started("*")[0].startswith("http://127.0.0.1:")


def test_a_name_may_end_in_a_dot_as_in_dns():
    server = Server(StandIn(), SlowJobs(), "localhost.", log=print)
    url = server.start()
    try:
        port = url.rsplit(":", 1)[1].rstrip("/")
        for name in ("localhost", "localhost.", "127.0.0.1"):
            answer = httpx.get(
                f"http://{server.address}:{port}/", headers={"host": f"{name}:{port}"}
            )
            assert answer.status_code == 200
    finally:
        server.stop()


@pytest.mark.parametrize("host", ["255.255.255.255", "224.0.0.1"])
def test_an_address_of_no_single_machine_is_refused(host):
    with pytest.raises(UsageError, match=rf"host='{host}' is not an address of this machine"):
        started(host)


@pytest.mark.parametrize(
    ("host", "named"),
    [("pc", True), ("pc.local", True), ("3com.example.", True), ("PC-7.local", True),
     ("127.1", False), ("0", False), ("*", False), ("::1", False), ("", False), ("a b", False)],
)  # fmt: skip
def test_names_are_told_from_addresses(host, named):
    assert is_name(host) is named
