"""The show without a camera: each page has its own portrait and look."""

import asyncio
import secrets
import time
from collections.abc import Callable
from typing import Literal

import numpy as np
from makeup_video.pipeline.errors import MakeupVideoError, UsageError
from makeup_video.pipeline.look.look import Look
from makeup_video.web.portrait import Portrait
from makeup_video.web.read_apart import read_apart
from makeup_video.web.read_look import read_look
from makeup_video.web.session import (
    PhotoLook,
    Push,
    Session,
    SeveralFaces,
    ShownPicture,
    Wanted,
)
from makeup_video.web.slow_jobs import SlowJobs

MOST_SESSIONS = 16
GRACE_SECONDS = 30.0  # how long the session of a page that lost its connection is kept


class DemoSession:
    """One page's portrait and look. While a look is painted, only the newest later look waits."""

    has_video = False  # single pictures are sent, as JPEG in full chroma

    def __init__(
        self,
        portrait: Portrait,
        look: Look,
        photo: PhotoLook | None,
        slow_jobs: SlowJobs,
        log: Callable[[str], None],
    ) -> None:
        self.name = secrets.token_urlsafe(16)
        self.look, self.photo = look, photo
        self._portrait, self._slow_jobs, self._log = portrait, slow_jobs, log
        self._push: Push | None = None
        self._compares = False
        self._chosen_us = _now_us()
        self._is_due = False

    def set_look(self, look: Look) -> None:
        if look != self.look:
            self.look, self._chosen_us = look, _now_us()
            self._paint_soon()

    def watch(self, push: Push | None) -> None:
        self._push = push
        self._chosen_us = _now_us()
        self._paint_soon()

    def compare(self, on: bool) -> None:
        was, self._compares = self._compares, on
        if on and not was:
            self._chosen_us = _now_us()
            self._paint_soon()

    def want(self, wanted: Wanted) -> None:
        """Do nothing: every picture is a JPEG."""

    def show_again(self) -> None:
        """Do nothing: every page has been sent the newest picture."""

    def figures(self) -> None:
        return None

    def read(self, photo: bytes, name: str, face: str) -> PhotoLook | SeveralFaces:
        return read_look(photo, name, face)

    def take_portrait(self, photo: bytes, name: str) -> None:
        self._portrait = Portrait(read_apart(photo, name), name)
        self._chosen_us = _now_us()
        self._paint_soon()

    def record(self, on: bool) -> None:
        raise UsageError("only a camera is recorded: see makeup-video live")

    def cameras(self) -> dict[str, object]:
        return {}

    def choose_camera(self, name: str, size: str) -> None:
        raise UsageError("the demo has no camera: see makeup-video live")

    @property
    def has_picture(self) -> bool:
        return True

    def whole_picture(self, both: bool) -> np.ndarray:
        paint = self._portrait.painted_and_bare if both else self._portrait.painted_whole
        return paint(self.look)

    def thumbnail(self, look: Look) -> bytes:
        return self._portrait.thumbnail(look)

    def portrait_thumbnail(self) -> bytes:
        return self._portrait.small

    def _paint_soon(self) -> None:
        if not self._is_due and self._push is not None:
            self._is_due = True
            self._slow_jobs.submit(self._paint)

    def _paint(self) -> None:
        """Paint and push a picture, on the thread of slow jobs."""
        self._is_due = False  # a look that is set after this line needs another picture
        push, chosen_us, portrait = self._push, self._chosen_us, self._portrait
        if push is None:
            return
        try:
            jpeg = portrait.painted(self.look)
        except MakeupVideoError as error:
            self._log(f"{type(error).__name__}: {error}")
            return
        except Exception as error:  # noqa: BLE001  # otherwise the pool would swallow the error
            self._log(f"internal error while painting: {type(error).__name__}: {error}")
            return
        push(ShownPicture(chosen_us, 0, jpeg, portrait.bare if self._compares else None))


class DemoShow:
    """A session for each page, kept for a while after the page has left."""

    mode: Literal["demo"] = "demo"

    def __init__(
        self,
        portrait: Portrait,
        look: Look,
        slow_jobs: SlowJobs,
        log: Callable[[str], None],
        grace_seconds: float = GRACE_SECONDS,
        photo: PhotoLook | None = None,
    ) -> None:
        """portrait, look: what every session begins with.  photo: the look's source, if any."""
        self._portrait, self._look, self._slow_jobs, self._log = portrait, look, slow_jobs, log
        self._grace_seconds, self._photo = grace_seconds, photo
        self._sessions: dict[str, DemoSession] = {}
        self._left: dict[str, asyncio.TimerHandle] = {}  # in the order in which pages left

    def enter(self, name: str) -> DemoSession:
        if (session := self._sessions.get(name)) is not None:
            if (timer := self._left.pop(name, None)) is not None:
                timer.cancel()
            return session
        if len(self._sessions) >= MOST_SESSIONS:
            if not self._left:
                raise UsageError(f"{MOST_SESSIONS} pages are open already: close one, then reload")
            self._forget(next(iter(self._left)))
        session = DemoSession(self._portrait, self._look, self._photo, self._slow_jobs, self._log)
        self._sessions[session.name] = session
        return session

    def leave(self, session: Session) -> None:
        loop = asyncio.get_running_loop()
        self._left[session.name] = loop.call_later(self._grace_seconds, self._forget, session.name)

    def find(self, name: str) -> DemoSession | None:
        return self._sessions.get(name)

    def _forget(self, name: str) -> None:
        self._left.pop(name).cancel()
        del self._sessions[name]


def _now_us() -> int:
    return time.monotonic_ns() // 1000
