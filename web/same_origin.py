"""Checks, before anything else handles a request, whether its sender may use the server.

The server listens on this machine for its user's browser. But any web page that this browser visits
can send requests here, too. The Origin header gives such a page away. If the page has pointed a
name of its own to this address (DNS rebinding), the Host header gives it away.
"""

import re
from collections.abc import Mapping
from ipaddress import ip_address
from urllib.parse import urlsplit

from starlette.datastructures import Headers, MutableHeaders
from starlette.responses import JSONResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

_SAFE = {
    "content-security-policy": "default-src 'self'; img-src 'self' blob:; object-src 'none'; "
    "base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
    "cross-origin-opener-policy": "same-origin",
    "cross-origin-resource-policy": "same-origin",
    "referrer-policy": "no-referrer",
    "x-content-type-options": "nosniff",
    "x-frame-options": "DENY",
    "cache-control": "no-store",
}

# The last part of a name begins with a letter; the last part of an address such as 127.1 does not.
_NAME = re.compile(r"([\w-]+\.)*[^\W\d][\w-]*\.?")
_MAPPED = "::ffff:"  # stands before an IPv4 address on a socket for both IP versions
_PORTS = {"http": 80, "https": 443}  # default ports, which browsers leave out


class SameOrigin:
    """Refuses other sites' requests (403) and unknown names (421); sets headers on all responses.

    host: as given to --host; requests to this name are allowed.  port: where the server listens.
    """

    def __init__(self, app: ASGIApp, host: str, port: int) -> None:
        self._app, self._port = app, port
        self._host = host.lower().removesuffix(".")

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        if scope["type"] not in ("http", "websocket"):
            return  # the server has no lifespan events
        headers = Headers(scope=scope)
        if (refusal := self._refusal(scope, headers)) is None:
            await self._app(scope, receive, _with_headers(send))
            return
        status, text = refusal
        await JSONResponse({"error": text}, status)(scope, receive, _with_headers(send))

    def _refusal(self, scope: Scope, headers: Headers) -> tuple[int, str] | None:
        hosts = headers.getlist("host")
        if len(hosts) != 1 or not self._is_ours(hosts[0], _PORTS[_scheme(scope)]):
            return 421, (
                f"unknown server name: use the IP address and port {self._port}, or start it with "
                "--host NAME and --port N"
            )
        acts = scope["type"] == "websocket" or scope["method"] not in ("GET", "HEAD")
        if acts and headers.getlist("origin") != [f"{_scheme(scope)}://{hosts[0]}"]:
            return 403, "only the server's own page may do this, and this request is from elsewhere"
        if not _same_site(scope, headers, acts):
            return 403, "another site's page asked for this: open the server's own page"
        return None

    def _is_ours(self, host: str, usual_port: int) -> bool:
        try:
            parts = urlsplit(f"//{host}")
            name, port = parts.hostname or "", parts.port
        except ValueError:
            return False
        if parts.netloc != host or "@" in host or (port or usual_port) != self._port:
            return False
        return name.removesuffix(".") in ("localhost", self._host) or _is_ip(name)


def _scheme(scope: Scope) -> str:
    """The scheme of the page: "http" or "https"."""
    return "https" if scope["scheme"] in ("https", "wss") else "http"


def _same_site(scope: Scope, headers: Mapping[str, str], acts: bool) -> bool:
    """Check the requesting site by Sec-Fetch-Site. Every site may link to the page itself."""
    site = headers.get("sec-fetch-site", "none")
    opened = scope["path"] == "/" and headers.get("sec-fetch-mode") == "navigate"
    return site in ("same-origin", "none") or (opened and not acts)


def is_loopback(host: str) -> bool:
    """Whether this machine reaches itself by an IP address."""
    try:
        return ip_address(host.removeprefix(_MAPPED)).is_loopback
    except ValueError:
        return False


def is_name(host: str) -> bool:
    """Whether a host is the name of a machine, such as "pc.local", and not an address."""
    return _NAME.fullmatch(host) is not None


def is_this_machine(scope: Scope) -> bool:
    """Whether a request comes from the machine of the server: from a loopback address, or from the
    very address that it was sent to."""
    client, server = scope.get("client"), scope.get("server")
    if not client:
        return False
    return is_loopback(client[0]) or bool(server and client[0] == server[0])


def _is_ip(name: str) -> bool:
    try:
        ip_address(name)
    except ValueError:
        return False
    return True


def _with_headers(send: Send) -> Send:
    async def sending(message: Message) -> None:
        if message["type"] in ("http.response.start", "websocket.http.response.start"):
            headers = MutableHeaders(scope=message)
            for name, value in _SAFE.items():
                headers.setdefault(name, value)
        await send(message)

    return sending
