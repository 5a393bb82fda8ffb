"""All rooms, and how many may watch: each page costs some memory and some of the machine's time."""

import asyncio

from makeup_video.pipeline.errors import UsageError
from makeup_video.web.messages import hello
from makeup_video.web.session import Show
from makeup_video.web.viewers import Room, Viewer

MOST_VIEWERS = 16


class Rooms:
    """A room for each session that somebody watches. All on the server's loop."""

    def __init__(self, show: Show) -> None:
        self.show = show
        self._rooms: dict[str, Room] = {}

    @property
    def viewers(self) -> int:
        return sum(len(room.viewers) for room in self._rooms.values())

    def enter(self, name: str) -> tuple[Room, Viewer]:
        """A page comes, or comes back. Raises UsageError when there are too many."""
        if self.viewers >= MOST_VIEWERS:
            raise UsageError(f"{MOST_VIEWERS} pages watch already: close one of them, then reload")
        session = self.show.enter(name)
        room = self._rooms.get(session.name)
        if room is None:
            room = Room(session, asyncio.get_running_loop())
            self._rooms[session.name] = room
        viewer = Viewer(hello(self.show.mode, session))
        room.join(viewer)
        return room, viewer

    def leave(self, room: Room, viewer: Viewer) -> None:
        room.part(viewer)
        if not room.viewers:
            del self._rooms[room.session.name]
            self.show.leave(room.session)

    def find(self, name: str) -> Room | None:
        """The room of a session that somebody watches."""
        session = self.show.find(name)
        return None if session is None else self._rooms.get(session.name)

    def say_bye(self) -> None:
        for room in self._rooms.values():
            for viewer in room.viewers:
                viewer.say_bye()
