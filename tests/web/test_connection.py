"""Limits of a connection: the time for a header, and the work that a flood can cause."""

import contextlib
import json
import socket
import time
from dataclasses import replace
from unittest.mock import Mock
from urllib.parse import urlsplit

import httpx
import pytest
from makeup_video.web import app, connection
from makeup_video.web.connection import Connection
from shows import RED, Page, StandIn, serving
from uvicorn import Config
from uvicorn.server import ServerState
from websockets.frames import Frame, Opcode

HOST = b"GET / HTTP/1.1\r\nHost: "


def opened(url):
    parts = urlsplit(url)
    return socket.create_connection((parts.hostname, parts.port), timeout=20)


def whole_answer(raw):
    """Headers and body of one response."""
    data = b""
    while b"\r\n\r\n" not in data:
        data += raw.recv(65536)
    head, body = data.split(b"\r\n\r\n", 1)
    length = int(head.lower().split(b"content-length: ")[1].split(b"\r\n")[0])
    while len(body) < length:
        body += raw.recv(65536)
    return head


def is_let_go(raw):
    with contextlib.suppress(ConnectionResetError):
        return raw.recv(1) == b""
    return True


@pytest.fixture
def hurried(monkeypatch):
    monkeypatch.setattr(connection, "_HEADER_SECONDS", 0.3)
    with serving(StandIn()) as url:
        yield url


def test_pictures_leave_without_delay(monkeypatch):
    transports = []
    connection_made = Connection.connection_made

    def spy(self, transport):
        transports.append(transport)
        connection_made(self, transport)

    monkeypatch.setattr(Connection, "connection_made", spy)
    with serving(StandIn()) as url, Page(url):
        (page,) = transports
        raw = page.get_extra_info("socket")
        assert raw.getsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY)


@pytest.mark.parametrize("begun", [b"", b"G", HOST, HOST + b"127.0.0.1\r\nX: y\r\n"])
def test_a_header_that_never_ends_closes_the_connection(hurried, begun):
    with opened(hurried) as raw:
        raw.sendall(begun)
        assert is_let_go(raw)


def test_a_header_sent_byte_by_byte_closes_the_connection(hurried):
    with opened(hurried) as raw, contextlib.suppress(BrokenPipeError, ConnectionResetError):
        raw.sendall(HOST)
        for _ in range(1000):
            raw.sendall(b"x")
            time.sleep(0.02)
        pytest.fail("it was read for ever")


def test_a_second_header_that_never_ends_closes_it_too(hurried):
    host = urlsplit(hurried).netloc.encode()
    with opened(hurried) as raw:
        raw.sendall(HOST + host + b"\r\n\r\n")
        assert b"200" in whole_answer(raw).split(b"\r\n")[0]
        raw.sendall(HOST)
        assert is_let_go(raw)


def test_an_unwanted_body_is_not_read_for_ever(hurried):
    host = urlsplit(hurried).netloc.encode()
    with opened(hurried) as raw, contextlib.suppress(BrokenPipeError, ConnectionResetError):
        raw.sendall(b"POST / HTTP/1.1\r\nHost: " + host + b"\r\nContent-Length: 99999\r\n\r\n")
        whole_answer(raw)
        for _ in range(1000):
            raw.sendall(b"x")
            time.sleep(0.02)
        pytest.fail("it was read for ever")


def test_endless_empty_parts_of_a_message_close_it():
    peer = Connection.__new__(Connection)
    peer.frames, peer.transport = [b"look"], Mock()
    empty = Frame(Opcode.CONT, b"", fin=False)
    for _ in range(1000):
        peer.handle_cont(empty)
    assert not peer.transport.abort.called
    for _ in range(100):
        peer.handle_cont(empty)
    assert peer.transport.abort.called


def test_a_long_answer_over_a_slow_network_arrives_whole(hurried, monkeypatch):
    """The time for the next header begins while the end of an answer is still being sent."""
    body, limit = b"x" * 8_000_000, connection._HEADER_SECONDS
    monkeypatch.setattr(app, "ready_looks_message", lambda looks: body)
    with opened(hurried) as raw:
        host = urlsplit(hurried).netloc.encode()
        raw.sendall(b"GET /looks HTTP/1.1\r\nHost: " + host + b"\r\n\r\n")
        count, until = 0, time.monotonic() + 5 * limit
        while time.monotonic() < until:  # slowly, for much longer than the limit
            count += len(raw.recv(100_000))
            time.sleep(limit / 10)
        while data := raw.recv(1_000_000):
            count += len(data)
            if count > len(body):
                break
    assert count > len(body)


def test_photos_and_web_sockets_may_outlast_the_header_limit(hurried):
    def slowly():
        for _ in range(4):
            yield b"part"
            time.sleep(0.2)

    with Page(hurried) as page:
        assert page.post("/photo", slowly()).status_code == 200
        page.send("nothing")
        assert page.message("error")


def test_half_headers_on_every_connection_block_only_briefly(hurried):
    with contextlib.ExitStack() as stack:
        for _ in range(128):
            raw = stack.enter_context(opened(hurried))
            raw.sendall(HOST)
        until = time.monotonic() + 20
        while httpx.get(hurried).status_code != 200:
            assert time.monotonic() < until
            time.sleep(0.05)


