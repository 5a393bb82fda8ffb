"""One page that watches: what the page is sent, and when.

A page is sent the newest picture whenever few enough are on their way to its screen, and never sees
the others. However slow a page is, the server keeps only a few pictures and texts for it, and
nothing waits for the page.
"""

import asyncio
import statistics
import time
from collections import deque

from makeup_video.web.messages import error_message
from makeup_video.web.session import Packet, ShownPicture, VideoPicture

# Pictures on their way to a page. JPEG: one picture is being shown while another one is sent, so no
# picture waits for an acknowledgement.
IN_FLIGHT = 2
# H.264: a page that is 100 ms away still gets 30 pictures a second. Nothing is encoded that no page
# can take, so a single page misses no picture and needs no key frame.
VIDEO_IN_FLIGHT = 3
_TIMED = 60  # pictures over which the median of the delay is taken


class Viewer:
    """What one page will be sent. Used only on the server's loop."""

    def __init__(self, first: str) -> None:
        self.comparing = self.is_video = False
        self.seen: int | None = None  # the page's own count of its newest look that has arrived
        # the newest text of each kind, in the order in which they came
        self._texts: dict[str, str] = {"hello": first}
        self._errors: deque[str] = deque(maxlen=4)
        self._picture: ShownPicture | None = None
        self._is_unserved = True  # the page still waits for a first picture of the chosen kind
        self._packets: deque[tuple[int, bytes]] = deque()  # pts_us and the message
        self._chain = _Chain()
        self._in_flight: deque[int] = deque()
        self._late_ms: deque[float] = deque(maxlen=_TIMED)
        self._has_news = asyncio.Event()
        self._has_news.set()
        self._is_ending = False
        self._sent_text = False  # the last message was a text

    @property
    def screen_ms(self) -> float | None:
        """Delay from camera to screen in ms, the median of about the last two seconds."""
        return round(statistics.median(self._late_ms), 1) if self._late_ms else None

    @property
    def has_room(self) -> bool:
        """Whether a page that watches H.264 can take another picture."""
        return len(self._in_flight) + len(self._packets) < VIDEO_IN_FLIGHT

    @property
    def needs_key(self) -> bool:
        """Whether a page that watches H.264 needs a key frame to show what it wants."""
        return self.is_video and (self._chain.is_broken or self._chain.lacks_before)

    @property
    def is_starving(self) -> bool:
        """Whether the page waits for a picture of its kind, and would take one now."""
        return (self.needs_key and self.has_room) if self.is_video else self._is_unserved

    def choose(self, is_video: bool) -> None:
        """Send H.264 from now on, or JPEG. Pictures on their way no longer count."""
        self.is_video, self._is_unserved, self._picture = is_video, True, None
        self._packets.clear()
        self._in_flight.clear()
        self._chain = _Chain()

    def offer(self, picture: ShownPicture) -> None:
        """Take a picture if the page can show it now.

        A JPEG replaces the JPEG that waits. H.264 that finds no room breaks the chain: the page
        then waits for a key frame.
        """
        if self.is_video:
            video = picture.video
            if video is None:
                return
            if not self.has_room:
                self._chain.is_broken = True
            elif self._chain.takes(video, self.comparing):
                message = picture.packed_video(self._chain.sends_before)
                self._packets.append((picture.pts_us, message))
        elif picture.jpeg is not None:
            self._picture, self._is_unserved = picture, False
        self._has_news.set()

    def queue(self, kind: str, text: str) -> None:
        """Send a text soon, after those that wait. An older text of this kind is dropped."""
        self._texts.pop(kind, None)
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
        """Note that a picture is on the screen. No older picture is on its way any longer."""
        if pts_us not in self._in_flight:
            return
        self._late_ms.append((time.monotonic_ns() // 1000 - pts_us) / 1000)
        while self._in_flight.popleft() != pts_us:
            pass
        self._has_news.set()

    async def next(self) -> str | bytes | None:
        """Wait for the next message to be sent; None after `end`."""
        while (message := self._take()) is None and not self._is_ending:
            self._has_news.clear()
            await self._has_news.wait()
        return message

    def _take(self) -> str | bytes | None:
        """The next message to send; None when no message waits.

        Texts and pictures take turns. Otherwise pictures would never get their turn while another
        page drags a slider, since a text then waits all the time.
        """
        message: str | bytes | None = self._take_picture() if self._sent_text else None
        message = message or self._take_text() or self._take_picture()
        self._sent_text = isinstance(message, str)
        return message

    def _take_text(self) -> str | None:
        if self._texts:
            return self._texts.pop(next(iter(self._texts)))
        return self._errors.popleft() if self._errors else None

    def _take_picture(self) -> bytes | None:
        if self._is_ending:
            return None
        if self._picture is not None and len(self._in_flight) < IN_FLIGHT:
            picture, self._picture = self._picture, None
            self._in_flight.append(picture.pts_us)
            return picture.packed(self.comparing)
        if self._packets:
            pts_us, message = self._packets.popleft()
            self._in_flight.append(pts_us)
            return message
        return None


class _Chain:
    """Which packets of H.264 a page has: the next packet is of use only if none is missing.

    is_broken: only a key frame is of use.  sends_before: the pictures without makeup are sent, too.
    lacks_before: the pictures without makeup should be sent, but a key frame must come first.
    """

    def __init__(self) -> None:
        self.is_broken, self.sends_before, self.lacks_before = True, False, False
        self._number = 0

    def takes(self, video: VideoPicture, compares: bool) -> bool:
        """Whether the page can decode these packets. If so, notes that they are sent."""
        has_gap = self.is_broken or video.number != self._number + 1
        if has_gap and not video.painted[1]:
            self.is_broken = True
            return False
        self._number, self.is_broken = video.number, False
        can_send = compares and video.before is not None
        continues = self.sends_before and not has_gap
        self.sends_before = can_send and (continues or _is_key(video.before))
        # another page compares already, and this page has missed the start of that stream
        self.lacks_before = can_send and not self.sends_before
        return True


def _is_key(packet: Packet | None) -> bool:
    return packet is not None and packet[1]
