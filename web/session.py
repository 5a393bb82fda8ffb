"""What pages show: the protocols that `live` and `demo` implement, and their pictures.

A Show has one Session for all pages (live) or one for each page (demo). A Session is one look and
the picture that the look is painted on. The session knows no sockets, and makes pictures only while
a page watches.

`read`, `take_portrait`, `whole_picture` and the methods of thumbnails are slow: they are called on
the first thread of `SlowJobs`, one at a time. `record`, `cameras` and `choose_camera` are called on
its other thread, also one at a time. `show_again` is slow, too, and may be called on any thread.
All other methods are called on the server's loop and must not block.
"""

import struct
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Literal, Protocol

import numpy as np
from makeup_video.pipeline.look.look import Look

PHOTO_BYTES = 64_000_000  # photos of 200 megapixels have up to about 50 MB
# The head of a picture: pts_us, rotation_degrees, flags, and the sizes of both parts in bytes.
HEAD = struct.Struct("<QHHII")
# Flags: both parts are packets of H.264, not JPEG files; the first part, or the second part (the
# picture without makeup), is a key frame.
IS_VIDEO, KEY, KEY_BEFORE = 1, 2, 4
Packet = tuple[bytes, bool]  # the bytes of H.264, and whether they are a key frame


@dataclass(frozen=True, slots=True, eq=False)
class ShownPicture:
    """A painted picture as it is sent to the pages.

    pts_us: when its frame arrived (live) or its look was chosen (demo), in microseconds of
    time.monotonic().
    rotation_degrees: the counter-clockwise turn that makes the picture upright.
    jpeg, before: the picture with and without makeup, as JPEG files; None if no page wants JPEG.
    before is None, too, while no page compares.
    video: the same pictures as H.264; None if no page wants H.264.
    """

    pts_us: int
    rotation_degrees: int
    jpeg: bytes | None
    before: bytes | None = None
    video: "VideoPicture | None" = None

    def packed(self, compare: bool) -> bytes:
        """Pack the binary message: head, painted JPEG, and the bare JPEG if the page compares."""
        assert self.jpeg is not None
        before = self.before if compare and self.before is not None else b""
        return self._message(0, self.jpeg, before)

    def packed_video(self, compare: bool) -> bytes:
        """Pack the binary message with packets of H.264."""
        assert self.video is not None
        painted, is_key = self.video.painted
        before, before_is_key = (compare and self.video.before) or (b"", False)
        flags = IS_VIDEO | KEY * is_key | KEY_BEFORE * before_is_key
        return self._message(flags, painted, before)

    def _message(self, flags: int, painted: bytes, before: bytes) -> bytes:
        head = HEAD.pack(self.pts_us, self.rotation_degrees, flags, len(painted), len(before))
        return b"".join((head, painted, before))


@dataclass(frozen=True, slots=True, eq=False)
class VideoPicture:
    """A picture as H.264. Its packets can only be decoded in order, beginning with a key frame.

    number: counts the packets of the session; a page that missed one waits for a key frame.
    """

    number: int
    painted: Packet
    before: Packet | None = None


@dataclass(frozen=True, slots=True)
class Wanted:
    """What the pages of a session can use now.

    jpeg: some page watches JPEG.  video: a page that watches H.264 can take a picture.  key: such a
    page needs a key frame.
    """

    jpeg: bool = True
    video: bool = False
    key: bool = False


@dataclass(frozen=True, slots=True, eq=False)
class PhotoLook:
    """The look that was read from a photo, and the photo's name.

    words: the look in words, with the certainty of each part.  thumbnail: makes the photo's small
    JPEG; the first call is slow.
    """

    name: str
    look: Look
    words: str
    thumbnail: Callable[[], bytes] = lambda: b""


@dataclass(frozen=True, slots=True, eq=False)
class SeveralFaces:
    """A photo with several faces, one of which the visitor must choose.

    picture: the photo as a JPEG for the page.  boxes: by the number of each face, its left, top,
    width and height, as shares of the picture's width and height.
    """

    picture: bytes
    boxes: Mapping[int, tuple[float, float, float, float]]


Push = Callable[[ShownPicture], None]


class Session(Protocol):
    """One look, and the picture that the look is painted on."""

    @property
    def name(self) -> str:
        """The name that pages give in `?session=`."""
        ...

    photo: PhotoLook | None  # the last photo that was read: a page can return to its look

    @property
    def has_video(self) -> bool:
        """Whether pages may choose H.264."""
        ...

    @property
    def look(self) -> Look: ...

    def set_look(self, look: Look, /) -> None: ...

    def watch(self, push: Push | None, /) -> None:
        """Push pictures from now on, from any thread; a portrait's picture comes at once.

        None: no page watches any longer.
        """
        ...

    def compare(self, on: bool, /) -> None:
        """Choose whether pictures include the one without makeup."""
        ...

    def want(self, wanted: Wanted, /) -> None:
        """From now on make only the kinds of pictures that pages want."""
        ...

    def show_again(self) -> None:
        """Push the newest picture once more, in the formats wanted now. Slow; on any thread."""
        ...

    def figures(self) -> Mapping[str, Any] | None:
        """Return the fields of a figures message except viewers and screen_ms; None: send none."""
        ...

    def read(self, photo: bytes, name: str, face: str) -> PhotoLook | SeveralFaces:
        """Read the look in a photo's file, called `name` in messages. Raises MakeupVideoError.

        face: the number of the face that the visitor chose; "" for the only face.
        """
        ...

    def take_portrait(self, photo: bytes, name: str) -> None:
        """Paint on this photo from now on. Raises MakeupVideoError."""
        ...

    def record(self, on: bool) -> None:
        """Start or stop a recording, unless that is done already. Raises MakeupVideoError."""
        ...

    def cameras(self) -> dict[str, object]:
        """Return `names` and `sizes` to choose from, and `name` and `size` in use. May be {}."""
        ...

    def choose_camera(self, name: str, size: str) -> None:
        """Use another camera or another size. Raises MakeupVideoError and then changes nothing."""
        ...

    @property
    def has_picture(self) -> bool:
        """Whether there is a picture to download yet."""
        ...

    def whole_picture(self, both: bool) -> np.ndarray:
        """Return the newest picture, full size and upright: (H, W, 3) uint8 RGB.

        both: the picture without makeup on the left, with makeup on the right; from a camera, this
        is the next picture. Raises InputError when no picture comes.
        """
        ...

    def thumbnail(self, look: Look) -> bytes:
        """Return the portrait's face with a look on, as a small JPEG."""
        ...

    def portrait_thumbnail(self) -> bytes:
        """Return the portrait without makeup, as a small JPEG."""
        ...


class Show(Protocol):
    """Hands out sessions. All methods are called on the server's loop."""

    @property
    def mode(self) -> Literal["live", "demo"]: ...

    def enter(self, name: str, /) -> Session:
        """Return the session of a name, or a new session. Raises UsageError when there are too
        many."""
        ...

    def leave(self, session: Session, /) -> None:
        """Note that the last page of a session has left; it may come back."""
        ...

    def find(self, name: str, /) -> Session | None:
        """Find the session of a page that uploads or downloads; None if there is none."""
        ...