# -- floods


class Transport:
    """The transport of a connection whose peer never stops sending; records pauses of reading."""

    def __init__(self):
        self.reads, self.max_size, self.wrote, self.closed = True, 256 * 1024, b"", False

    def is_closing(self):
        return self.closed

    def pause_reading(self):
        assert not self.closed  # asyncio's transport with TLS fails when it was closed twice
        self.reads = False

    def resume_reading(self):
        assert not self.closed
        self.reads = True

    def write(self, data):
        self.wrote += data

    def set_write_buffer_limits(self, high):
        pass

    def get_write_buffer_size(self):
        return 0

    def get_extra_info(self, name):
        return None


class Loop:
    """An event loop that collects delayed calls."""

    def __init__(self):
        self.later = []

    def call_later(self, seconds, call):
        self.later.append((seconds, call))

    def create_task(self, work):
        work.close()
        return self

    def add_done_callback(self, call):
        pass


def frame(text, opcode=1):
    data = text.encode()
    assert len(data) < 126
    return bytes([0x80 | opcode, 0x80 | len(data)]) + bytes(4) + data


HANDSHAKE = (
    b"GET /ws HTTP/1.1\r\nHost: a\r\nUpgrade: websocket\r\nConnection: Upgrade\r\n"
    b"Sec-WebSocket-Version: 13\r\nSec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n"
)


async def no_app(scope, receive, send):
    """An app that ignores everything it receives."""


@pytest.fixture
def flooded(monkeypatch):
    """(connection, loop, transport); each read takes a hundredth of a second."""
    clock = iter(range(10**6))
    monkeypatch.setattr(connection.time, "thread_time", lambda: next(clock) / 100)
    loop, transport = Loop(), Transport()
    protocol = Connection(Config(no_app, ws=Connection), ServerState(), {}, loop)
    protocol.connection_made(transport)
    protocol.data_received(HANDSHAKE)
    (_, read_on), loop.later = loop.later[0], []
    read_on()
    assert transport.reads
    return protocol, loop, transport


@pytest.mark.parametrize("opcode", [1, 2, 9, 10])
def test_after_reading_a_socket_rests_nine_times_as_long(flooded, opcode):
    protocol, loop, transport = flooded
    protocol.data_received(frame("x", opcode))
    assert not transport.reads
    ((seconds, read_on),) = loop.later
    assert seconds == pytest.approx(0.09)
    read_on()
    assert transport.reads is (opcode > 8)  # the app must receive a message first


def test_bytes_per_second_of_a_socket_are_limited_too(flooded, monkeypatch):
    protocol, loop, transport = flooded
    monkeypatch.setattr(connection.time, "thread_time", lambda: 0.0)
    # so much may come from a transport with TLS, which ignores the limit of one read
    protocol.data_received(b"\x81\xff" + (1_000_000).to_bytes(8, "big") + bytes(4) + bytes(400_000))
    rested = 0.0
    while loop.later:
        assert not transport.reads
        ((seconds, read_on),) = loop.later
        loop.later.clear()
        rested += seconds
        read_on()
    assert transport.reads
    assert rested == pytest.approx(0.2, rel=0.01)  # at two million bytes a second


@pytest.mark.parametrize("received_first", [True, False])
def test_reading_resumes_after_the_rest_and_all_messages(flooded, received_first):
    protocol, loop, transport = flooded
    protocol.data_received(frame("x"))
    rested = loop.later[0][1]
    steps = (
        [lambda: receive_all(protocol), rested]
        if received_first
        else [rested, lambda: receive_all(protocol)]
    )
    steps[0]()
    assert not transport.reads
    steps[1]()
    assert transport.reads


def receive_all(protocol):
    while not protocol.queue.empty():
        receiving = protocol.receive()
        with contextlib.suppress(StopIteration):
            receiving.send(None)


@pytest.mark.parametrize("received_first", [True, False])
def test_a_closed_connection_is_not_paused_nor_resumed(flooded, received_first):
    protocol, loop, transport = flooded
    protocol.data_received(frame("x"))
    transport.closed = True
    if received_first:
        receive_all(protocol)
    (_, read_on), loop.later = loop.later[0], []
    read_on()
    receive_all(protocol)
    protocol.data_received(frame("y"))
    receive_all(protocol)
    for _, call in loop.later:
        call()


def test_a_flood_is_read_slowly_and_its_last_look_is_painted(monkeypatch):
    read = []

    def noting(self, data):
        read.append(len(data))
        received(self, data)

    received = Connection.data_received
    monkeypatch.setattr(Connection, "data_received", noting)
    show = StandIn()
    look = replace(RED, strength=0.5)
    with serving(show) as url, Page(url) as page:
        for n in range(2000):
            page.socket.send(json.dumps({"type": "look", "look": RED.to_dict(), "n": n}))
        page.send("look", look=look.to_dict(), n=2000)
        until = time.monotonic() + 20
        while show.look != look:
            assert time.monotonic() < until
            time.sleep(0.01)
    assert max(read) <= 4096
