"""A show under the control of tests, a server for the show, and pages that watch."""

import json
import socket
import ssl
import threading
from collections.abc import Generator
from contextlib import ExitStack, contextmanager
from urllib.parse import urlsplit

import httpx
import numpy as np
from makeup_video.pipeline import Look, product
from makeup_video.pipeline.reference.estimate import Estimate
from makeup_video.pipeline.reference.read_makeup import WORN_FROM
from makeup_video.web.server import Server
from makeup_video.web.session import HEAD, PhotoLook, ShownPicture
from makeup_video.web.slow_jobs import SlowJobs
from tls_socket import open_tls
from websockets.sync.client import connect


def as_read(look):
    """The estimate of a photo that surely shows this look."""
    return Estimate(look, {kind: 0.97 if look.of(kind) else 0.1 for kind in WORN_FROM})


RED = Look(lips=product((180, 0, 46), "satin"))
# With the default, httpx reads the certificates of all authorities for every request.
_NO_TLS = ssl.SSLContext(ssl.PROTOCOL_TLS_CLIENT)
BLUE = Look(lips=product((20, 0, 200), "gloss"))


class StandIn:
    """One session for all pages; the test pushes the pictures. `reads` reads photos."""

    mode = "demo"
    name = "stand-in"

    def __init__(self, mode="demo"):
        self.mode, self.look, self.push, self.compares = mode, RED, None, False
        self.watched = threading.Event()
        self.photos, self.portraits, self.latest_figures = [], [], None
        self.faces, self.recordings = [], []
        self.wanted, self.shown_again = None, 0
        self.reads = lambda photo, name: BLUE
        self.picture = self.photo = None
        self.thumbnail_of = lambda look: b"a face"

    def enter(self, name):
        return self

    def leave(self, session):
        pass

    def find(self, name):
        return self if name == self.name else None

    def set_look(self, look):
        self.look = look

    def watch(self, push):
        self.push = push
        (self.watched.clear if push is None else self.watched.set)()

    def compare(self, on):
        self.compares = on

    has_video = False

    def want(self, wanted):
        self.wanted = wanted

    def show_again(self):
        self.shown_again += 1

    def figures(self):
        return self.latest_figures

    def read(self, photo, name, face):
        self.photos.append((photo, name))
        self.faces.append(face)
        read = self.reads(photo, name)
        if isinstance(read, Look):
            read = PhotoLook(name, read, as_read(read).in_words(), lambda: b"a thumbnail")
        return read

    def take_portrait(self, photo, name):
        self.portraits.append((photo, name))

    @property
    def has_picture(self):
        return self.picture is not None

    def whole_picture(self, both):
        return self.picture if not both else np.hstack([self.picture // 2, self.picture])

    def record(self, on):
        self.recordings.append(on)

    def cameras(self):
        return {"names": ["a", "b"], "name": "a", "sizes": ["1x1"], "size": "1x1"}

    def choose_camera(self, name, size):
        self.chosen = name, size

    def portrait_thumbnail(self):
        return b"a portrait"

    def thumbnail(self, look):
        return self.thumbnail_of(look)

    def show(self, pts_us, jpeg=b"painted", before=b"bare"):
        assert self.watched.wait(10)
        self.push(ShownPicture(pts_us, 90, jpeg, before))


@contextmanager
def serving(show, slow_jobs=None, **options) -> Generator[str, None, None]:
    """The page's address, without the final slash."""
    log = options.pop("log", [])
    server = Server(show, slow_jobs or SlowJobs(), log=log.append, **options)
    try:
        yield server.start().rstrip("/")
    finally:
        server.stop()


class Page:
    """A page without a screen: sends its hello, and reads messages and pictures on request."""

    def __init__(self, url, session="", tls=None):
        """tls: the certificates that the page trusts, for an address with https."""
        self.url = url
        self._stack = ExitStack()
        where = f"{url.replace('http', 'ws')}/ws?session={session}"
        options = {"origin": url, "compression": None, "max_size": None, "close_timeout": 1}
        self.socket = self._stack.enter_context(
            open_tls(where, tls, **options) if tls else connect(where, **options)
        )
        self.hello = self.message("hello", "error")

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def close(self):
        self._stack.close()

    def send(self, kind, **values):
        self.socket.send(json.dumps({"type": kind, **values}))

    def message(self, *kinds):
        """The next message of one of these types; skips others, and pictures."""
        while True:
            got = self.socket.recv(timeout=10)
            if isinstance(got, str):
                values = json.loads(got)
                if values["type"] in kinds:
                    return values

    def picture(self, shown=True):
        """(pts_us, rotation, jpeg, before) of the next picture; skips messages."""
        while isinstance(got := self.socket.recv(timeout=10), str):
            pass
        pts_us, rotation, flags, size, size_before = HEAD.unpack_from(got)
        assert flags == 0 and len(got) == HEAD.size + size + size_before
        if shown:
            self.send("shown", pts_us=pts_us)
        jpeg = got[HEAD.size : HEAD.size + size]
        return pts_us, rotation, jpeg, got[HEAD.size + size :]

    def post(self, where, data, **headers):
        return post(self.url, f"{where}?session={self.hello['session']}", data, **headers)


def get(url):
    return httpx.get(url, verify=_NO_TLS)


def post(url, where, data, timeout_s=30, **headers):
    """headers: names have _ for -; None leaves the header out."""
    given = {"origin": url, **{name.replace("_", "-"): value for name, value in headers.items()}}
    given = {name: value for name, value in given.items() if value is not None}
    return httpx.post(url + where, content=data, headers=given, timeout=timeout_s, verify=_NO_TLS)


def stalled(url):
    """A socket that opens a WebSocket but never reads."""
    parts = urlsplit(url)
    raw = socket.create_connection((parts.hostname, parts.port))
    raw.setsockopt(socket.SOL_SOCKET, socket.SO_RCVBUF, 4096)
    raw.sendall(
        f"GET /ws HTTP/1.1\r\nHost: {parts.netloc}\r\nOrigin: {url}\r\nUpgrade: websocket\r\n"
        "Connection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
        "Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\n\r\n".encode()
    )
    return raw


def noise(size):
    return np.random.default_rng(size).bytes(size)
