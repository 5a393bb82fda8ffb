"""Requests from other sites or with foreign host names are refused on every address."""

import asyncio
import re
import socket
from urllib.parse import urlsplit

import httpx
import pytest
from makeup_video.web.app import make_app
from makeup_video.web.rooms import Rooms
from makeup_video.web.same_origin import is_loopback, is_this_machine
from makeup_video.web.slow_jobs import SlowJobs
from shows import StandIn, serving
from websockets.exceptions import InvalidStatus
from websockets.sync.client import connect

HERE = "http://127.0.0.1:8080"


def ask(method, path, headers, host="127.0.0.1"):
    app = make_app(Rooms(StandIn()), SlowJobs(), host, 8080, print)

    async def asking():
        async with httpx.AsyncClient(transport=httpx.ASGITransport(app), base_url=HERE) as client:
            return await client.request(method, path, headers=headers)

    return asyncio.run(asking())


@pytest.mark.parametrize(
    "host",
    ["127.0.0.1:8080", "localhost:8080", "LOCALHOST:8080", "[::1]:8080", "192.168.1.7:8080"],
)
def test_addresses_and_localhost_are_ours(host):
    assert ask("GET", "/", {"host": host}).status_code == 200


@pytest.mark.parametrize(
    "host",
    [
        "evil.example:8080", "evil.example", "127.0.0.1", "127.0.0.1:80", "127.0.0.1:8081",
        "localhost.evil.example:8080", "127.0.0.1.evil.example:8080", "evil@127.0.0.1:8080",
        "127.0.0.1:8080@evil", "127.0.0.1:8080/x", "[::1", "", ":8080", "127.0.0.1:x", "a b:8080",
    ],
)  # fmt: skip
def test_a_foreign_host_name_is_refused_for_every_path(host):
    for path in ("/", "/picture.png?session=stand-in", "/static/index.html"):
        answer = ask("GET", path, {"host": host})
        assert answer.status_code == 421 and "error" in answer.json()


def test_a_second_host_name_is_refused_even_beside_ours():
    hosts = [("host", "127.0.0.1:8080"), ("host", "evil.example:8080")]
    assert ask("GET", "/", hosts).status_code == 421


def test_another_site_may_link_to_the_page_but_not_post_to_it():
    from_elsewhere = {"sec-fetch-site": "cross-site", "sec-fetch-mode": "navigate"}
    assert ask("GET", "/", from_elsewhere).status_code == 200
    assert ask("POST", "/", {**from_elsewhere, "origin": HERE}).status_code == 403


def test_the_name_given_with_host_is_ours():
    answer = ask("GET", "/", {"host": "Studio.local:8080"}, "studio.local")
    assert answer.status_code == 200


def bad_headers(here):
    good = {"origin": here}
    return [
        {},
        {"origin": "null"},
        {"origin": "http://evil.example"},
        {"origin": here.replace("http", "https")},
        {"origin": "http://127.0.0.1:1"},
        {"origin": here.replace("127.0.0.1", "localhost")},  # another name than the Host's
        {"origin": here + ".evil.example"},
        {"origin": here + "/"},
        {**good, "sec-fetch-site": "cross-site"},
        {**good, "sec-fetch-site": "same-site"},
    ]


@pytest.mark.parametrize("headers", bad_headers(HERE))
def test_another_sites_posts_are_refused(headers):
    answer = ask("POST", "/photo?session=stand-in", headers)
    assert answer.status_code == 403 and "page" in answer.json()["error"]


def test_another_sites_web_sockets_are_refused():
    with serving(StandIn()) as url:
        for headers in bad_headers(url):
            assert refusal(url, url, additional_headers=headers) == 403
        assert refusal(url, url.replace("127.0.0.1", "evil.example"), origin=url) == 421


def refusal(url, named, **options):
    """The status of a handshake with the server at `url` under another host name."""
    parts = urlsplit(url)
    with (
        socket.create_connection((parts.hostname, parts.port)) as raw,
        pytest.raises(InvalidStatus) as caught,
        connect(f"{named.replace('http', 'ws')}/ws", sock=raw, **options),
    ):
        pass
    return caught.value.response.status_code


@pytest.mark.parametrize(
    ("host", "local"),
    [("127.0.0.1", True), ("127.8.0.1", True), ("::1", True), ("::ffff:127.0.0.1", True),
     ("0.0.0.0", False), ("::", False), ("192.168.1.7", False), ("mine.example", False)],
)  # fmt: skip
def test_only_this_machine_reaches_a_loopback_address(host, local):
    assert is_loopback(host) is local


@pytest.mark.parametrize(
    ("client", "server", "is_ours"),
    [
        ("127.0.0.1", "127.0.0.1", True),
        ("::1", "::1", True),
        ("::ffff:127.0.0.1", "::ffff:127.0.0.1", True),
        ("192.0.2.7", "192.0.2.7", True),  # this machine at its own address in the network
        ("192.0.2.8", "192.0.2.7", False),
        ("::ffff:192.0.2.8", "::ffff:192.0.2.7", False),
        (None, "127.0.0.1", False),
    ],
)
def test_this_machine_is_told_by_its_addresses(client, server, is_ours):
    scope = {"client": client and (client, 5000), "server": (server, 8000)}
    assert is_this_machine(scope) is is_ours


def test_two_origin_headers_are_refused():
    twice = httpx.Headers([("origin", HERE), ("origin", HERE)])
    assert ask("POST", "/photo", twice).status_code == 403


@pytest.mark.parametrize("site", ["cross-site", "same-site"])
def test_a_link_opens_the_page_and_nothing_else(site):
    link = {"sec-fetch-site": site, "sec-fetch-mode": "navigate"}
    assert ask("GET", "/", link).status_code == 200
    assert ask("GET", "/picture.png", link).status_code == 403
    assert ask("GET", "/", {"sec-fetch-site": site}).status_code == 403


@pytest.mark.parametrize(
    ("method", "path", "status"),
    [("GET", "/", 200), ("GET", "/nothing", 404), ("POST", "/", 405), ("GET", "/photo", 405)],
)
def test_every_answer_carries_the_security_headers(method, path, status):
    answer = ask(method, path, {"origin": HERE})
    assert answer.status_code == status
    policy = answer.headers["content-security-policy"]
    assert re.search("default-src 'self'.*frame-ancestors 'none'", policy)
    assert answer.headers["x-content-type-options"] == "nosniff"
    assert answer.headers["cross-origin-resource-policy"] == "same-origin"


def test_refusals_carry_the_security_headers_too():
    answer = ask("GET", "/", {"host": "evil.example"})
    assert answer.headers["x-content-type-options"] == "nosniff"
