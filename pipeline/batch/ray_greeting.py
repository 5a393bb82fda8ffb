"""Finds out in seconds whether a Ray cluster answers at an address; Ray itself tries for minutes.

Ray's head speaks gRPC, that is HTTP/2 (RFC 9113) with headers in HPACK (RFC 7541). One call is
written by hand here, because the gRPC library would be a dependency for these few bytes.
"""

import socket
import time

_PREFACE = b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n"
_DATA, _HEADERS, _SETTINGS = 0, 1, 4  # types of HTTP/2 frames
_END_STREAM, _END_HEADERS = 1, 4  # flags
_STREAM = 1
_HEAD_BYTES = 9  # of an HTTP/2 frame: its length (3), type, flags, stream (4)
_EMPTY_MESSAGE = b"\0\0\0\0\0"  # of gRPC: not compressed, no bytes
_CALL = {
    ":method": "POST",
    ":scheme": "http",
    ":path": "/ray.rpc.NodeInfoGcsService/GetClusterId",
    ":authority": "ray",
    "te": "trailers",
    "content-type": "application/grpc",
}


def is_cluster(host: str, port: int, seconds: float) -> bool:
    """Whether an answer within `seconds` gives the id of a Ray cluster.

    Raises OSError when the host cannot be reached or stays silent, OverflowError for a wrong port.
    """
    until = time.monotonic() + seconds
    with socket.create_connection((host, port), seconds) as connection:
        connection.sendall(
            _PREFACE
            + _frame(_SETTINGS, 0, 0, b"")
            + _frame(_HEADERS, _END_HEADERS, _STREAM, _header_block())
            + _frame(_DATA, _END_STREAM, _STREAM, _EMPTY_MESSAGE)
        )
        is_http2 = False
        while len(head := _read(connection, _HEAD_BYTES, until)) == _HEAD_BYTES:
            length, kind, flags = int.from_bytes(head[:3]), head[3], head[4]
            is_http2 = is_http2 or kind == _SETTINGS  # a server begins with its settings
            is_answer = int.from_bytes(head[5:]) == _STREAM
            if is_answer and (kind == _DATA or flags & _END_STREAM):
                return kind == _DATA and length > len(_EMPTY_MESSAGE)
            if not is_http2 or len(_read(connection, length, until)) < length:
                break
    return False


def _frame(kind: int, flags: int, stream: int, payload: bytes) -> bytes:
    return len(payload).to_bytes(3) + bytes((kind, flags)) + stream.to_bytes(4) + payload


def _header_block() -> bytes:
    """HPACK's plainest form: every field literal, none indexed."""
    texts = ((text.encode() for text in pair) for pair in _CALL.items())
    return b"".join(
        b"\0" + bytes((len(name),)) + name + bytes((len(value),)) + value for name, value in texts
    )


def _read(connection: socket.socket, count: int, until: float) -> bytes:
    """That many bytes, fewer at the end. Raises TimeoutError."""
    found = b""
    while len(found) < count:
        left = until - time.monotonic()
        if left <= 0:
            raise TimeoutError("timed out")
        connection.settimeout(left)
        more = connection.recv(count - len(found))
        if not more:
            break
        found += more
    return found
