"""The web server, on a thread of its own, which stops within about a second.

The caller keeps the main thread and its signals: the server does not handle Ctrl-C.
"""

import asyncio
import errno
import socket
import ssl
import threading
from functools import partial
from ipaddress import ip_address
from typing import Any

import uvicorn
from makeup_video.pipeline.errors import InstallError, StoppedError, UsageError, option
from makeup_video.web.app import Log, make_app
from makeup_video.web.connection import Connection, ListeningSocket, Requests
from makeup_video.web.rooms import Rooms
from makeup_video.web.same_origin import is_name
from makeup_video.web.session import Show
from makeup_video.web.slow_jobs import SlowJobs
from makeup_video.web.upload import LOOK_BYTES

_GOODBYE_SECONDS = 0.3
_STOP_SECONDS = 5.0
_CONNECTIONS = 128  # beyond these, requests get status 503; ListeningSocket has a higher limit
_NO_DESCRIPTORS = (errno.EMFILE, errno.ENFILE)
_BROADCAST = "255.255.255.255"
_HANDSHAKE_SECONDS = 10.0  # as long as the header of a request may take


class Server:
    """Serves a show's page.

    host: a name or address of this machine.
    port: 0 for a free one.
    tls: the certificate for HTTPS; None for HTTP.
    log: called with a line for the terminal, on the server's thread.
    ping_seconds: time between two pings; a page that is silent for twice as long counts as gone.
    """

    def __init__(
        self,
        show: Show,
        slow_jobs: SlowJobs,
        host: str = "127.0.0.1",
        port: int = 0,
        *,
        log: Log,
        tls: ssl.SSLContext | None = None,
        ping_seconds: float = 20.0,
    ) -> None:
        self._rooms, self._slow_jobs = Rooms(show), slow_jobs
        self._host, self._port, self._log = host, port, log
        self._tls, self._ping_seconds = tls, ping_seconds
        self._loop: asyncio.AbstractEventLoop | None = None
        self._uvicorn: uvicorn.Server | None = None
        self._begun = threading.Event()
        self._failed: BaseException | None = None
        self._thread: threading.Thread | None = None
        self._logged = ""  # the last line about a fault of the loop
        self.address = ""  # the IP address where the server listens, once it has started

    def start(self) -> str:
        """Start serving, and return the page's address, such as "http://127.0.0.1:8080/".

        Raises UsageError when the port is taken, or host is not an address of this machine, and
        InstallError when a library of the server cannot be loaded.
        """
        listening = _listen(self._host, self._port)
        self.address, port = listening.getsockname()[:2]
        self._thread = threading.Thread(
            target=self._run, args=(listening, port), name="web server", daemon=True
        )
        self._thread.start()
        self._begun.wait()
        if isinstance(self._failed, ImportError):
            raise InstallError(
                f"the page cannot be served: {self._failed}; install makeup-video again"
            ) from self._failed
        if self._failed is not None:
            raise self._failed
        name = {"0.0.0.0": "127.0.0.1", "::": "::1"}.get(self.address, self.address)
        if is_name(self._host):
            name = self._host  # a certificate may be for this name
        scheme = "http" if self._tls is None else "https"
        return f"{scheme}://{f'[{name}]' if ':' in name else name}:{port}/"

    def stop(self) -> None:
        """Say goodbye to all pages and stop; pages that do not react are cut off.

        Only stops the slow jobs when the server does not run.
        """
        if self._thread is not None and self._loop is not None and self._thread.is_alive():
            ending = self._end()
            try:
                asyncio.run_coroutine_threadsafe(ending, self._loop)
            except RuntimeError:  # the loop has just ended
                ending.close()
            self._thread.join(_STOP_SECONDS)
        self._slow_jobs.stop()  # `_end` has done so unless the server did not run

    def _run(self, listening: socket.socket, port: int) -> None:
        try:
            self._serve_until_stopped(listening, port)
        except BaseException as error:
            if self._begun.is_set():
                raise
            self._failed = error
        finally:
            listening.close()
            self._begun.set()

    def _serve_until_stopped(self, listening: socket.socket, port: int) -> None:
        app = make_app(self._rooms, self._slow_jobs, self._host, port, self._log)
        config = uvicorn.Config(
            app,
            loop="asyncio",
            http=Requests,
            ws=Connection,
            ws_max_size=LOOK_BYTES,
            ws_ping_interval=self._ping_seconds,
            ws_ping_timeout=self._ping_seconds,
            ws_per_message_deflate=False,  # JPEG does not compress
            lifespan="off",
            log_config=None,
            log_level="critical",
            access_log=False,
            proxy_headers=False,
            server_header=False,
            limit_concurrency=_CONNECTIONS,
            backlog=_CONNECTIONS,  # asyncio accepts up to this many before any other work
            timeout_graceful_shutdown=1,
        )
        config.load()
        config.ssl = self._tls
        self._uvicorn = uvicorn.Server(config)
        # The default loop of Windows would accept past the limit of the ListeningSocket, and read
        # more at once than a Connection asks for. Elsewhere this loop is asyncio's default.
        with asyncio.Runner(loop_factory=asyncio.SelectorEventLoop) as runner:
            runner.run(self._serve(self._uvicorn, listening))

    async def _serve(self, server: uvicorn.Server, listening: socket.socket) -> None:
        self._loop = loop = asyncio.get_running_loop()
        loop.set_exception_handler(self._log_fault)
        if self._tls is not None:  # uvicorn has no option for the time of the handshake
            listen = partial(loop.create_server, ssl_handshake_timeout=_HANDSHAKE_SECONDS)
            loop.create_server = listen  # type: ignore[method-assign]
        self._begun.set()
        await server.serve(sockets=[listening])

    def _log_fault(self, _loop: asyncio.AbstractEventLoop, fault: dict[str, Any]) -> None:
        """Log a fault in one line, where asyncio would print a traceback; log no line twice in a
        row."""
        error = fault.get("exception")
        if isinstance(error, StoppedError):  # from a request that the stopping server cuts off
            return
        if isinstance(error, OSError) and error.errno in _NO_DESCRIPTORS:
            line = (
                f"the page takes no new connections for now: {error.strerror}; close other pages, "
                "or raise the limit of open files (ulimit -n)"
            )
        else:
            line = f"internal error of the page's server: {fault['message']}"
            line += f": {type(error).__name__}: {error}" if error else ""
        if line != self._logged:
            self._logged = line
            self._log(line)

    async def _end(self) -> None:
        self._rooms.end()
        until = asyncio.get_running_loop().time() + _GOODBYE_SECONDS
        while self._rooms.viewers and asyncio.get_running_loop().time() < until:
            await asyncio.sleep(0.01)
        # requests that wait for slow jobs are answered now, before uvicorn cancels them
        self._slow_jobs.stop()
        assert self._uvicorn is not None
        self._uvicorn.should_exit = True


