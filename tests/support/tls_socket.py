"""A WebSocket over TLS for tests."""

import asyncio
import threading
from contextlib import contextmanager

from websockets.asyncio.client import connect


class TlsSocket:
    """Replaces the sockets of websockets.sync, which read and write TLS in two threads at once.

    OpenSSL does not allow that for one connection; here a single thread does both.
    """

    def __init__(self, loop, socket):
        self._loop, self._socket = loop, socket

    def send(self, message):
        run(self._loop, self._socket.send(message))

    def recv(self, timeout):
        return run(self._loop, asyncio.wait_for(self._socket.recv(), timeout))


def run(loop, awaited):
    return asyncio.run_coroutine_threadsafe(awaited, loop).result(30)


@contextmanager
def open_tls(url, tls, **options):
    """tls: the certificates to trust. options: those of websockets' connect."""

    async def opened():
        return await connect(url, ssl=tls, **options)

    loop = asyncio.new_event_loop()
    thread = threading.Thread(target=loop.run_forever)
    thread.start()
    try:
        socket = run(loop, opened())
        try:
            yield TlsSocket(loop, socket)
        finally:
            run(loop, socket.close())
    finally:
        loop.call_soon_threadsafe(loop.stop)
        thread.join()
        loop.close()
