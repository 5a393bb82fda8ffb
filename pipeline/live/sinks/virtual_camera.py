"""The pictures of a live run -> a camera that other programs can open, with pyvirtualcam."""

from fractions import Fraction
from typing import Any

import numpy as np
from av.video.reformatter import ColorRange, Colorspace
from makeup_video.pipeline.errors import InstallError, OutputError
from makeup_video.pipeline.frames.colour_tags import resolve
from makeup_video.pipeline.frames.frame import Frame, plane_views
from makeup_video.pipeline.frames.transform import copied, ffmpeg_matrix, ffmpeg_range, upright
from makeup_video.pipeline.live.interfaces import LivePicture

_HELP = (
    "on Linux load v4l2loopback (sudo modprobe v4l2loopback exclusive_caps=1), on macOS and "
    "Windows install OBS Studio"
)


def _pyvirtualcam() -> Any:
    """Import pyvirtualcam, an extra. Raises InstallError with the command that installs it."""
    try:
        import pyvirtualcam
    except ImportError:
        raise InstallError(
            "a virtual camera needs the extra: pip install 'makeup-video[virtualcam]'"
        ) from None
    return pyvirtualcam


class VirtualCamera:
    """Shows the pictures, upright, as a camera of this machine.

    Pictures are sent as planes (I420) in limited range and BT.601, which programs expect of
    webcams.
    device: as pyvirtualcam names it (/dev/video4, "OBS Virtual Camera"); None: the first one.
    rate: announced frames per second; pictures are shown when they come.
    Raises InstallError when pyvirtualcam is missing. A call raises OutputError when there is no
    such device, or when the device takes no more frames.
    """

    waiting = 1
    kind = "camera"
    seconds = 0.0
    state = ""
    notice = ""  # always empty: a virtual camera that fails ends with an error

    def __init__(self, device: str | None = None, *, rate: Fraction | float = 30) -> None:
        self._library = _pyvirtualcam()
        self._device, self._rate = device, float(rate)
        self.name = device or "virtual camera"
        self._camera: Any = None
        self._codes = np.empty(0, np.uint8)
        self.sent = 0

    def __call__(self, picture: LivePicture) -> None:
        planes = as_webcam(picture.frame)
        height, width = planes[0].shape
        if self._camera is None:
            self._open(width, height)
        np.concatenate([plane.ravel() for plane in planes], out=self._codes)
        try:
            self._camera.send(self._codes)
        except (RuntimeError, OSError, ValueError) as error:
            self.finish()
            raise OutputError(f"{self.name} no longer takes frames: {_one_line(error)}") from error
        self.sent += 1

    def finish(self) -> None:
        if self._camera is not None:
            self._camera.close()
            self._camera = None

    def _open(self, width: int, height: int) -> None:
        library = self._library
        try:
            self._camera = library.Camera(
                width, height, self._rate, fmt=library.PixelFormat.I420, device=self._device
            )
        except (RuntimeError, OSError, ValueError) as error:
            raise OutputError(f"no virtual camera: {_one_line(error)}; {_HELP}") from error
        self._codes = np.empty(width * height * 3 // 2, np.uint8)
        self.name = getattr(self._camera, "device", None) or self.name


def as_webcam(frame: Frame) -> tuple[np.ndarray, ...]:
    """Convert a 4:2:0 frame to upright planes in limited range and BT.601; copies if needed."""
    picture = upright(frame)
    coding = resolve(frame.tags, frame.width_px, frame.height_px, 8)
    if ffmpeg_matrix(coding) != Colorspace.ITU601 or coding.full_range:
        # a copy, as in upright_rgb, since other outputs use the frame, too
        picture = (copied(picture) if picture is frame.picture else picture).reformat(
            format="yuv420p",
            src_colorspace=ffmpeg_matrix(coding),
            dst_colorspace=Colorspace.ITU601,
            src_color_range=ffmpeg_range(coding.full_range),
            dst_color_range=ColorRange.MPEG,
        )
    return plane_views(picture, 8)


def _one_line(error: Exception) -> str:
    return " ".join(str(error).split())
