"""The page in the browser, as every command that has one opens it."""

import ipaddress
import os
import sys
import webbrowser
from collections.abc import Callable, Generator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from makeup_video.cli.console import say

if TYPE_CHECKING:
    from makeup_video.web.session import Show
    from makeup_video.web.worker import Worker

PORT = 8760


@contextmanager
def page(
    show: "Show",
    worker: "Worker",
    host: str,
    port: int,
    *,
    browser: bool,
    told: Callable[[str], None],
) -> Generator[str, None, None]:
    """Serves the page within the block; yields its address, which is told in a line and opened in the
    browser. Raises UsageError when it cannot be served there."""
    from makeup_video.pipeline.engine.signals import undisturbed
    from makeup_video.web.server import Server

    server = Server(show, worker, host, port, say=say)
    url = server.start()
    try:
        told(f"{url} shows the page; Ctrl-C ends it")
        if not is_loopback(host):
            told(
                "everybody who reaches this machine sees that page, and can change what is painted"
            )
        if browser and has_screen():
            webbrowser.open(url)
        yield url
    finally:
        with undisturbed():
            server.stop()


def is_loopback(host: str) -> bool:
    """Whether only this machine can reach what listens there."""
    try:
        return host == "localhost" or ipaddress.ip_address(host).is_loopback
    except ValueError:
        return False


def has_screen() -> bool:
    """Whether a browser would be a window: in a bare terminal Python opens one that takes the terminal."""
    if not sys.platform.startswith("linux"):
        return True
    return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))
