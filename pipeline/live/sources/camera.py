"""The source of a live run: a camera, or a file played in real time."""

import re
import sys
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from makeup_video.pipeline.errors import InputError, UsageError, option
from makeup_video.pipeline.files.disk_errors import unreadable
from makeup_video.pipeline.files.local_file import local_file
from makeup_video.pipeline.images.picture_file import is_picture
from makeup_video.pipeline.live.sources.device import CameraRequest, DeviceCamera
from makeup_video.pipeline.live.sources.file import FileCamera
from makeup_video.pipeline.media.input_file import open_video

PIXELS = ("mjpeg", "yuyv422")


@dataclass(frozen=True, slots=True, kw_only=True)
class CameraSettings:
    """Which camera to open, and which mode to request. A file ignores size, rate and pixels.

    name: a device (/dev/video0; on macOS "0" or the camera's name; on Windows its name), or a video
    file on this machine; None: the first camera that opens.
    size: such as "1280x720"; None: the camera's default.
    rate: frames per second; None: the camera's default.
    pixels: "mjpeg" or "yuyv422"; None: the one that allows the higher rate.
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


def open_source(settings: CameraSettings, log: Callable[[str], None]) -> DeviceCamera | FileCamera:
    """Open a camera or a file, whose `frames` have their times of arrival.

    log: see DeviceCamera.  Raises InputError or DecodeError when the source cannot be opened.
    """
    path = _file_of(settings.name)
    if path is not None:
        return FileCamera(open_video(path), loop=settings.loop)
    request = CameraRequest(settings.size, settings.rate, settings.pixels)
    return DeviceCamera(_device_of(settings.name), request, log)


def _device_of(name: str | None) -> str | None:
    is_number = name is not None and name.isdecimal() and sys.platform == "linux"
    return f"/dev/video{name}" if is_number else name


def _file_of(name: str | None) -> Path | None:
    """The file that a name means; None for a device. Raises InputError if it means neither."""
    if name is None:
        return None
    path = Path(name)
    try:
        if _is_device(path):
            return None
    except OSError as error:  # for example for a name that is too long
        raise InputError(unreadable(path, error)) from error
    file = local_file(name, "video")
    if is_picture(file):
        raise InputError(
            f"{path} is a picture, and a camera needs a video: give one, or paint the picture with "
            f"makeup-video {path} -o OUT"
        )
    return file


def _is_device(path: Path) -> bool:
    if sys.platform == "linux":
        may_be = str(path).isdecimal() or path.is_char_device() or path.is_relative_to("/dev")
    else:
        may_be = not path.exists()  # on these systems cameras have names, not paths
    return may_be and not path.is_file()
