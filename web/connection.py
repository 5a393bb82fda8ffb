"""uvicorn's WebSocket with an end: a peer that stopped reading is cut off, not waited for."""

import asyncio
from asyncio.transports import BaseTransport
from typing import cast

from uvicorn.protocols.websockets.websockets_sansio_impl import WebSocketsSansIOProtocol

# One message, and answers to pings that have not been read. The largest pictures have 10 MB with what was before.
_MOST_BYTES = 32_000_000


class Connection(WebSocketsSansIOProtocol):
    """One message at most waits in this process, and a stalled socket goes when it must."""

    def connection_made(self, transport: BaseTransport) -> None:
        super().connection_made(transport)
        # the next send waits until the kernel has taken all of the last one
        cast(asyncio.Transport, transport).set_write_buffer_limits(high=0)

    def handle_ping(self) -> None:
        super().handle_ping()
        if self.transport.get_write_buffer_size() > _MOST_BYTES:
            self.transport.abort()

    def keepalive_timeout(self) -> None:
        super().keepalive_timeout()
        self.transport.abort()  # a close would wait for what the peer never takes

    def shutdown(self) -> None:
        super().shutdown()
        if self.transport.get_write_buffer_size():
            self.transport.abort()
