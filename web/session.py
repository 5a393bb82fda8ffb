"""What a page shows: the protocol that `live` and `demo` implement, and what they hand over.

A Show has one Session for all its pages (live) or one for each (demo). A Session is one look and the picture it
is painted on; it knows nothing of sockets, and makes pictures only while somebody watches.

All methods but `read`, `whole_picture` and `take_portrait` are called on the server's loop: they
must not block. Those three take their time, and are called on the worker's thread, one at a time.
"""

import struct
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Literal, Protocol

import numpy as np
from makeup_video.pipeline.look.look import Look

PHOTO_BYTES = 32_000_000  # the largest phone photos have 20 MB or so
HEAD = struct.Struct("<QHHII")  # pts_us, rotation_degrees, flags (0), bytes of either JPEG


@dataclass(frozen=True, slots=True, eq=False)
class ShownPicture:
    """One painted picture as it goes to the pages.

    pts_us: when it came in (live), or when its look was chosen (demo), in microseconds of
    time.monotonic().  rotation_degrees: counter-clockwise turn that makes it upright.
    jpeg, before: painted and as it was, as JPEG files; before only while a page compares.
    """

    pts_us: int
    rotation_degrees: int
    jpeg: bytes
    before: bytes | None = None

    def packed(self, compare: bool) -> bytes:
        """The binary message: head, painted JPEG, and for those who compare the JPEG before."""
        before = self.before if compare and self.before is not None else b""
        head = HEAD.pack(self.pts_us, self.rotation_degrees, 0, len(self.jpeg), len(before))
        return b"".join((head, self.jpeg, before))


@dataclass(frozen=True, slots=True)
class PhotoLook:
    """The look that was read from a photo, and what the photo is called."""

    name: str
    look: Look


Push = Callable[[ShownPicture], None]


class Session(Protocol):
    """One look, and the picture it is painted on."""

    @property
    def name(self) -> str:
        """What pages call it in `?session=`."""
        ...

    photo: PhotoLook | None  # the last one: a page can go back to it

    @property
    def look(self) -> Look: ...

    def set_look(self, look: Look, /) -> None: ...

    def watch(self, push: Push | None, /) -> None:
        """Begin to hand over pictures, from any thread: a portrait's at once, a camera's when the next
        one comes. None: nobody watches any longer."""
        ...

    def compare(self, on: bool, /) -> None:
        """Whether pictures carry what was there before."""
        ...

    def figures(self) -> Mapping[str, Any] | None:
        """What the message `figures` says, but viewers and screen_ms; None: there is nothing to say."""
        ...

    def read(self, photo: bytes, name: str) -> Look:
        """The look in a photo's file, called `name` in messages. Raises MakeupVideoError."""
        ...

    def take_portrait(self, photo: bytes, name: str) -> None:
        """Paint on this from now on. Raises MakeupVideoError."""
        ...

    def whole_picture(self) -> np.ndarray | None:
        """The newest painted picture, whole and upright: (H, W, 3) uint8 RGB; None: there is none."""
        ...


class Show(Protocol):
    """Hands out sessions. Both methods are called on the server's loop."""

    @property
    def mode(self) -> Literal["live", "demo"]: ...

    def enter(self, name: str, /) -> Session:
        """The session of that name, or a new one. Raises UsageError when there are too many."""
        ...

    def leave(self, session: Session, /) -> None:
        """Its last page went; it may come back."""
        ...

    def find(self, name: str, /) -> Session | None:
        """For uploads and downloads: a session that a page has entered."""
        ...
