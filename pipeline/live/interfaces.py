"""The picture, the source and the sink of a live run, and the time base of its frames."""

from collections.abc import Generator
from dataclasses import dataclass
from fractions import Fraction
from typing import Protocol

import numpy as np
from makeup_video.pipeline.frames.frame import Frame

# A live frame's pts is its arrival in these ticks of time.monotonic(), so any stage can compute the
# delay of a picture, and a recording runs by the wall clock.
LIVE_TIME_BASE = Fraction(1, 1_000_000)


@dataclass(frozen=True, slots=True, eq=False)
class LivePicture:
    """A painted frame on its way to the sinks, which share its memory and must not change it.

    before: the frame's planes as the camera delivered them; None unless a viewer compares.
    """

    frame: Frame
    before: tuple[np.ndarray, ...] | None = None


class LiveSource(Protocol):
    """Where the frames of a live run come from, with square pixels: see sources/camera.py."""

    @property
    def notice(self) -> str:
        """What the user should know now, such as "the camera is gone"; "" when all is well."""
        ...

    @property
    def dropped(self) -> int:
        """Number of frames that arrived and were never handed out."""
        ...

    def frames(self) -> Generator[Frame, None, None]:
        """Yield each frame when it arrives. Called once."""
        ...

    def close(self) -> None:
        """End `frames`, even while it waits. From any thread; may be called again."""
        ...


class LiveSink(Protocol):
    """Takes the pictures of a live run, on a thread of its own.

    name: what messages and figures call the sink.  kind: "recording", "stream", "camera" or
    "preview".
    waiting: how many pictures may wait for the sink; when more come, the oldest is dropped.
    """

    name: str
    kind: str
    waiting: int

    @property
    def notice(self) -> str:
        """What the user should know now, such as a receiver that is gone; "" when all is well."""
        ...

    @property
    def seconds(self) -> float:
        """How long the recording is, or the connection holds; 0 for what has no length."""
        ...

    @property
    def state(self) -> str:
        """What the last line adds to the number of pictures, such as ", 12.0 s"; or ""."""
        ...

    @property
    def sent(self) -> int:
        """Number of pictures written, sent or shown; none while nobody is connected."""
        ...

    def __call__(self, picture: LivePicture, /) -> None:
        """Write, send or show one picture."""
        ...

    def finish(self) -> None:
        """Close the sink; called once, after the last picture.

        Raises OutputError when there were pictures and the sink could send none of them.
        """
        ...
