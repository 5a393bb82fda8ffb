"""The source of a live run: a camera, or a file played in real time."""

import re
import sys
from collections.abc import Callable, Generator
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

from makeup_video.pipeline.errors import InputError, UsageError, option
from makeup_video.pipeline.files.local_file import local_file
from makeup_video.pipeline.frames.frame import Frame
from makeup_video.pipeline.images.picture_file import is_picture
from makeup_video.pipeline.live.sources.device import CameraRequest, DeviceCamera
from makeup_video.pipeline.live.sources.file import FileCamera
from makeup_video.pipeline.live.sources.file_sound import FileSound, has_sound
from makeup_video.pipeline.media.input_file import open_video

PIXELS = ("mjpeg", "yuyv422")


@dataclass(frozen=True, slots=True, kw_only=True)
class CameraSettings:
    """Which camera to open, and which mode to request. A file ignores size, rate and pixels.

    name: a device (/dev/video0; on macOS "0" or the camera's name, on Windows its name), or a video
    file on this machine; None: the first camera that opens.
    size: as "1280x720"; None: the camera's default.
    rate: frames per second; None: the camera's default.
    pixels: "mjpeg" or "yuyv422"; None: the one that allows the highest rate.
    loop: a file starts again when it ends.
    """

    name: str | None = None
    size: str | None = "1280x720"
    rate: int | None = 30
    pixels: str | None = None
    loop: bool = False

    def __post_init__(self) -> None:
        if self.size is not None and not re.fullmatch(r"[1-9]\d{0,4}x[1-9]\d{0,4}", self.size):
            raise UsageError(
                f"{option('size')} must be WIDTHxHEIGHT such as 1280x720, got {self.size!r}"
            )
        if self.rate is not None and not 1 <= self.rate <= 240:
            raise UsageError(
                f"{option('rate')} must be in 1..240 frames per second, got {self.rate}"
            )
        if self.pixels is not None and self.pixels not in PIXELS:
            raise UsageError(
                f"{option('pixels')} must be {' or '.join(PIXELS)}, got {self.pixels!r}"
            )
        if self.name == "":
            raise UsageError("the name of the camera is empty: give a device or a video file")


class Camera:
    """A camera or a file, opened at once. `frames` yields its frames with their times of arrival.

    path: the file; None for a device.
    Raises InputError or DecodeError, one line, when it cannot be opened.
    """

    def __init__(self, settings: CameraSettings, log: Callable[[str], None]) -> None:
        self.path = _file_of(settings.name)
        self._source: DeviceCamera | FileCamera
        if self.path is not None:
            self._source = FileCamera(open_video(self.path), loop=settings.loop)
        else:
            request = CameraRequest(settings.size, settings.rate, settings.pixels)
            self._source = DeviceCamera(_device_of(settings.name), request, log)

    def frames(self) -> Generator[Frame, None, None]:
        """Yield each frame when it arrives, until the file ends or `close` is called. Call once."""
        return self._source.frames()

    def close(self) -> None:
        """End `frames`, even while it waits; from another thread."""
        self._source.close()

    def file_sound(self) -> FileSound | None:
        """The sound of the file, in step with its pictures; None for a device, or without sound."""
        if self.path is None or not isinstance(self._source, FileCamera):
            return None
        return FileSound(self.path, self._source) if has_sound(self.path) else None

    @property
    def name(self) -> str:
        """What messages call the source."""
        return self._source.name

    @property
    def rate(self) -> Fraction:
        """Frames per second, as far as the source declares a rate."""
        return self._source.rate

    @property
    def notice(self) -> str:
        """What the user should know now, such as an unplugged camera; "" when all is well."""
        return self._source.notice

    @property
    def dropped(self) -> int:
        """Number of frames that arrived and were never handed out: old, or late."""
        return self._source.dropped

    @property
    def damaged(self) -> int:
        """Number of packets that could not be decoded."""
        return self._source.damaged


def _device_of(name: str | None) -> str | None:
    is_number = name is not None and name.isdecimal() and sys.platform.startswith("linux")
    return f"/dev/video{name}" if is_number else name


def _file_of(name: str | None) -> Path | None:
    """Return the file that a name means, None for a device. Raises InputError for neither."""
    if name is None:
        return None
    path = Path(name)
    try:
        if _is_device(path):
            return None
    except OSError as error:  # such as a name that is too long
        raise InputError(f"{path} cannot be read: {error.strerror}") from error
    file = local_file(path, "video")
    if is_picture(file):
        raise InputError(
            f"{path} is a picture, and a camera needs a video: give one, or paint the picture with "
            f"makeup-video {path} -o OUT"
        )
    return file


def _is_device(path: Path) -> bool:
    if sys.platform.startswith("linux"):
        may_be = str(path).isdecimal() or path.is_char_device() or path.is_relative_to("/dev")
    else:
        may_be = not path.exists()  # these systems give cameras names, not paths
    return may_be and not path.is_file()
