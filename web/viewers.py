"""One page that watches, and the room of all that watch one session.

A page is sent the newest picture whenever fewer than two are on their way to its screen; what comes
in between it never sees. It holds one picture and a few texts at most, however slow it is, and
nobody waits for it.
"""

import asyncio
import statistics
import time
from collections import deque
from collections.abc import Callable

from makeup_video.pipeline.errors import LookError, MakeupVideoError
from makeup_video.pipeline.look.look import Look
from makeup_video.web.messages import (
    Compare,
    LookWanted,
    Shown,
    error_message,
    figures_message,
    look_message,
    read_message,
)
from makeup_video.web.session import PhotoLook, Session, ShownPicture

# Looks are read at most so often; a page sends one for each refresh of its screen. Of looks that come
# quicker, only the newest of each page is read and painted, which takes about 0.1 ms.
LOOKS_SECONDS = 0.01
IN_FLIGHT = 2  # one on the screen's side, one on its way: the picture never waits for an answer
FIGURES_SECONDS = 0.5
_TIMED = 60  # so many pictures tell the delay


class Viewer:
    """What one page is to be sent. All on the server's loop."""

    def __init__(self, first: str) -> None:
        self.comparing = False
        self.seen: int | None = None  # the newest of its own looks, as it counts them
        # by kind: of a look or of figures only the newest is of interest
        self._texts: dict[str, str] = {"hello": first}
        self._errors: deque[str] = deque(maxlen=4)
        self._picture: ShownPicture | None = None
        self._in_flight: deque[int] = deque()
        self._late_ms: deque[float] = deque(maxlen=_TIMED)
        self._news = asyncio.Event()
        self._news.set()
        self._leaving = False

    @property
    def screen_ms(self) -> float | None:
        """From camera to screen, the median of the last two seconds or so."""
        return round(statistics.median(self._late_ms), 1) if self._late_ms else None

    def offer(self, picture: ShownPicture) -> None:
        """This is the newest; one that was not sent yet is of no interest any more."""
        self._picture = picture
        self._news.set()

    def tell(self, kind: str, text: str) -> None:
        self._texts[kind] = text
        self._news.set()

    def tell_error(self, text: str) -> None:
        self._errors.append(error_message(text))
        self._news.set()

    def say_bye(self) -> None:
        self._leaving = True
        self._news.set()

    def shown(self, pts_us: int) -> None:
        """It is on the screen, and so are those before it, or never will be."""
        if pts_us not in self._in_flight:
            return
        self._late_ms.append((time.monotonic_ns() // 1000 - pts_us) / 1000)
        while self._in_flight.popleft() != pts_us:
            pass
        self._news.set()

    async def next(self) -> str | bytes | None:
        """What is to be sent now; waits for it. None after the goodbye."""
        while True:
            if self._texts:
                return self._texts.pop(next(iter(self._texts)))
            if self._errors:
                return self._errors.popleft()
            if self._leaving:
                return None
            if self._picture is not None and len(self._in_flight) < IN_FLIGHT:
                picture, self._picture = self._picture, None
                self._in_flight.append(picture.pts_us)
                return picture.packed(self.comparing)
            self._news.clear()
            await self._news.wait()


class Room:
    """All who watch one session: what one changes, the others see."""

    def __init__(self, session: Session, loop: asyncio.AbstractEventLoop) -> None:
        self.session = session
        self.viewers: set[Viewer] = set()
        self._loop = loop
        self._newest: ShownPicture | None = None
        self._due = False
        self._timer: asyncio.TimerHandle | None = None
        self._wanted: dict[
            Viewer, LookWanted
        ] = {}  # the newest look of each page, the last one last
        self._turn: asyncio.TimerHandle | None = None  # when those are read
        self._next_turn = 0.0  # not before this, in the loop's time

    def join(self, viewer: Viewer) -> None:
        self.viewers.add(viewer)
        if len(self.viewers) == 1:
            self.session.watch(self._push)
            self._tell_figures()
        elif self._newest is not None:
            viewer.offer(self._newest)

    def part(self, viewer: Viewer) -> None:
        self._take_turn()  # the last look of a page counts, even when the page is gone
        self.viewers.discard(viewer)
        if self.viewers:
            self.session.compare(any(one.comparing for one in self.viewers))
            return
        self.session.watch(None)
        self.session.compare(False)
        self._newest = None
        if self._timer is not None:
            self._timer.cancel()

    def hear(self, viewer: Viewer, text: str) -> None:
        """What a page says; what is wrong with it is told to that page alone."""
        try:
            wish = read_message(text)
        except MakeupVideoError as error:
            viewer.tell_error(str(error))
            return
        match wish:
            case Shown(pts_us):
                viewer.shown(pts_us)
            case Compare(on):
                viewer.comparing = on
                self.session.compare(any(one.comparing for one in self.viewers))
                if on and self._newest is not None and self._newest.before is not None:
                    viewer.offer(self._newest)  # others compare already, and no new one may come
            case LookWanted():
                # to the end of the line: who spoke last wins over the other pages, too
                self._wanted[viewer] = wish.after(self._wanted.pop(viewer, None))
                if self._turn is None:
                    self._turn = self._loop.call_at(self._next_turn, self._take_turn)

    def change(self, look: Look, photo: PhotoLook) -> None:
        """Paint the look that has just been read from this photo, and tell all pages."""
        self._take_turn()  # of the looks that came before it
        self.session.photo = photo
        self._paint(look, photo)

    def _take_turn(self) -> None:
        """Read and paint the looks that wait, in the order in which they came."""
        if self._turn is None:
            return
        self._turn.cancel()
        self._turn, wanted, self._wanted = None, self._wanted, {}
        self._next_turn = self._loop.time() + LOOKS_SECONDS
        for viewer, wish in wanted.items():
            if wish.n is not None:
                viewer.seen = wish.n
            try:
                look = wish.look
            except LookError as error:  # the page shows again what is painted
                viewer.tell_error(str(error))
                viewer.tell("look", look_message(self.session.look, None, viewer.seen))
                continue
            # of a look from a file the page itself does not know yet what it means
            self._paint(look, None, viewer if wish.is_counted else None)

    def _paint(self, look: Look, photo: PhotoLook | None, by: Viewer | None = None) -> None:
        """From now on; and tell all pages but the one that knows already."""
        self.session.set_look(look)
        for viewer in self.viewers:
            if viewer is not by:
                viewer.tell("look", look_message(look, photo, viewer.seen))

    def _push(self, picture: ShownPicture) -> None:
        """From any thread: the newest picture wins, and the loop is woken once for it."""
        self._newest = picture
        if not self._due:
            self._due = True
            _on_loop(self._loop, self._deliver)

    def _deliver(self) -> None:
        self._due = False
        picture = self._newest
        if picture is not None:
            for viewer in self.viewers:
                viewer.offer(picture)

    def _tell_figures(self) -> None:
        if (values := self.session.figures()) is not None:
            for viewer in self.viewers:
                text = figures_message(values, len(self.viewers), viewer.screen_ms)
                viewer.tell("figures", text)
        self._timer = self._loop.call_later(FIGURES_SECONDS, self._tell_figures)


def _on_loop(loop: asyncio.AbstractEventLoop, what: Callable[[], None]) -> None:
    try:
        loop.call_soon_threadsafe(what)
    except RuntimeError:  # the server has ended, and nobody watches any more
        return
