"""The page in the browser, served for `live` and `demo`."""

import os
import ssl
import sys
import webbrowser
from collections.abc import Callable, Generator
from contextlib import contextmanager
from ipaddress import ip_address
from typing import TYPE_CHECKING
from urllib.parse import urlsplit

from makeup_video.cli.console import log
from makeup_video.cli.options import PageOptions

if TYPE_CHECKING:
    from makeup_video.web.session import Show
    from makeup_video.web.slow_jobs import SlowJobs


@contextmanager
def serve_page(
    show: "Show", slow_jobs: "SlowJobs", options: PageOptions, log_line: Callable[[str], None]
) -> Generator[None, None, None]:
    """Serve the page within the block and open a browser.

    log_line: gets the address, and a warning when other machines can reach the page.  Raises
    UsageError when the page cannot be served at this address, and InputError, InstallError or
    OutputError when there is no certificate for HTTPS.
    """
    from makeup_video.pipeline.engine.signals import undisturbed
    from makeup_video.web.same_origin import is_loopback
    from makeup_video.web.server import Server

    server = Server(show, slow_jobs, options.host, options.port, log=log, tls=_tls(options))
    url = server.start()
    try:
        log_line(f"{url} shows the page; Ctrl-C ends it")
        if options.https and options.certificate is None:
            log_line(
                "browsers warn about its certificate, which this machine generated: continue "
                "to the page"
            )
        if not is_loopback(server.address):
            log_line(_who_sees(server.address, url))
        if options.browser and has_screen():
            webbrowser.open(url)
        yield
    finally:
        with undisturbed():
            server.stop()


def _tls(options: PageOptions) -> ssl.SSLContext | None:
    """The TLS context with the certificate for HTTPS; None for HTTP."""
    from makeup_video.pipeline import UsageError
    from makeup_video.web.certificate import load_context, own_certificate

    if options.certificate is not None:
        return load_context(options.certificate, options.key)
    if options.key is not None:
        raise UsageError("--key belongs to a certificate: give it by --certificate, too")
    return load_context(own_certificate(options.host)) if options.https else None


def _who_sees(address: str, url: str) -> str:
    """The warning that other machines can reach the page, with the address that they can use.

    address: the IP address where the page is served.
    """
    from makeup_video.web.certificate import lan_address

    where = ""
    if ip_address(address).is_unspecified and (reached := lan_address()):
        parts = urlsplit(url)
        where = f" at {parts.scheme}://{reached}:{parts.port}/"
    return f"everybody who reaches this machine can open the page{where} and change the look"


def has_screen() -> bool:
    """Whether a browser would open a window; in a bare terminal it would take over the terminal."""
    if sys.platform != "linux":
        return True
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))
