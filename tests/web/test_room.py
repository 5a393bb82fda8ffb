"""Looks of several pages in one room: the newest wins, few are parsed, and all pages end up
with the same look."""

import asyncio
import json
from dataclasses import replace

from hypothesis import given, settings
from hypothesis import strategies as st
from loops import Loop
from makeup_video.pipeline import Look
from makeup_video.web.room import LOOKS_SECONDS, Room
from makeup_video.web.session import PhotoLook, ShownPicture
from makeup_video.web.viewer import Viewer
from shows import BLUE, RED, StandIn

LOOKS = [replace(RED, strength=number / 10) for number in range(6)]
BAD = {"strength": "much"}


class Session(StandIn):
    """Records every look it gets."""

    def __init__(self):
        super().__init__()
        self.given = []

    def set_look(self, look):
        self.given.append(look)
        self.look = look


class Page:
    """A page that behaves like `look.js`: it counts its looks, and ignores a look from the server
    while the server has not seen the page's newest one."""

    def __init__(self, room):
        self.room, self.viewer = room, Viewer("{}")
        self.look, self.count, self.errors = room.session.look.to_dict(), 0, []
        self.confirmed, self.photos = 0, []
        room.add(self.viewer)

    def send_look(self, look):
        self.look, self.count = look, self.count + 1
        self.send(look=look, n=self.count)

    def send(self, **values):
        self.room.receive(self.viewer, json.dumps({"type": "look", **values}))

    def listen(self):
        """Read every message that waits for this page."""
        while (message := self._next()) is not None:
            if message.get("type") == "look" and self.count <= (message["seen"] or 0):
                self.look = message["look"]
            if message.get("type") == "look" and message["photo"]:
                self.photos.append(message["photo"]["name"])
            if message.get("type") == "seen":
                self.confirmed = message["seen"]
            if message.get("type") == "error":
                self.errors.append(message["text"])

    def _next(self):
        waiting = self.viewer.next()
        try:
            waiting.send(None)
        except StopIteration as got:
            return json.loads(got.value)
        waiting.close()  # no message waits
        return None


def in_a_room(test):
    """Call test(room, loop, pages) inside an asyncio loop."""

    async def called():
        loop = Loop()
        room = Room(Session(), loop)
        test(room, loop, [Page(room) for _ in range(3)])

    asyncio.run(called())


def test_only_the_newest_of_a_flood_of_looks_is_painted():
    def flood(room, loop, pages):
        for number in range(1000):
            pages[0].send_look(LOOKS[number % 6].to_dict())
        loop.go_on(0)
        assert room.session.given == [LOOKS[999 % 6]]
        assert pages[0].viewer.seen == 1000

    in_a_room(flood)


def test_looks_are_rate_limited_but_the_last_is_never_lost():
    def steady(room, loop, pages):
        for number in range(100):  # a look each millisecond
            pages[0].send_look(LOOKS[number % 6].to_dict())
            loop.go_on(0.001)
        assert len(room.session.given) <= 0.1 / LOOKS_SECONDS + 1
        loop.go_on(LOOKS_SECONDS)
        assert room.session.look == LOOKS[99 % 6]

    in_a_room(steady)


def test_the_first_look_after_a_pause_is_painted_at_once():
    def alone(room, loop, pages):
        for look in LOOKS:
            loop.go_on(LOOKS_SECONDS)
            pages[0].send_look(look.to_dict())
            loop.go_on(0)
            assert room.session.look == look

    in_a_room(alone)


def test_a_wrong_newest_look_is_answered_with_the_painted_one():
    def wrong(room, loop, pages):
        pages[0].send_look(LOOKS[1].to_dict())
        loop.go_on(1)
        for look in (LOOKS[2].to_dict(), BAD):
            pages[0].send_look(look)
        loop.go_on(1)
        for page in pages:
            page.listen()
        assert len(pages[0].errors) == 1 and not pages[1].errors
        assert pages[0].look == LOOKS[1].to_dict() and room.session.given == [LOOKS[1]]

    in_a_room(wrong)


