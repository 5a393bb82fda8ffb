"""H.264 for pages: whatever a page does, it can decode every packet that it is sent."""

import asyncio
import itertools

from hypothesis import given, settings
from hypothesis import strategies as st
from loops import Loop
from makeup_video.web.room import FIGURES_SECONDS, Room
from makeup_video.web.session import (
    HEAD,
    IS_VIDEO,
    KEY,
    KEY_BEFORE,
    ShownPicture,
    VideoPicture,
    Wanted,
)
from makeup_video.web.viewer import VIDEO_IN_FLIGHT, Viewer
from shows import StandIn

LOOP = asyncio.new_event_loop()  # of the events of viewers


class Live(StandIn):
    """A session that encodes as `PreviewSink` does: packets name their number and the one before
    them in their stream, which a decoder needs."""

    has_video = True

    def __init__(self):
        super().__init__()
        self.pts, self.number, self.last_painted, self.last_before = 0, 0, 0, 0

    def next_picture(self, allows_key=True):
        """A new frame comes: its picture as it is wanted, or None."""
        self.pts += 1
        wanted = self.wanted
        if not (wanted.jpeg or wanted.video):
            return None
        video = self.packets(wanted.key and allows_key) if wanted.video else None
        return ShownPicture(self.pts, 0, b"jpeg" if wanted.jpeg else None, None, video)

    def packets(self, key):
        self.number += 1
        painted = self.packet(self.last_painted, key)
        self.last_painted = self.number
        before = None
        if self.compares:
            before = self.packet(self.last_before, key)
        self.last_before = self.number if self.compares else 0
        return VideoPicture(self.number, painted, before)

    def packet(self, last, key):
        is_key = key or last == 0
        return b"%d %d" % (self.number, 0 if is_key else last), is_key

    def show_again(self):
        super().show_again()
        self.push(self.next_picture())


class Page:
    """A page with two decoders; `is_slow`: it acknowledges only when the test says so."""

    def __init__(self, room, is_video=True):
        self.room, self.viewer = room, Viewer("hello")
        self.painted = self.before = None  # number of the last packet that was decoded
        self.unacknowledged, self.shown, self.jpegs, self.shown_before = [], 0, 0, 0
        room.add(self.viewer)
        if is_video:
            self.send("video", on=True)

    def send(self, kind, **values):
        values = ", ".join(f'"{key}": {str(one).lower()}' for key, one in values.items())
        self.room.receive(self.viewer, f'{{"type": "{kind}", {values}}}')

    def receive(self):
        """Take every message that the server would send now."""
        while isinstance(message := LOOP.run_until_complete(self.next()), bytes | str):
            if isinstance(message, bytes):
                self.decode(message)

    async def next(self):
        waiting = asyncio.ensure_future(self.viewer.next())
        await asyncio.sleep(0)
        return waiting.result() if waiting.done() else waiting.cancel()

    def decode(self, message):
        pts, _, flags, size, size_before = HEAD.unpack_from(message)
        self.unacknowledged.append(pts)
        parts = message[HEAD.size :]
        if not flags & IS_VIDEO:
            self.jpegs += 1
            return
        assert len(self.unacknowledged) <= VIDEO_IN_FLIGHT
        self.painted = self.decoded(parts[:size], self.painted, flags & KEY)
        if size_before:
            self.before = self.decoded(parts[size:], self.before, flags & KEY_BEFORE)
            self.shown_before += 1
        self.shown += 1

    @staticmethod
    def decoded(packet, last, is_key):
        number, needed = map(int, packet.split())
        assert (needed == 0) == bool(is_key)
        assert needed in (0, last)
        return number

    def acknowledge(self):
        for pts in self.unacknowledged:
            self.send("shown", pts_us=pts)
        self.unacknowledged.clear()


def room_of(session):
    loop = Loop()
    return Room(session, loop), loop


STEPS = st.lists(
    st.sampled_from(
        ["frame"] * 6
        + [
            "no key",
            "late",
            *(["acknowledge", "compare", "plain", "video", "jpeg", "join", "leave"] * 2),
        ]
    ),
    max_size=60,
)


