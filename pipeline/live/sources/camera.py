"""Where the pictures of a live run come from: a camera, or a file played in real time."""

import re
import sys
from collections.abc import Callable, Generator
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

from makeup_video.pipeline.errors import InputError, UsageError
from makeup_video.pipeline.frames.frame import Frame
from makeup_video.pipeline.live.sources.device import CameraRequest, DeviceCamera
from makeup_video.pipeline.live.sources.file import FileCamera
from makeup_video.pipeline.media.input_file import local_file, open_video

PIXELS = ("mjpeg", "yuyv422")


@dataclass(frozen=True, slots=True, kw_only=True)
class CameraSettings:
    """Which camera, and what to ask of it.

    name: a device (/dev/video0; on macOS "0" or the camera's name, on Windows its name), or a video file
    on this machine; None: the first camera that opens.  size: as "1280x720".  rate: frames a second.
    size and rate None: what the camera likes best.  pixels: "mjpeg" or "yuyv422"; None: what reaches most.
    loop: a file begins again when it ends.  Size, rate and pixels mean nothing to a file.
    """

    name: str | None = None
    size: str | None = "1280x720"
    rate: int | None = 30
    pixels: str | None = None
    loop: bool = False

    def __post_init__(self) -> None:
        if self.size is not None and not re.fullmatch(r"[1-9]\d{0,4}x[1-9]\d{0,4}", self.size):
            raise UsageError(f"a camera's size is WIDTHxHEIGHT such as 1280x720, got {self.size!r}")
        if self.rate is not None and not 1 <= self.rate <= 240:
            raise UsageError(f"a camera's rate is 1..240 frames a second, got {self.rate}")
        if self.pixels is not None and self.pixels not in PIXELS:
            raise UsageError(f"a camera's pixels are {' or '.join(PIXELS)}, got {self.pixels!r}")
        if self.name == "":
            raise UsageError("the name of the camera is empty: give a device or a video file")


class Camera:
    """Opens the camera at once; `frames` gives what it sees, each with the time when it came.

    Raises InputError or DecodeError, one line, when there is nothing to open.
    name: how lines call it.  path: the file, None for a device.  rate: frames a second, as far as is said.
    """

    def __init__(self, settings: CameraSettings, say: Callable[[str], None]) -> None:
        self.path = _file_of(settings.name)
        self._source: DeviceCamera | FileCamera
        if self.path is not None:
            self._source = FileCamera(open_video(self.path), loop=settings.loop)
        else:
            wish = CameraRequest(settings.size, settings.rate, settings.pixels)
            self._source = DeviceCamera(_device_of(settings.name), wish, say)

    def frames(self) -> Generator[Frame, None, None]:
        """Blocks until each is there; ends with the file, or when `close` was called. To be called once."""
        return self._source.frames()

    def close(self) -> None:
        """Wakes and ends `frames`, from another thread."""
        self._source.close()

    @property
    def name(self) -> str:
        return self._source.name

    @property
    def rate(self) -> Fraction:
        return self._source.rate

    @property
    def notice(self) -> str:
        """What people should know of it now, such as that it is unplugged; "" when all is well."""
        return self._source.notice

    @property
    def dropped(self) -> int:
        """Pictures that came and were never handed out: old, or late."""
        return self._source.dropped

    @property
    def damaged(self) -> int:
        """Packets that could not be decoded."""
        return self._source.damaged


def _device_of(name: str | None) -> str | None:
    is_number = name is not None and name.isdecimal() and sys.platform.startswith("linux")
    return f"/dev/video{name}" if is_number else name


def _file_of(name: str | None) -> Path | None:
    """The file that a name means; None when it means a device. Raises InputError when it can be neither."""
    if name is None:
        return None
    path = Path(name)
    try:
        if _is_device(path):
            return None
    except OSError as error:  # such as a name that is too long
        raise InputError(f"{path} cannot be read: {error.strerror}") from error
    return local_file(path, "video")


def _is_device(path: Path) -> bool:
    if sys.platform.startswith("linux"):
        may_be = str(path).isdecimal() or path.is_char_device() or path.is_relative_to("/dev")
    else:
        may_be = not path.exists()  # cameras have names of their own there
    return may_be and not path.is_file()
