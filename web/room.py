"""The room of all pages that watch one session: they share its look and its pictures."""

import asyncio
from collections import deque
from collections.abc import Callable

from makeup_video.pipeline.errors import LookError, MakeupVideoError
from makeup_video.pipeline.look.look import Look
from makeup_video.web.messages import (
    CAMERA,
    CompareRequest,
    LookRequest,
    PictureShown,
    VideoRequest,
    figures_message,
    look_message,
    read_message,
    seen_message,
)
from makeup_video.web.session import PhotoLook, Session, ShownPicture, Wanted
from makeup_video.web.viewer import VIDEO_IN_FLIGHT, Viewer

# Least time between two readings of looks: a page may send a look at every refresh of its screen.
# When looks come faster, only the newest of each page is read and painted. That takes about 0.1 ms.
LOOKS_SECONDS = 0.01
FIGURES_SECONDS = 0.5


class Room:
    """All pages that watch one session: what one page changes, the others see."""

    def __init__(self, session: Session, loop: asyncio.AbstractEventLoop) -> None:
        self.session = session
        self.viewers: set[Viewer] = set()
        self._loop = loop
        self._newest: ShownPicture | None = None
        self._arrived: deque[ShownPicture] = deque(maxlen=VIDEO_IN_FLIGHT)
        self._arrived_at = loop.time()
        self._is_delivery_due = False
        self._wanted: Wanted | None = None
        self._figures_timer: asyncio.TimerHandle | None = None
        # the newest look of each page, in the order in which they came
        self._requests: dict[Viewer, LookRequest] = {}
        self._paint_timer: asyncio.TimerHandle | None = None  # reads and paints the requests
        self._next_paint = 0.0  # the earliest time for the next reading, by the loop's clock

    def add(self, viewer: Viewer) -> None:
        """Let a page watch."""
        self.viewers.add(viewer)
        self._want()
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
            self._want()
            return
        self.session.watch(None)
        self.session.compare(False)
        self._newest = None
        if self._figures_timer is not None:
            self._figures_timer.cancel()

    def receive(self, viewer: Viewer, text: str) -> None:
        """Handle a page's message. Errors go only to that page."""
        try:
            request = read_message(text)
        except MakeupVideoError as error:
            viewer.queue_error(str(error))
            return
        match request:
            case PictureShown(pts_us):
                viewer.shown(pts_us)
                self._want()
            case VideoRequest(on):
                viewer.choose(on and self.session.has_video)
                self._want()
                if self._newest is not None:
                    viewer.offer(self._newest)
            case CompareRequest(on):
                viewer.comparing = on
                self.session.compare(any(other.comparing for other in self.viewers))
                if on and self._newest is not None and self._newest.before is not None:
                    # another page compares already; offered now, since no new picture may come
                    viewer.offer(self._newest)
            case LookRequest():
                # goes to the end of the queue: the last look wins over those of other pages, too
                self._requests[viewer] = request.after(self._requests.pop(viewer, None))
                if self._paint_timer is None:
                    self._paint_timer = self._loop.call_at(self._next_paint, self._paint_requests)

    def change(self, look: Look, photo: PhotoLook) -> None:
        """Paint the look that has just been read from a photo, and send it to all pages."""
        self._paint_requests()  # the looks that came before
        self.session.photo = photo
        self._paint(look, photo)

    def announce_camera(self) -> None:
        """Let all pages show that another camera or size is used."""
        for viewer in self.viewers:
            viewer.queue("camera", CAMERA)

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
            # a page does not know the defaults of a look from a file, so this page gets the look
            self._paint(look, None, viewer if request.is_counted else None)

    def _paint(self, look: Look, photo: PhotoLook | None, by: Viewer | None = None) -> None:
        """Paint a look from now on, and send it to all pages but `by`, which has it already."""
        self.session.set_look(look)
        # the look of a photo has a kind of its own, so that no later look replaces the message
        kind = "look" if photo is None else "photo"
        for viewer in self.viewers:
            if viewer is by:
                viewer.queue("seen", seen_message(viewer.seen))
            else:
                viewer.queue(kind, look_message(look, photo, viewer.seen))

    def _push(self, picture: ShownPicture) -> None:
        """Take a picture, on any thread, and wake the loop once for all pictures that wait.

        The last few pictures are kept, since H.264 must be decoded without a gap.
        """
        self._arrived.append(picture)
        if not self._is_delivery_due:
            self._is_delivery_due = True
            _on_loop(self._loop, self._deliver)

    def _deliver(self) -> None:
        self._is_delivery_due = False
        if not self.viewers:  # the last page has left; another room may use the session now
            self._arrived.clear()
            return
        self._arrived_at = self._loop.time()
        while self._arrived:
            self._newest = self._arrived.popleft()
            for viewer in self.viewers:
                viewer.offer(self._newest)
        self._want()

    def _want(self) -> None:
        """Tell the session what the pages can use now."""
        if not self.session.has_video:  # never had it, or no longer since the encoder failed
            for viewer in self.viewers:
                if viewer.is_video:
                    viewer.choose(False)
        watching = [viewer for viewer in self.viewers if viewer.is_video]
        wanted = Wanted(
            jpeg=len(watching) < len(self.viewers),
            video=any(viewer.has_room for viewer in watching),
            key=any(viewer.needs_key and viewer.has_room for viewer in watching),
        )
        if wanted != self._wanted:
            self._wanted = wanted
            self.session.want(wanted)

    def _feed(self) -> None:
        """Send the newest picture again to pages that have had none, if no new picture comes, as
        from a camera that is gone."""
        if self._loop.time() - self._arrived_at > FIGURES_SECONDS and any(
            viewer.is_starving for viewer in self.viewers
        ):
            self._loop.run_in_executor(None, self.session.show_again)

    def _send_figures(self) -> None:
        self._feed()
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
