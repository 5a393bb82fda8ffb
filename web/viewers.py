"""One page that watches, and the room of all pages that watch one session.

A page is sent the newest picture whenever fewer than two pictures are on their way to its screen,
and never sees the others. However slow a page is, the server keeps at most one picture and a few
texts for it, and nothing waits for the page.
"""

import asyncio
import statistics
import time
from collections import deque
from collections.abc import Callable

from makeup_video.pipeline.errors import LookError, MakeupVideoError
from makeup_video.pipeline.look.look import Look
from makeup_video.web.messages import (
    CompareRequest,
    LookRequest,
    PictureShown,
    error_message,
    figures_message,
    look_message,
    read_message,
)
from makeup_video.web.session import PhotoLook, Session, ShownPicture

# Least time between two looks that are read: a page may send one at every refresh of its screen.
# Of faster looks only the newest of each page is read and painted, which takes about 0.1 ms.
LOOKS_SECONDS = 0.01
IN_FLIGHT = 2  # one at the screen, one on its way: no picture waits for an acknowledgement
FIGURES_SECONDS = 0.5
_TIMED = 60  # pictures over which the delay is measured


class Viewer:
    """What one page will be sent. Used on the server's loop alone."""

    def __init__(self, first: str) -> None:
        self.comparing = False
        self.seen: int | None = None  # the newest of its own looks, as it counts them
        # by kind: only the newest look and the newest figures matter
        self._texts: dict[str, str] = {"hello": first}
        self._errors: deque[str] = deque(maxlen=4)
        self._picture: ShownPicture | None = None
        self._in_flight: deque[int] = deque()
        self._late_ms: deque[float] = deque(maxlen=_TIMED)
        self._has_news = asyncio.Event()
        self._has_news.set()
        self._is_ending = False

    @property
    def screen_ms(self) -> float | None:
        """Delay from camera to screen, the median of about the last two seconds."""
        return round(statistics.median(self._late_ms), 1) if self._late_ms else None

    def offer(self, picture: ShownPicture) -> None:
        """Replace the picture that waits by the newest one."""
        self._picture = picture
        self._has_news.set()

    def queue(self, kind: str, text: str) -> None:
        """Send a text soon, in the place of one of its kind that waits."""
        self._texts[kind] = text
        self._has_news.set()

    def queue_error(self, text: str) -> None:
        """Send an error message soon."""
        self._errors.append(error_message(text))
        self._has_news.set()

    def end(self) -> None:
        """Let `next` return None once all texts are sent."""
        self._is_ending = True
        self._has_news.set()

    def shown(self, pts_us: int) -> None:
        """Note that a picture is on the screen; those before it are, too, or never will be."""
        if pts_us not in self._in_flight:
            return
        self._late_ms.append((time.monotonic_ns() // 1000 - pts_us) / 1000)
        while self._in_flight.popleft() != pts_us:
            pass
        self._has_news.set()

    async def next(self) -> str | bytes | None:
        """Wait for the next message to be sent; None after `end`."""
        while True:
            if self._texts:
                return self._texts.pop(next(iter(self._texts)))
            if self._errors:
                return self._errors.popleft()
            if self._is_ending:
                return None
            if self._picture is not None and len(self._in_flight) < IN_FLIGHT:
                picture, self._picture = self._picture, None
                self._in_flight.append(picture.pts_us)
                return picture.packed(self.comparing)
            self._has_news.clear()
            await self._has_news.wait()


class Room:
    """All pages that watch one session: the others see what one of them changes."""

    def __init__(self, session: Session, loop: asyncio.AbstractEventLoop) -> None:
        self.session = session
        self.viewers: set[Viewer] = set()
        self._loop = loop
        self._newest: ShownPicture | None = None
        self._is_delivery_due = False
        self._figures_timer: asyncio.TimerHandle | None = None
        # the newest look of each page, in the order in which they came
        self._requests: dict[Viewer, LookRequest] = {}
        self._paint_timer: asyncio.TimerHandle | None = None  # reads and paints the requests
        self._next_paint = 0.0  # the earliest time for that, by the loop's clock

    def add(self, viewer: Viewer) -> None:
        """Let a page watch."""
        self.viewers.add(viewer)
        if len(self.viewers) == 1:
            self.session.watch(self._push)
            self._send_figures()
        elif self._newest is not None:
            viewer.offer(self._newest)

    def remove(self, viewer: Viewer) -> None:
        """Let a page leave."""
        self._paint_requests()  # the last look of a page counts even after the page has left
        self.viewers.discard(viewer)
        if self.viewers:
            self.session.compare(any(other.comparing for other in self.viewers))
            return
        self.session.watch(None)
        self.session.compare(False)
        self._newest = None
        if self._figures_timer is not None:
            self._figures_timer.cancel()

    def receive(self, viewer: Viewer, text: str) -> None:
        """Handle a page's message. Its errors go to that page alone."""
        try:
            request = read_message(text)
        except MakeupVideoError as error:
            viewer.queue_error(str(error))
            return
        match request:
            case PictureShown(pts_us):
                viewer.shown(pts_us)
            case CompareRequest(on):
                viewer.comparing = on
                self.session.compare(any(other.comparing for other in self.viewers))
                if on and self._newest is not None and self._newest.before is not None:
                    viewer.offer(
                        self._newest
                    )  # another page compares already, and no new picture may come
            case LookRequest():
                # to the end of the queue: the last look wins over those of other pages, too
                self._requests[viewer] = request.after(self._requests.pop(viewer, None))
                if self._paint_timer is None:
                    self._paint_timer = self._loop.call_at(self._next_paint, self._paint_requests)

    def change(self, look: Look, photo: PhotoLook) -> None:
        """Paint the look that has just been read from a photo, and send it to all pages."""
        self._paint_requests()  # the looks that came before
        self.session.photo = photo
        self._paint(look, photo)

    def _paint_requests(self) -> None:
        """Read and paint the looks that wait, in the order in which they came."""
        if self._paint_timer is None:
            return
        self._paint_timer.cancel()
        self._paint_timer, requests, self._requests = None, self._requests, {}
        self._next_paint = self._loop.time() + LOOKS_SECONDS
        for viewer, request in requests.items():
            if request.n is not None:
                viewer.seen = request.n
            try:
                look = request.look
            except LookError as error:  # the page returns to the look that is painted
                viewer.queue_error(str(error))
                viewer.queue("look", look_message(self.session.look, None, viewer.seen))
                continue
            # a page does not know the defaults of a look from a file, so it gets the look, too
            self._paint(look, None, viewer if request.is_counted else None)

    def _paint(self, look: Look, photo: PhotoLook | None, by: Viewer | None = None) -> None:
        """Paint a look from now on, and send it to all pages but `by`, which has it."""
        self.session.set_look(look)
        for viewer in self.viewers:
            if viewer is not by:
                viewer.queue("look", look_message(look, photo, viewer.seen))

    def _push(self, picture: ShownPicture) -> None:
        """Take a picture, on any thread. The newest wins, and the loop is woken once for it."""
        self._newest = picture
        if not self._is_delivery_due:
            self._is_delivery_due = True
            _on_loop(self._loop, self._deliver)

    def _deliver(self) -> None:
        self._is_delivery_due = False
        picture = self._newest
        if picture is not None:
            for viewer in self.viewers:
                viewer.offer(picture)

    def _send_figures(self) -> None:
        if (values := self.session.figures()) is not None:
            for viewer in self.viewers:
                text = figures_message(values, len(self.viewers), viewer.screen_ms)
                viewer.queue("figures", text)
        self._figures_timer = self._loop.call_later(FIGURES_SECONDS, self._send_figures)


def _on_loop(loop: asyncio.AbstractEventLoop, call: Callable[[], None]) -> None:
    try:
        loop.call_soon_threadsafe(call)
    except RuntimeError:  # the server has ended
        return
