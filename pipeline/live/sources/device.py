"""A camera of this machine -> frames. Only the newest waits, and the camera may be unplugged."""

import errno
import sys
import time
from collections.abc import Callable, Generator
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from threading import Condition, Event, Thread
from typing import Any

import av
from makeup_video.pipeline.errors import InputError, MakeupVideoError, option, reason_of
from makeup_video.pipeline.frames.frame import Frame
from makeup_video.pipeline.live.sources.file_sound import FileSound
from makeup_video.pipeline.live.sources.freshness import Freshness
from makeup_video.pipeline.live.sources.input_devices import device_packets, input_devices
from makeup_video.pipeline.live.sources.normalise import NormaliseCamera

_SYSTEMS = {"linux": "v4l2", "darwin": "avfoundation", "win32": "dshow"}
_RETRY_SECONDS = 1.0
_SILENT_SECONDS = 2.0  # after so long without a frame, a notice says so
_NOT_THERE = (errno.ENOENT, errno.ENODEV, errno.ENXIO)
_HELP = {
    errno.EACCES: "you may not use it: add yourself to the group video, or allow cameras in the "
    "settings",
    errno.EBUSY: "another program uses it: close that program",
}


@dataclass(frozen=True, slots=True)
class CameraRequest:
    """The mode requested of a camera; None: the camera's default.  pixels: "mjpeg" or "yuyv422"."""

    size: str | None
    rate: int | None
    pixels: str | None


def open_camera(name: str, system: str, options: dict[str, str]) -> Any:
    """Open a device as one of FFmpeg's containers, whose packets are the pictures."""
    if system == "dshow" and not name.startswith("video="):
        name = f"video={name}"
    return av.open(name, format=system, container_options=options)


def cameras_found() -> list[str]:
    """List the cameras of the system by the names that `open_camera` takes."""
    if sys.platform == "linux":
        paths = [path for path in Path("/dev").glob("video*") if path.name[5:].isdecimal()]
        return [str(path) for path in sorted(paths, key=lambda path: int(path.name[5:]))]
    if sys.platform == "darwin":
        return ["default"]  # AVFoundation's name for the camera that the system prefers
    return [device.name for device in input_devices(_system(), "video")]


def cameras_by_name() -> dict[str, str]:
    """The cameras by the names of `cameras_found`, with the system's names for them."""
    return {name: _called(name) for name in cameras_found()}


def _called(camera: str) -> str:
    """Linux's name for a camera, such as "Integrated Camera"; "" elsewhere, or if unknown."""
    name = Path("/sys/class/video4linux") / Path(camera).name / "name"
    try:
        return name.read_text(encoding="utf-8", errors="replace").strip()
    except OSError:
        return ""


def attempts(request: CameraRequest, system: str) -> list[dict[str, str]]:
    """List options for opening a camera, the best first; the last attempt requests nothing.

    MJPEG reaches 720p at 30 frames per second on USB 2, where YUYV reaches 10.
    """
    # Without "nobuffer", the frames that FFmpeg reads for its analysis would come out late.
    common = {"fflags": "nobuffer"}
    requested = dict(common)
    if request.size:
        requested["video_size"] = request.size
    if request.rate:
        requested["framerate"] = str(request.rate)
    spelling = {"v4l2": ("input_format", "input_format"), "dshow": ("vcodec", "pixel_format")}
    mjpeg, raw = spelling.get(system, ("", "pixel_format"))
    by_pixels = {"mjpeg": {mjpeg: "mjpeg"}, "yuyv422": {raw: "yuyv422"}}
    order = [request.pixels] if request.pixels else []
    if system != "avfoundation":
        order += [name for name in by_pixels if name != request.pixels]
    pixels = [by_pixels[name] for name in order if "" not in by_pixels[name]]
    without_size = {key: value for key, value in requested.items() if key != "video_size"}
    tries = [{**requested, **options} for options in pixels] + [requested, without_size, common]
    return [options for index, options in enumerate(tries) if options not in tries[:index]]


