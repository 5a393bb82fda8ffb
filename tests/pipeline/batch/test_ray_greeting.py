"""A server that tells a cluster's id is a cluster, and nothing else is."""

import contextlib
import socket
import threading

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from makeup_video.pipeline.batch.ray_greeting import is_cluster


def frame(kind, flags, stream, payload=b""):
    return len(payload).to_bytes(3) + bytes((kind, flags)) + stream.to_bytes(4) + payload


SETTINGS, ACKNOWLEDGED = frame(4, 0, 0, b"\0\3\0\0\0\144"), frame(4, 1, 0)
HEADERS, ID = frame(1, 4, 1, b"\x88"), frame(0, 0, 1, b"\0\0\0\0\3\x0a\1x")
CLUSTER = SETTINGS + ACKNOWLEDGED + HEADERS + ID


@contextlib.contextmanager
def server(*parts, stays=False):
    """(port, asked): a server that receives bytes into `asked`, then sends these parts."""
    with socket.create_server(("127.0.0.1", 0)) as listening:
        asked, done = [], threading.Event()

        def answer():
            connection, _ = listening.accept()
            with connection:
                asked.append(connection.recv(4096))
                with contextlib.suppress(ConnectionError):  # the client may have hung up
                    for part in parts:
                        connection.sendall(part)
                if stays:
                    done.wait(20)

        thread = threading.Thread(target=answer)
        thread.start()
        try:
            yield listening.getsockname()[1], asked
        finally:
            done.set()
            thread.join()


@pytest.mark.parametrize("parts", [[CLUSTER], [bytes([byte]) for byte in CLUSTER]])
def test_a_server_that_tells_an_id_is_a_cluster(parts):
    with server(*parts, stays=True) as (port, asked):
        assert is_cluster("127.0.0.1", port, 10)
    assert asked[0].startswith(b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n" + frame(4, 0, 0))
    assert b"/ray.rpc.NodeInfoGcsService/GetClusterId" in asked[0]
    assert asked[0].endswith(frame(0, 1, 1, bytes(5)))


@pytest.mark.parametrize(
    "says",
    [
        b"",
        b"HTTP/1.1 400 Bad Request\r\n\r\n",
        SETTINGS + frame(1, 5, 1, b"\x88"),  # headers alone, as for an unknown call
        SETTINGS + HEADERS + frame(0, 0, 1, bytes(5)),  # an empty message
        SETTINGS + frame(0, 0, 3, bytes(9)),  # the id of another call
        HEADERS + ID,  # no settings first
    ],
)
def test_a_server_that_tells_no_id_is_none(says):
    with server(says) as (port, _):
        assert not is_cluster("127.0.0.1", port, 10)


@settings(max_examples=40, deadline=None)
@given(st.integers(0, len(CLUSTER) - len(ID)))
def test_an_answer_that_breaks_off_is_none(length):
    with server(CLUSTER[:length]) as (port, _):
        assert not is_cluster("127.0.0.1", port, 10)


@pytest.mark.timeout(20)
def test_a_silent_server_is_given_up():
    with server(SETTINGS, stays=True) as (port, _), pytest.raises(TimeoutError):
        is_cluster("127.0.0.1", port, 0.3)
