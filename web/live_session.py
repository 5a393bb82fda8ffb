"""The show of a camera: one session with one look for all pages."""

import threading
import time
from collections.abc import Callable, Mapping
from dataclasses import asdict
from typing import TYPE_CHECKING, Any, Literal, Protocol

import numpy as np
from makeup_video.pipeline.errors import InputError, UsageError
from makeup_video.pipeline.frames.frame import Frame, plane_views
from makeup_video.pipeline.frames.transform import copied, upright_rgb
from makeup_video.pipeline.live.interfaces import LivePicture, LiveSink
from makeup_video.pipeline.look.look import Look
from makeup_video.web.portrait import Portrait, own_portrait
from makeup_video.web.preview_sink import PreviewSink
from makeup_video.web.read_look import read_look
from makeup_video.web.session import PhotoLook, Push, Session, SeveralFaces, Wanted

if TYPE_CHECKING:
    from makeup_video.pipeline.live.run import LiveFigures

_ONE_SIZE = ("recording", "stream", "camera")  # outputs whose frames keep their size
_BARE_SECONDS = 2.0  # how long to wait for a frame that also comes without makeup


class LiveRunControl(Protocol):
    """The part of a live run (`pipeline/live/run.py`) that pages use, from other threads."""

    compare: bool  # whether the planes are kept as they came from the camera

    @property
    def look(self) -> Look: ...
    def set_look(self, look: Look, /) -> None: ...
    def figures(self) -> "LiveFigures": ...
    def add_sink(self, sink: LiveSink, /) -> None: ...
    def end_sink(self, sink: LiveSink, /) -> None: ...


class Cameras(Protocol):
    """The cameras to choose from; see pipeline/live/sources/switch.py."""

    def choices(self) -> dict[str, Any]: ...
    def choose(self, name: str, size: str, /) -> None: ...