def test_a_photo_wins_over_the_looks_that_came_before_it():
    def photo(room, loop, pages):
        pages[0].send_look(LOOKS[1].to_dict())
        loop.go_on(0)
        pages[0].send_look(LOOKS[2].to_dict())  # waits for its turn
        room.change(BLUE, PhotoLook("anna.jpg", BLUE, "lips #1400C8"))
        loop.go_on(1)
        for page in pages:
            page.listen()
            assert page.look == BLUE.to_dict()
        assert room.session.look == BLUE and room.session.photo.name == "anna.jpg"

    in_a_room(photo)


def test_a_look_after_a_photo_does_not_hide_the_photo():
    def photo(room, loop, pages):
        pages[0].send_look(LOOKS[1].to_dict())  # waits for the slow pages when the photo comes
        loop.go_on(1)
        room.change(BLUE, PhotoLook("anna.jpg", BLUE, "lips #1400C8"))
        pages[0].send_look(LOOKS[2].to_dict())
        loop.go_on(1)
        for page in pages:
            page.listen()
            assert page.photos == ["anna.jpg"]
            assert page.look == LOOKS[2].to_dict()

    in_a_room(photo)


def test_a_page_is_told_which_of_its_looks_arrived():
    def told(room, loop, pages):
        for look in LOOKS[1:3]:
            pages[0].send_look(look.to_dict())
            loop.go_on(1)
            pages[0].listen()
            assert pages[0].confirmed == pages[0].count
        pages[1].listen()
        assert pages[1].confirmed == 0

    in_a_room(told)


def test_pages_are_told_that_another_camera_is_used():
    def told(room, loop, pages):
        room.announce_camera()
        pages[0]._next()  # hello
        assert pages[0]._next() == {"type": "camera"}

    in_a_room(told)


def test_the_last_look_of_a_page_that_leaves_is_painted():
    def goes(room, loop, pages):
        pages[0].send_look(LOOKS[1].to_dict())
        loop.go_on(0)
        pages[0].send_look(LOOKS[2].to_dict())
        room.remove(pages[0].viewer)
        assert room.session.look == LOOKS[2]
        loop.go_on(1)
        assert room.session.look == LOOKS[2]

    in_a_room(goes)


what_happens = st.one_of(
    st.tuples(st.sampled_from(["say", "file"]), st.integers(0, 2), st.sampled_from(LOOKS)),
    st.tuples(st.sampled_from(["wrong", "listen"]), st.integers(0, 2), st.none()),
    st.tuples(st.just("time"), st.integers(0, 12), st.none()),
)


@settings(deadline=None)
@given(st.lists(what_happens))
def test_pages_always_end_up_with_the_painted_look(happens):
    def conversation(room, loop, pages):
        last = Look.to_dict(room.session.look)
        for kind, number, look in happens:
            match kind:
                case "say":
                    pages[number].send_look(last := look.to_dict())
                case "file":
                    pages[number].send_look(look=(last := look.to_dict()))
                case "wrong":
                    pages[number].send_look(BAD)
                    last = None
                case "listen":
                    pages[number].listen()
                case "time":
                    loop.go_on(number / 1000)
        loop.go_on(1)
        for page in pages:
            page.listen()
            assert page.look == room.session.look.to_dict()
        assert last in (None, room.session.look.to_dict())

    in_a_room(conversation)


def test_a_picture_after_the_last_page_wants_nothing():
    async def called():
        loop, session = Loop(), Session()
        room = Room(session, loop)
        page = Page(room)
        push = session.push
        push(ShownPicture(0, 0, b"a picture", None, None))
        room.remove(page.viewer)
        session.wanted = "of another room"
        loop.go_on(0.1)
        assert session.wanted == "of another room"

    asyncio.run(called())


def test_nobody_compares_once_the_page_that_did_has_left():
    def leaving(room, loop, pages):
        for on, page in ((True, pages[0]), (True, pages[1]), (False, pages[2])):
            room.receive(page.viewer, json.dumps({"type": "compare", "on": on}))
        room.remove(pages[0].viewer)
        assert room.session.compares
        room.remove(pages[1].viewer)
        assert not room.session.compares

    in_a_room(leaving)
