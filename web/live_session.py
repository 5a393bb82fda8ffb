"""The show of a camera: one session, one look, for all pages."""

from collections.abc import Mapping
from dataclasses import asdict
from functools import cached_property
from typing import TYPE_CHECKING, Any, ClassVar, Literal, Protocol

import numpy as np
from makeup_video.pipeline.errors import UsageError
from makeup_video.pipeline.frames.transform import upright_rgb
from makeup_video.pipeline.look.look import Look
from makeup_video.web.portrait import Portrait, own_portrait
from makeup_video.web.preview_sink import PreviewSink
from makeup_video.web.read_look import read_look
from makeup_video.web.session import PhotoLook, Push, Session

if TYPE_CHECKING:
    from makeup_video.pipeline.reference.estimate import Estimate

NAME = "live"


class Figures(Protocol):
    """A dataclass: fps, latency_ms, latency_p95_ms, dropped, level, level_notice, notice, sinks."""

    __dataclass_fields__: ClassVar[dict[str, Any]]


class LiveRunControl(Protocol):
    """The part of a live run (`pipeline/live/run.py`) that pages use, from other threads."""

    compare: bool  # keep the planes as they came from the camera

    @property
    def look(self) -> Look: ...
    def set_look(self, look: Look, /) -> None: ...
    def figures(self) -> Figures: ...


class LiveSession:
    """A live run and its preview sink, as a session. The run goes on while no page watches."""

    name = NAME

    def __init__(self, run: LiveRunControl, sink: PreviewSink, photo: PhotoLook | None) -> None:
        self._run, self._sink, self.photo = run, sink, photo

    @property
    def look(self) -> Look:
        return self._run.look

    def set_look(self, look: Look) -> None:
        self._run.set_look(look)

    def watch(self, push: Push | None) -> None:
        self._sink.push = push

    def compare(self, on: bool) -> None:
        self._run.compare = self._sink.compares = on

    def figures(self) -> Mapping[str, Any]:
        return asdict(self._run.figures())

    def read(self, photo: bytes, name: str) -> "Estimate":
        return read_look(photo, name)

    def take_portrait(self, photo: bytes, name: str) -> None:
        raise UsageError("this page paints the camera, not a portrait: see makeup-video demo")

    def whole_picture(self) -> np.ndarray | None:
        newest = self._sink.newest
        return None if newest is None else upright_rgb(newest.frame)

    def thumbnail(self, look: Look) -> bytes:
        return self._portrait.thumbnail(look)

    @cached_property
    def _portrait(self) -> Portrait:
        """Thumbnails show our portrait: the camera may show nobody."""
        return own_portrait()


class LiveShow:
    """The show of a live run, for `Server`.

    sink: one of the run's sinks.  photo: the photo that the run's first look was read from, if any.
    """

    mode: Literal["live"] = "live"

    def __init__(
        self, run: LiveRunControl, sink: PreviewSink, photo: PhotoLook | None = None
    ) -> None:
        self._session = LiveSession(run, sink, photo)

    def enter(self, name: str) -> LiveSession:
        return self._session

    def leave(self, session: Session) -> None:
        """The session goes on without pages."""

    def find(self, name: str) -> LiveSession | None:
        return self._session
