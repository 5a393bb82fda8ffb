"""The picture, the source and the sink of a live run, and the time base of its frames."""

from collections.abc import Generator
from dataclasses import dataclass
from fractions import Fraction
from typing import Protocol

import numpy as np
from makeup_video.pipeline.frames.frame import Frame

# A live frame's pts is its time of arrival by time.monotonic() in these ticks. So any stage can
# compute the delay of a picture, and a recording lasts as long as the run.
LIVE_TIME_BASE = Fraction(1, 1_000_000)


@dataclass(frozen=True, slots=True, eq=False)
class LivePicture:
    """A painted frame on its way to the sinks, which share its memory and must not change it.

    before: the frame's planes as the camera delivered them; None unless a viewer compares both.
    """

    frame: Frame
    before: tuple[np.ndarray, ...] | None = None


class LiveSource(Protocol):
    """Where the frames of a live run come from; see sources/camera.py. Their pixels are square."""

    @property
    def notice(self) -> str:
        """What the user should know now, such as "the camera is gone"; "" when all is well."""
        ...

    @property
    def dropped(self) -> int:
        """Number of frames that arrived and were never handed out."""
        ...

    @property
    def damaged(self) -> int:
        """Number of pictures that could not be decoded."""
        ...

    def frames(self) -> Generator[Frame, None, None]:
        """Yield each frame when it arrives. Called once."""
        ...

    def close(self) -> None:
        """End `frames`, even while it waits. May be called from any thread, and repeatedly."""
        ...


class LiveSink(Protocol):
    """Takes the pictures of a live run, on a thread of its own.

    name: the sink's name in messages and figures.  kind: "recording", "stream", "camera" or
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
        """Length of the recording, or age of the connection; 0 for sinks that have neither."""
        ...

    @property
    def state(self) -> str:
        """What the run's last line adds after the number of pictures, such as ", 12.0 s", or ""."""
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
