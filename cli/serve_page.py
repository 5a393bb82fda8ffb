"""The page in the browser, served for `live` and `demo`."""

import ipaddress
import os
import sys
import webbrowser
from collections.abc import Callable, Generator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from makeup_video.cli.console import log
from makeup_video.cli.options import PageOptions

if TYPE_CHECKING:
    from makeup_video.web.session import Show
    from makeup_video.web.worker import Worker


@contextmanager
def serve_page(
    show: "Show", worker: "Worker", options: PageOptions, log_line: Callable[[str], None]
) -> Generator[str, None, None]:
    """Serve the page within the block and open a browser; yields the page's address.

    log_line: gets the address, and a warning when other machines can reach the page.  Raises
    UsageError when the page cannot be served at this address.
    """
    from makeup_video.pipeline.engine.signals import undisturbed
    from makeup_video.web.server import Server

    server = Server(show, worker, options.host, options.port, log=log)
    url = server.start()
    try:
        log_line(f"{url} shows the page; Ctrl-C ends it")
        if not is_loopback(options.host):
            log_line(
                "everybody who reaches this machine sees that page, and can change what is painted"
            )
        if options.browser and has_screen():
            webbrowser.open(url)
        yield url
    finally:
        with undisturbed():
            server.stop()


def is_loopback(host: str) -> bool:
    """Whether only this machine can reach an address."""
    try:
        return host == "localhost" or ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


def has_screen() -> bool:
    """Whether a browser would open a window; in a bare terminal it would take over the terminal."""
    if not sys.platform.startswith("linux"):
        return True
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))
