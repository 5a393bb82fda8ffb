"""All rooms, with a limit on pages: each page costs memory and processor time."""

import asyncio

from makeup_video.pipeline.errors import UsageError
from makeup_video.web.messages import hello
from makeup_video.web.room import Room
from makeup_video.web.session import Show
from makeup_video.web.viewer import Viewer

MOST_VIEWERS = 16


class Rooms:
    """A room for each session that a page watches. Used on the server's loop alone."""

    def __init__(self, show: Show) -> None:
        self.show = show
        self._rooms: dict[str, Room] = {}

    @property
    def viewers(self) -> int:
        """Number of pages in all rooms."""
        return sum(len(room.viewers) for room in self._rooms.values())

    def enter(self, name: str) -> tuple[Room, Viewer]:
        """Let a page in, for the first time or again. Raises UsageError when there are too many."""
        if self.viewers >= MOST_VIEWERS:
            raise UsageError(f"{MOST_VIEWERS} pages are open already: close one, then reload")
        session = self.show.enter(name)
        room = self._rooms.get(session.name)
        if room is None:
            room = Room(session, asyncio.get_running_loop())
            self._rooms[session.name] = room
        viewer = Viewer(hello(self.show.mode, session))
        room.add(viewer)
        return room, viewer

    def leave(self, room: Room, viewer: Viewer) -> None:
        """Let a page out."""
        room.remove(viewer)
        if not room.viewers:
            del self._rooms[room.session.name]
            self.show.leave(room.session)

    def find(self, name: str) -> Room | None:
        """Find the room of a session that a page watches."""
        session = self.show.find(name)
        return None if session is None else self._rooms.get(session.name)

    def end(self) -> None:
        """Tell every page that the server stops."""
        for room in self._rooms.values():
            for viewer in room.viewers:
                viewer.end()