class LiveSession:
    """A live run and its preview sink, as a session. The run goes on even if no page watches."""

    name = "live"

    def __init__(
        self,
        run: LiveRunControl,
        sink: PreviewSink,
        photo: PhotoLook | None,
        make_recording: Callable[[], LiveSink] | None,
        cameras: Cameras | None,
    ) -> None:
        self._run, self._sink, self.photo = run, sink, photo
        self._cameras = cameras
        self._make_recording = make_recording
        self._recording: LiveSink | None = None
        self._recorded: set[str] = set()  # names of all recordings that pages started
        self._portrait: Portrait | None = None
        self._needs_both = False  # a picture is wanted both with and without makeup
        self._wishes = threading.Lock()

    @property
    def look(self) -> Look:
        return self._run.look

    def set_look(self, look: Look) -> None:
        self._run.set_look(look)

    def watch(self, push: Push | None) -> None:
        self._sink.push = push

    def compare(self, on: bool) -> None:
        with self._wishes:
            self._sink.compares = on
            self._keep_planes()

    def _need_both(self, on: bool) -> None:
        """Called only on the thread of slow jobs, which does one job at a time."""
        with self._wishes:
            self._needs_both = on
            self._keep_planes()

    def _keep_planes(self) -> None:
        """Let the run keep the camera's planes while anybody needs them. Called under the lock."""
        self._run.compare = self._sink.compares or self._needs_both

    @property
    def has_video(self) -> bool:
        return self._sink.has_video

    def want(self, wanted: Wanted) -> None:
        self._sink.wanted = wanted

    def show_again(self) -> None:
        self._sink.show_again()

    def figures(self) -> Mapping[str, Any]:
        """The figures of the run. Each sink has `by_page`: whether a page started it and may end
        it."""
        values = asdict(self._run.figures())
        for sink in values["sinks"]:
            sink["by_page"] = sink["name"] in self._recorded
        return values

    def read(self, photo: bytes, name: str, face: str) -> PhotoLook | SeveralFaces:
        return read_look(photo, name, face)

    def take_portrait(self, photo: bytes, name: str) -> None:
        """Show the ready looks on the face that the camera sees now.

        photo: must be empty, since the page of a camera paints no other picture. Raises PhotoError,
        InputError, UsageError.
        """
        if photo:
            raise UsageError("this page paints the camera, not a portrait: see makeup-video demo")
        bare = _bare(self._picture_with_both())
        self._portrait = Portrait(bare, "the camera's picture")

    def record(self, on: bool) -> None:
        """Start or stop the recording of the pages. Raises UsageError, OutputError, InputError."""
        if self._make_recording is None:
            raise UsageError("this run records nothing from the page")
        if on and not self._is_recording:
            recording = self._make_recording()
            try:
                self._run.add_sink(recording)
            except BaseException:
                recording.finish()  # gives back its tap of the sound
                raise
            self._recording = recording
            self._recorded.add(recording.name)
        elif not on and self._recording is not None:
            self._run.end_sink(self._recording)
            self._recording = None

    def cameras(self) -> dict[str, object]:
        return {} if self._cameras is None else self._cameras.choices()

    def choose_camera(self, name: str, size: str) -> None:
        """Use another camera or size.

        name: "" keeps the camera if a size is given.  size: "" keeps the size last requested.
        Raises UsageError for a camera or size that is not offered, and while an output needs frames
        of one size. A page may not name a file of its own choice: the page would show files that
        its user may not read.
        """
        if self._cameras is None:
            raise UsageError("this run has no other camera")
        offered = self._cameras.choices()
        wanted = size or offered["size"]
        if size and not name:
            name = offered["name"]
        for chosen, several, now in ((name, "names", "name"), (wanted, "sizes", "size")):
            if chosen not in (*offered[several], offered[now]):
                named = chosen or "an empty name"
                raise UsageError(f"{named} is not offered: choose one of the list of {several}")
        for sink in self._run.figures().sinks:
            if sink.kind in _ONE_SIZE and not sink.is_over:
                raise UsageError(f"{sink.name} needs frames of one size: end it first")
        self._cameras.choose(name, size)

    @property
    def _is_recording(self) -> bool:
        """Whether a page's recording runs; False after a recording failed, as on a full disk."""
        name = self._recording and self._recording.name
        sinks = self._run.figures().sinks if name else ()
        return any(sink.name == name and not sink.is_over for sink in sinks)

    @property
    def has_picture(self) -> bool:
        return self._sink.newest is not None

    def whole_picture(self, both: bool) -> np.ndarray:
        """The newest picture, however old: the one that pages show.

        both: instead the next picture, without makeup on the left and with makeup on the right.
        Raises InputError when the camera sends no frame.
        """
        picture = self._sink.newest
        if picture is None or both:
            picture = self._picture_with_both()
        if not both:
            return upright_rgb(picture.frame)
        return np.hstack([_bare(picture), upright_rgb(picture.frame)])

    def thumbnail(self, look: Look) -> bytes:
        return self._shown_portrait.thumbnail(look)

    def portrait_thumbnail(self) -> bytes:
        return self._shown_portrait.small

    @property
    def _shown_portrait(self) -> Portrait:
        """The portrait for thumbnails: ours until the visitor chooses the camera's picture, since
        the camera may show nobody."""
        if self._portrait is None:
            self._portrait = own_portrait()
        return self._portrait

    def _picture_with_both(self) -> LivePicture:
        """The next picture that has the camera's planes, too. Raises InputError when none comes."""
        until = time.monotonic() + _BARE_SECONDS
        last = self._sink.newest  # may be an hour old if the camera is gone
        self._need_both(True)
        try:
            while time.monotonic() < until:
                newest = self._sink.newest
                if newest is not None and newest is not last and newest.before is not None:
                    return newest
                time.sleep(0.01)
        finally:
            self._need_both(False)
        raise InputError("the camera sends no frames now: try again later")


def _bare(picture: LivePicture) -> np.ndarray:
    """The picture without makeup of a LivePicture that has one: upright, (H, W, 3) uint8 RGB."""
    frame = picture.frame
    bare = copied(frame.picture)
    for new, old in zip(plane_views(bare, 8), picture.before or (), strict=True):
        new[:] = old
    return upright_rgb(Frame(bare, frame.pts, frame.time_base, frame.tags, frame.rotation_degrees))


class LiveShow:
    """The show of a live run, for `Server`.

    sink: one of the run's sinks.  photo: the photo that the run's first look was read from, if any.
    make_recording: makes the sink of a recording that a page starts; None: pages cannot record.
    cameras: the cameras that a page may choose; None: pages cannot choose a camera.
    """

    mode: Literal["live"] = "live"

    def __init__(
        self,
        run: LiveRunControl,
        sink: PreviewSink,
        photo: PhotoLook | None = None,
        make_recording: Callable[[], LiveSink] | None = None,
        cameras: Cameras | None = None,
    ) -> None:
        self._session = LiveSession(run, sink, photo, make_recording, cameras)

    def enter(self, name: str) -> LiveSession:
        return self._session

    def leave(self, session: Session) -> None:
        """The session goes on without pages."""

    def find(self, name: str) -> LiveSession | None:
        return self._session
