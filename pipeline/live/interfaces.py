"""What crosses the channels of a live run, and how its frames tell the time."""

from collections.abc import Generator
from dataclasses import dataclass
from fractions import Fraction
from typing import Protocol

import numpy as np
from makeup_video.pipeline.frames.frame import Frame

# A live frame's pts is when it arrived, in these ticks of time.monotonic(): how late a picture is can be told
# anywhere, and a recording's times are those of the wall clock.
LIVE_TIME_BASE = Fraction(1, 1_000_000)


@dataclass(frozen=True, slots=True, eq=False)
class LivePicture:
    """One painted picture on its way to the sinks, which all read the same memory: nobody changes it.

    before: the frame's planes as they came from the camera; None unless somebody compares.
    """

    frame: Frame
    before: tuple[np.ndarray, ...] | None = None


class LiveSource(Protocol):
    """Where frames come from, with square pixels: see camera.py.

    frames: blocks until each is there; called once.  close: wakes and ends it, from any thread; may be
    called again.  notice: what a person should know now ("the camera is gone"), "" when all is
    well.  dropped: pictures that came and were never handed out.
    """

    @property
    def notice(self) -> str: ...
    @property
    def dropped(self) -> int: ...

    def frames(self) -> Generator[Frame, None, None]: ...
    def close(self) -> None: ...


class LiveSink(Protocol):
    """Takes the pictures of a live run, on a thread of its own; `finish` is called once after the last.

    name: how lines and figures call it.  waiting: how many pictures may wait for it: when there
    are more, the oldest gives way.  It may have a `notice`, as a LiveSource does.
    sent: how many pictures it has written, sent or shown. A picture that was thrown away because
    nobody was connected is not among them.  finish: raises OutputError when there were pictures
    and the sink could send none of them.
    """

    name: str
    waiting: int

    @property
    def sent(self) -> int: ...

    def __call__(self, picture: LivePicture, /) -> None: ...
    def finish(self, stopped: bool) -> None: ...