def _listen(host: str, port: int) -> socket.socket:
    """Open a listening socket. Raises UsageError."""
    if not 0 <= port <= 65535:
        raise UsageError(f"{option('port')} must be in 0..65535, got {port}")
    try:
        name = host.removesuffix(".") if is_name(host) else host
        family, *_, address = socket.getaddrinfo(name, port, type=socket.SOCK_STREAM)[0]
        if ip_address(address[0]).is_multicast or address[0] == _BROADCAST:
            raise OSError(errno.EADDRNOTAVAIL, "nobody can connect to it")
        both = host == "::" and socket.has_dualstack_ipv6()  # "::" should mean IPv4, too
        listening = socket.create_server(address, family=family, dualstack_ipv6=both)
        return ListeningSocket(family, listening.detach())
    except (OSError, UnicodeError) as error:
        raise UsageError(_why_not(host, port, error)) from error


def _why_not(host: str, port: int, error: Exception) -> str:
    number = getattr(error, "errno", None)
    if number == errno.EADDRINUSE:
        return (
            f"port {port} on {host} is taken: give another {option('port')}, or "
            f"{option('port', 0)} for a free one"
        )
    if number == errno.EACCES:
        return f"this user may not use port {port}: set {option('port')} to 1024 or more"
    return (
        f"{option('host', host)} is not an address of this machine: give one, or leave it out for "
        "127.0.0.1"
    )
