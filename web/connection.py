"""The listening socket and uvicorn's two protocols, with limits on the number of connections, on a
peer's time and on the work it may cause."""

import asyncio
import socket
import time
from asyncio.transports import BaseTransport
from typing import Any, cast
from weakref import WeakSet

from uvicorn._types import ASGIReceiveEvent
from uvicorn.protocols.http.h11_impl import H11Protocol
from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol
from websockets.frames import Frame

# How long a request's header may take, from the start of the connection or from the last response.
# The server accepts only a few connections, and a waiting one counts among them.
_HEADER_SECONDS = 10.0
# One message, and unread answers to pings. The largest pictures, with and without makeup, have
# 10 MB together.
_MOST_BYTES = 32_000_000
# Parts of a message. Parts may be empty, and a limit on bytes would never end a series of those.
_MOST_PARTS = 1024
# Bytes read from a WebSocket at once: one or two looks, or hundreds of the smallest WebSocket
# frames (20 ms of work).
_READ_BYTES = 4096
# After each read the socket pauses nine times as long as the read took, so that a flood of messages
# uses a tenth of a core. Long messages cost more to handle than to read, so a second limit counts
# bytes.
_REST = 9.0
_BYTES_A_SECOND = 2_000_000
_STUCK = 5  # how often in a row the timer may end before the system takes more of a response


class ListeningSocket(socket.socket):
    """A listening socket that keeps at most `most` connections open, and closes all further ones.

    uvicorn counts only connections that have sent a request. Idle connections, or TLS handshakes
    that never end, would otherwise take all file descriptors of the run. The limit holds only under
    an event loop that calls `accept` of this socket, as a SelectorEventLoop does.
    """

    most = 160

    def __init__(self, family: int, fileno: int) -> None:
        """Take over a listening TCP socket."""
        # asyncio sends without delay (TCP_NODELAY) if a socket names its protocol, and accepted
        # sockets inherit the protocol. Otherwise the kernel may hold back the end of a picture for
        # up to 40 ms, until the page acknowledges the bytes before it.
        super().__init__(family, socket.SOCK_STREAM, socket.IPPROTO_TCP, fileno)
        self._accepted: WeakSet[socket.socket] = WeakSet()

    def accept(self) -> tuple[socket.socket, Any]:
        """Accept a connection. Raises ConnectionAbortedError, which asyncio ignores."""
        connection, address = super().accept()
        if sum(one.fileno() >= 0 for one in self._accepted) >= self.most:
            connection.close()
            raise ConnectionAbortedError("there are too many connections")
        self._accepted.add(connection)
        return connection, address


class Requests(H11Protocol):
    """HTTP that aborts a connection when a request's header does not arrive in time."""

    _waiting: asyncio.TimerHandle | None = None
    _unsent = 0  # bytes of the last response that were unsent when the timer was started
    _stuck = 0  # how often in a row the timer ended before the system took any of these bytes

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]
        super().connection_made(transport)
        self._wait_or_not()

    def data_received(self, data: bytes) -> None:
        super().data_received(data)
        self._wait_or_not()

    def on_response_complete(self) -> None:
        super().on_response_complete()
        self._wait_or_not()

    def connection_lost(self, exc: Exception | None) -> None:
        super().connection_lost(exc)
        self._stop_waiting()

    def _wait_or_not(self) -> None:
        """Start or stop the timer.

        A request that is being answered has no limit, nor has a WebSocket. A running timer is never
        restarted, so a trickle of bytes does not extend the time.
        """
        is_answering = self.cycle is not None and not self.cycle.response_complete
        is_web_socket = self.transport.get_protocol() is not self
        if is_answering or is_web_socket:
            self._stop_waiting()
        elif self._waiting is None:
            self._wait()

    def _wait(self) -> None:
        self._unsent = self.transport.get_write_buffer_size()
        self._waiting = self.loop.call_later(_HEADER_SECONDS, self._end_or_wait)

    def _end_or_wait(self) -> None:
        """Abort, unless the last response is still on its way over a slow network."""
        unsent = self.transport.get_write_buffer_size()
        self._stuck = self._stuck + 1 if unsent >= self._unsent else 0
        # A few such ends are normal: the system takes more only after it sent about a megabyte.
        if self._stuck and (not unsent or self._stuck > _STUCK):
            self.transport.abort()
        else:
            self._wait()

    def _stop_waiting(self) -> None:
        if self._waiting is not None:
            self._waiting.cancel()
            self._waiting = None
        self._stuck = 0


class Connection(WebSocketsSansIOProtocol):
    """A WebSocket with at most one message in this process that waits to be sent.

    A stalled socket is aborted when necessary. A flood of messages is read slowly, so the rest of
    it waits at the sender.
    """

    _rests = False
    _unread = b""

    def connection_made(self, transport: BaseTransport) -> None:
        super().connection_made(transport)
        # The next send waits until the kernel has taken the whole last message. With a limit of 0,
        # a transport with TLS would wait for ever.
        cast(asyncio.Transport, transport).set_write_buffer_limits(high=1)
        cast(Any, transport).max_size = _READ_BYTES  # asyncio's socket transports read so much

    def data_received(self, data: bytes) -> None:
        """Handle _READ_BYTES at once, even if a transport with TLS delivers more."""
        if self.transport.is_closing():
            return  # with TLS, data still arrives after the connection was closed
        self._unread += data
        if not self._rests:
            self._read_some()

    def handle_cont(self, event: Frame) -> None:
        super().handle_cont(event)
        if len(self.frames) > _MOST_PARTS:
            self.transport.abort()

    def _read_some(self) -> None:
        data, self._unread = self._unread[:_READ_BYTES], self._unread[_READ_BYTES:]
        began = time.thread_time()
        super().data_received(data)
        spent = time.thread_time() - began
        self._rests = True
        self._pause()
        self.loop.call_later(max(_REST * spent, len(data) / _BYTES_A_SECOND), self._read_on)

    async def receive(self) -> ASGIReceiveEvent:
        if self.transport.is_closing():
            self.read_paused = False  # otherwise uvicorn would resume a transport that is closing
        message = await super().receive()
        if self._rests:
            self._pause()  # uvicorn has just resumed reading
        elif self._unread:
            self._read_some()
        return message

    def _read_on(self) -> None:
        self._rests = False
        if self.read_paused or self.transport.is_closing():
            return
        if self._unread:
            self._read_some()
        else:
            self.transport.resume_reading()

    def _pause(self) -> None:
        if not self.transport.is_closing():  # a TLS transport that was closed twice cannot pause
            self.transport.pause_reading()

    def handle_ping(self) -> None:
        super().handle_ping()
        if self.transport.get_write_buffer_size() > _MOST_BYTES:
            self.transport.abort()

    def keepalive_timeout(self) -> None:
        super().keepalive_timeout()
        self.transport.abort()  # closing would wait for data that the peer may never take

    def shutdown(self) -> None:
        super().shutdown()
        if self.transport.get_write_buffer_size():
            self.transport.abort()
