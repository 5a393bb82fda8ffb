"""Requests that a stop of the server cuts off are answered, unless it is too late."""

import asyncio
import json
import socket
from urllib.parse import urlsplit

import httpx
import pytest
from makeup_video.web.cut_off import AnswerCutOff
from shows import Page, StandIn, serving


def test_an_upload_that_a_stop_cuts_off_is_answered_with_503():
    log = []
    with serving(StandIn(), log=log) as url, Page(url):
        parts = urlsplit(url)
        raw = socket.create_connection((parts.hostname, parts.port), timeout=20)
        raw.sendall(
            f"POST /photo?session=stand-in HTTP/1.1\r\nHost: {parts.netloc}\r\nOrigin: {url}\r\n"
            "Content-Length: 1000\r\n\r\nbegun".encode()
        )
        httpx.get(url)  # answered after the server has read the request above
    with raw, raw.makefile("rb") as answer:
        head, _, body = answer.read().partition(b"\r\n\r\n")
    assert head.startswith(b"HTTP/1.1 503 ") and b"nosniff" in head
    assert "is stopping" in json.loads(body)["error"] and log == []


@pytest.mark.parametrize("kind", ["http", "websocket"])
def test_what_has_begun_and_a_websocket_get_no_second_answer(kind):
    sent, start = [], {"type": "http.response.start", "status": 200}

    async def cut_off(scope, receive, send):
        if kind == "http":
            await send(start)
        raise asyncio.CancelledError

    async def note(message):
        sent.append(message)

    with pytest.raises(asyncio.CancelledError):
        asyncio.run(AnswerCutOff(cut_off)({"type": kind}, None, note))
    assert sent == ([start] if kind == "http" else [])


def test_a_client_that_does_not_read_is_not_waited_for():
    async def cut_off(scope, receive, send):
        raise asyncio.CancelledError

    async def wait(message):
        await asyncio.get_running_loop().create_future()

    async def serve():
        async with asyncio.timeout(5):
            await AnswerCutOff(cut_off)({"type": "http"}, None, wait)

    with pytest.raises(asyncio.CancelledError):
        asyncio.run(serve())