class DeviceCamera:
    """Reads a camera on a thread of its own from construction on, and keeps the newest picture.

    log: called with a line of text when the camera gives another mode than requested, when it is
    gone, and when it is back.
    dropped: number of pictures that were old when they were read, or that were never fetched,
    counted from the call of `frames` on.
    damaged: number of packets that could not be decoded, counted likewise.
    rate: frames per second, as far as the camera declares a rate.
    notice: what the user should know now, "" when all is well.
    path: None, since no file is played.
    size: the size of the pictures when the camera was first opened, such as "1280x720".
    Raises InputError when no camera can be opened.
    """

    path: Path | None = None

    def __init__(
        self, name: str | None, request: CameraRequest, log: Callable[[str], None]
    ) -> None:
        self._requested_name, self._request, self._log = name, request, log
        self.rate = Fraction(request.rate or 30)
        self.name = name or ""
        self.dropped = self.damaged = 0
        self.notice = self._gone = ""  # _gone: the camera that the last notice was about
        self._normalise = NormaliseCamera(is_device=True)
        self._closing = Event()
        self._news = Condition()
        self._newest: Frame | None = None
        self._counts = False  # from the call of `frames` on
        self._failure: Exception | None = None
        self._has_ended_well = False  # whether a JPEG since the last opening had an end marker
        container = self._open()
        self._log_mode(container)
        self._thread = Thread(
            target=self._run, args=(container,), name="makeup-camera", daemon=True
        )
        self._thread.start()

    def close(self) -> None:
        self._closing.set()
        with self._news:
            self._news.notify_all()
        self._thread.join(_RETRY_SECONDS)  # a read that hangs stays behind on its daemon thread

    def file_sound(self) -> FileSound | None:
        """None: a device has no sound of its own."""
        return None

    def frames(self) -> Generator[Frame, None, None]:
        """Yield the newest frame each time, until `close`. Raises the error of the reading thread.

        This call itself starts the count of dropped frames.
        """
        self._counts = True
        return self._fetched()

    def _fetched(self) -> Generator[Frame, None, None]:
        while (frame := self._next()) is not None:
            yield frame
            del frame

    def _next(self) -> Frame | None:
        """Wait for a frame; None after `close`."""
        with self._news:
            while not self._news.wait_for(self._has_news, _SILENT_SECONDS):
                if not self.notice:
                    self._notify(f"camera {self.name} sends no frames: waiting for it")
            if self._failure is not None:
                raise self._failure
            frame, self._newest = self._newest, None
        return None if self._closing.is_set() else frame

    def _has_news(self) -> bool:
        return self._newest is not None or self._failure is not None or self._closing.is_set()

    def _notify(self, notice: str, line: str = "") -> None:
        """Set the notice and log it, or log `line` instead. An unchanged notice is not logged."""
        if notice == self.notice:
            return
        self.notice = notice
        if notice:
            self._gone = self.name
        self._log(line or notice)

    # -- the reading thread --------------------------------------------------------------------

    def _run(self, container: Any) -> None:
        try:
            while container is not None:
                try:
                    self._read(container)
                except MakeupVideoError:
                    raise  # the pictures cannot be used
                except (av.FFmpegError, OSError):
                    pass  # the camera was unplugged
                finally:
                    container.close()
                if self._closing.is_set():
                    return
                self._notify(f"camera {self.name} is gone: waiting for it")
                container = self._open_again()
        except Exception as error:  # noqa: BLE001  # `frames` raises it again
            with self._news:
                self._failure = error
                self._news.notify_all()

    def _open_again(self) -> Any:
        """Wait until the camera opens again, and return its container; None after `close`."""
        while not self._closing.wait(_RETRY_SECONDS):
            try:
                return self._open()
            except InputError:
                continue
        return None

    def _read(self, container: Any) -> None:
        """Read packets until the camera fails, ends or is closed."""
        video = container.streams.video[0]
        context = video.codec_context
        context.thread_count = 1  # with more threads, the decoder would hold pictures back
        freshness = Freshness()
        self._has_ended_well = False  # another camera may have been plugged in
        independent = context.name in ("mjpeg", "rawvideo")  # other codecs need every packet
        began = time.monotonic()
        for packet in self._packets(container, video):
            now = time.monotonic()
            stamp = None if packet.pts is None else float(packet.pts * packet.time_base)
            arrived = freshness(stamp, now, now - began)
            if not packet.size:
                self.damaged += self._counts  # V4L2: so the driver reports a damaged picture
            elif arrived is not None or not independent:
                self._decode(context, packet, now if arrived is None else arrived)
            else:
                self.dropped += self._counts
            del packet  # it occupies a buffer of the camera's driver
            if self._closing.is_set():
                return
            began = time.monotonic()

    def _packets(self, container: Any, video: Any) -> Generator[Any, None, None]:
        while not self._closing.is_set():
            try:
                yield from device_packets(container, video, self._closing.is_set)
                return
            except av.InvalidDataError:
                self.damaged += self._counts  # V4L2: an incomplete picture

    def _decode(self, context: Any, packet: Any, arrived: float) -> None:
        """Decode a copy of the packet.

        The packet's memory belongs to the driver, which soon needs it again, and frees it when the
        camera is closed.
        """
        data = bytes(packet)
        if not self._is_whole(context, data):
            self.damaged += self._counts
            return
        try:
            pictures = context.decode(av.Packet(data))
        except av.FFmpegError:
            self.damaged += self._counts
            return
        for picture in pictures:
            if picture.is_corrupt:
                self.damaged += self._counts
            else:
                self._offer(self._normalise(picture, arrived))

    def _is_whole(self, context: Any, data: bytes) -> bool:
        """False for a JPEG that breaks off; the decoder would fill its rest with grey.

        Some cameras never write the end marker; their JPEGs count as whole.
        """
        if context.name != "mjpeg":
            return True
        begins, end = data.find(b"\xff\xda"), data.rfind(b"\xff\xd9")
        ends = end > begins
        self._has_ended_well |= ends
        return ends or not self._has_ended_well

    def _offer(self, frame: Frame) -> None:
        with self._news:
            self.dropped += self._counts and self._newest is not None
            self._newest = frame
            self._news.notify_all()
        if self.notice:
            is_same = self._gone == self.name
            how = "is back" if is_same else f"is used in place of {self._gone}"
            self._notify("", f"camera {self.name} {how}")

    # -- opening -------------------------------------------------------------------------------

    def _open(self) -> Any:
        names = [self._requested_name] if self._requested_name else cameras_found()
        reason = "none was found"
        for name in names:
            for options in attempts(self._request, _system()):
                try:
                    container = open_camera(name, _system(), options)
                except (av.FFmpegError, OSError, ValueError) as error:
                    number = getattr(error, "errno", None) or 0
                    reason = _HELP.get(number) or reason_of(error)
                    if number in _NOT_THERE or number in _HELP:
                        break
                    continue
                if container.streams.video:
                    self.name = name
                    return container
                container.close()
                reason = "it gives no frames"
        raise InputError(_no_camera(self._requested_name, reason))

    def _log_mode(self, container: Any) -> None:
        """Log one line when the camera's mode differs from the requested one."""
        video, request = container.streams.video[0], self._request
        self.size = size = f"{video.codec_context.width}x{video.codec_context.height}"
        rate = video.average_rate or video.guessed_rate
        pixels = {"rawvideo": video.codec_context.pix_fmt}.get(video.name, video.name)
        differs = []
        if request.size and size != request.size:
            differs.append(f"{size}, not {request.size}")
        if rate and 0 < rate <= 240:
            self.rate = Fraction(rate)
            if request.rate and abs(float(rate) - request.rate) > 0.5:
                differs.append(f"{float(rate):.3g} frames a second, not {request.rate}")
        if request.pixels and pixels != request.pixels:
            differs.append(f"{pixels}, not {request.pixels}")
        if differs:
            self._log(f"camera {self.name} gives {'; '.join(differs)}")


def _system() -> str:
    """Return FFmpeg's name for the camera interface of this system."""
    return _SYSTEMS.get(sys.platform, "v4l2")


def _no_camera(name: str | None, reason: str) -> str:
    names, video = cameras_found(), f"or play a video with {option('camera', 'FILE')}"
    if not names:
        tried = f"the camera {name} cannot be opened ({reason}), and " if name else ""
        return f"{tried}no camera was found on this machine: plug one in, {video}"
    tried = f"the camera {name} cannot" if name else "no camera can"
    return (
        f"{tried} be opened ({reason}; found: {', '.join(names)}): name another with "
        f"{option('camera', 'NAME')}, {video}"
    )
