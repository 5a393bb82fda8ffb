"""A source whose camera or picture size can be changed while the run goes on."""

from collections.abc import Callable, Generator
from contextlib import closing, suppress
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from threading import Condition, Lock

from makeup_video.pipeline.errors import MakeupVideoError
from makeup_video.pipeline.frames.frame import Frame
from makeup_video.pipeline.live.sources.camera import CameraSettings, open_source
from makeup_video.pipeline.live.sources.device import cameras_found
from makeup_video.pipeline.live.sources.file_sound import FileSound

_RETRY_SECONDS = 1.0  # between two attempts to open a camera that a failed change left closed
SIZES = ("640x360", "640x480", "1280x720", "1920x1080")  # most cameras have these


class CameraSwitch:
    """The source of a live run: the frames of one camera after another.

    changes: how often a camera was opened after the first one, even if it was the same again.
    Raises InputError or DecodeError when the first camera cannot be opened.
    """

    def __init__(self, settings: CameraSettings, log: Callable[[str], None]) -> None:
        self._log = log
        self._camera = open_source(settings, log)
        self._settings = settings
        self._first_name = self._chosen_name()
        self._changed = Condition()
        self._is_switching = self._is_closed = self._is_lost = False
        self._opening = Lock()
        self._dropped_before = self._damaged_before = 0  # of cameras that are closed now
        self.changes = 0

    def choose(self, name: str, size: str) -> None:
        """Close the camera and open another one, or the same one with another size.

        size: "" for the size that was requested last.
        Blocks until the camera is open. Raises UsageError, InputError or DecodeError when it cannot
        be opened; the run then goes on with the old camera, as soon as that opens again.
        """
        wanted = replace(self._settings, name=name, size=size or self._settings.size)
        with self._opening:
            with self._changed:
                self._is_switching = True
            try:
                self._camera.close()  # a device cannot be opened twice
                self._exchange(wanted)
            finally:
                with self._changed:
                    self._is_switching = False
                    self._changed.notify_all()

    def _exchange(self, wanted: CameraSettings) -> None:
        """Open the wanted camera. If that fails, reopen the old one and raise the error."""
        try:
            self._put(wanted)
        except MakeupVideoError:
            try:
                self._put(self._settings)
            except MakeupVideoError:
                self._is_lost = True
                self._log(self.notice)
            raise

    def _reopen(self) -> None:
        """Wait until the camera that a failed change left closed opens again.

        A later change that succeeds ends the wait, too, and so does `close`.
        """
        while self._is_lost and not self._is_closed:
            with self._opening, suppress(MakeupVideoError):
                if self._is_lost:
                    self._put(self._settings)
                    self._log(f"camera {self.name} is open again")
            with self._changed:
                self._changed.wait_for(lambda: self._is_closed or not self._is_lost, _RETRY_SECONDS)

    def _put(self, settings: CameraSettings) -> None:
        camera = open_source(settings, self._log)
        with self._changed:
            self._dropped_before += self._camera.dropped
            self._damaged_before += self._camera.damaged
            self._camera, self._settings, self._is_lost = camera, settings, False
            self.changes += 1
            if self._is_closed:
                camera.close()

    def frames(self) -> Generator[Frame, None, None]:
        """Yield each frame when it arrives, until the last camera ends or `close` is called.

        Called once.
        """
        camera = None
        while camera is not self._camera:
            camera = self._camera
            with closing(camera.frames()) as frames:
                yield from frames
            with self._changed:
                self._changed.wait_for(lambda: not self._is_switching)
            self._reopen()
            if self._is_closed:
                return

    def close(self) -> None:
        """End `frames`, even while it waits. Called from another thread."""
        with self._changed:
            self._is_closed = True
            self._changed.notify_all()
        self._camera.close()

    def file_sound(self) -> FileSound | None:
        """The sound of the file that plays now; None for a device or a file without sound."""
        return self._camera.file_sound()

    def choices(self) -> dict[str, object]:
        """What a page offers: names and sizes to choose from, and the current name and size.

        The size of a file is None. The source that the run began with stays among the names, even
        if it is a file or was given under a name that the list does not have.
        """
        names = list(dict.fromkeys([self._first_name, *cameras_found()]))
        size = self._camera.size
        return {"names": names, "name": self._chosen_name(), "sizes": SIZES, "size": size}

    def _chosen_name(self) -> str:
        """The name with which `choose` would open the current source."""
        return str(self.path or self.name)

    @property
    def path(self) -> Path | None:
        """The file that plays now; None for a device."""
        return self._camera.path

    @property
    def name(self) -> str:
        """The current source's name in messages."""
        return self._camera.name

    @property
    def rate(self) -> Fraction:
        """Frames per second, as far as the source declares a rate."""
        return self._camera.rate

    @property
    def notice(self) -> str:
        """What the user should know now; "" when all is well."""
        if self._is_lost:
            return f"camera {self.name} cannot be opened now: waiting for it"
        return self._camera.notice

    @property
    def dropped(self) -> int:
        """Number of frames, over all cameras, that arrived and were never handed out."""
        return self._dropped_before + self._camera.dropped

    @property
    def damaged(self) -> int:
        """Number of pictures, over all cameras, that could not be decoded."""
        return self._damaged_before + self._camera.damaged