@settings(max_examples=200, deadline=None)
@given(steps=STEPS, choices=st.lists(st.integers(0, 2), min_size=60, max_size=60))
def test_every_packet_can_be_decoded(steps, choices):
    session = Live()
    room, _ = room_of(session)
    pages = [Page(room)]
    actions = {
        "acknowledge": Page.acknowledge,
        "compare": lambda page: page.send("compare", on=True),
        "plain": lambda page: page.send("compare", on=False),
        "video": lambda page: page.send("video", on=True),
        "jpeg": lambda page: page.send("video", on=False),
    }
    for step, choice in zip(steps, choices, strict=False):
        if step in ("frame", "no key", "late"):
            if picture := session.next_picture(step != "no key"):
                session.push(picture)
        elif step == "join" and len(pages) < 3:
            pages.append(Page(room))
        elif step == "leave" and len(pages) > 1:
            room.remove(pages.pop().viewer)
        elif step in actions:
            page = pages[choice % len(pages)]
            if step in ("video", "jpeg"):
                page.unacknowledged.clear()
            actions[step](page)
        for page in () if step == "late" else pages:
            page.receive()
    # in the end every page shows pictures again
    for page in pages:
        page.send("video", on=True)
        page.unacknowledged.clear()
    seen = [page.shown for page in pages]
    for _ in range(4):
        session.push(session.next_picture())
        for page in pages:
            page.receive()
            page.acknowledge()
    assert all(page.shown >= was + 3 for page, was in zip(pages, seen, strict=True))


def test_a_single_page_misses_no_packet_however_slow():
    session = Live()
    room, _ = room_of(session)
    page = Page(room)
    keys = 0
    for number in range(30):
        if picture := session.next_picture():
            keys += picture.video.painted[1]
            session.push(picture)
        page.receive()
        if number % 7 == 0:
            page.acknowledge()
    assert keys == 1 and page.shown == session.number
    assert session.number <= 3 * 6  # nothing was encoded that the page could not take


def test_pictures_and_texts_take_turns():
    viewer = Viewer("hello")
    got = []
    for number in range(6):  # another page drags a slider: a look waits at any time
        for kind in ("look", "figures"):
            viewer.queue(kind, f"{kind} {number}")
        viewer.offer(ShownPicture(number, 0, b"jpeg"))
        got.append(LOOP.run_until_complete(viewer.next()))
        viewer.shown(number)
    assert [isinstance(one, str) for one in got] == [True, False] * 3
    assert got[0] == "hello"
    viewer.offer(ShownPicture(6, 0, b"jpeg"))  # of no use to a page that is told to go
    viewer.end()
    last = [LOOP.run_until_complete(viewer.next()) for _ in range(3)]
    assert sorted(last[:2]) == ["figures 5", "look 5"] and last[2] is None


def test_a_slow_page_costs_a_fast_one_no_picture():
    session = Live()
    room, _ = room_of(session)
    fast, slow = Page(room), Page(room)
    for number in range(40):
        session.push(session.next_picture())
        for page in (fast, slow):
            page.receive()
        fast.acknowledge()
        if number % 8 == 7:
            slow.acknowledge()
    assert fast.shown == 40
    assert slow.shown >= 3 * 5


def test_a_page_that_compares_beside_another_gets_both():
    session = Live()
    room, _ = room_of(session)
    pages = [Page(room), Page(room)]
    for page in pages:
        page.send("compare", on=True)
        for _ in range(3):
            session.push(session.next_picture())
            for one in pages:
                one.receive()
                one.acknowledge()
    assert pages[0].shown == pages[1].shown == 6  # neither page's picture stood still
    assert pages[0].shown_before == 6 and pages[1].shown_before >= 2


def test_jpeg_and_h264_pages_watch_side_by_side():
    session = Live()
    room, _ = room_of(session)
    jpeg, video = Page(room, is_video=False), Page(room)
    for _ in range(5):
        assert session.wanted.jpeg and session.wanted.video
        session.push(session.next_picture())
        for page in (jpeg, video):
            page.receive()
            page.acknowledge()
    assert (jpeg.jpegs, video.shown) == (5, 5)
    room.remove(jpeg.viewer)
    assert not session.wanted.jpeg
    video.send("video", on=False)  # its decoder failed
    session.push(session.next_picture())
    video.receive()
    assert video.jpegs == 1 and session.wanted == Wanted()


def test_pages_get_jpeg_once_the_encoder_has_failed():
    session = Live()
    room, _ = room_of(session)
    page = Page(room)
    session.has_video = False
    session.push(ShownPicture(1, 0, None))
    assert session.wanted == Wanted()
    session.push(session.next_picture())
    page.receive()
    assert page.jpegs == 1


def test_a_page_that_joins_a_still_picture_is_sent_it():
    session = Live()
    room, loop = room_of(session)
    first = Page(room)
    session.push(session.next_picture())
    first.receive()
    first.acknowledge()
    late = [Page(room), Page(room, is_video=False)]
    for _ in itertools.repeat(None, 4):  # the camera is gone: no new picture comes
        loop.go_on(FIGURES_SECONDS)
        for page in (first, *late):
            page.receive()
            page.acknowledge()
    assert late[0].shown >= 1 and late[1].jpegs >= 1
    assert session.shown_again <= 2


def test_a_page_that_compares_awaits_no_key_for_nothing():
    viewer = Viewer("hello")
    viewer.choose(True)
    viewer.comparing = True
    viewer.offer(ShownPicture(1, 0, None, None, VideoPicture(1, (b"", True), None)))
    assert not viewer.needs_key
