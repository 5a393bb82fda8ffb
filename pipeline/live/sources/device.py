"""A camera of this machine -> Frame ...: the newest wins, and it may be unplugged and come back."""

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
from av.device import enumerate_input_devices
from makeup_video.pipeline.errors import InputError, MakeupVideoError
from makeup_video.pipeline.frames.frame import Frame
from makeup_video.pipeline.live.sources.freshness import Freshness
from makeup_video.pipeline.live.sources.normalise import NormaliseCamera

_SYSTEMS = {"linux": "v4l2", "darwin": "avfoundation", "win32": "dshow"}
_RETRY_SECONDS = 1.0
_SILENT_SECONDS = 2.0  # a camera that sends nothing for so long is as good as gone
_NOT_THERE = (errno.ENOENT, errno.ENODEV, errno.ENXIO)
_HELP = {
    errno.EACCES: "you may not use it: add yourself to the group video, or allow cameras in the settings",
    errno.EBUSY: "another program uses it: close that",
}


@dataclass(frozen=True, slots=True)
class CameraRequest:
    """What is asked of a camera; None: what it likes best.  pixels: "mjpeg" or "yuyv422"."""

    size: str | None
    rate: int | None
    pixels: str | None


def open_camera(name: str, system: str, options: dict[str, str]) -> Any:
    """The one place where a device is opened: FFmpeg's container, whose packets are the pictures."""
    if system == "dshow" and not name.startswith("video="):
        name = f"video={name}"
    return av.open(name, format=system, container_options=options)


def devices_found() -> list[str]:
    """The cameras that the system knows, as `open_camera` wants them named."""
    if sys.platform.startswith("linux"):
        paths = [path for path in Path("/dev").glob("video*") if path.name[5:].isdecimal()]
        return [str(path) for path in sorted(paths, key=lambda path: int(path.name[5:]))]
    if sys.platform == "darwin":
        return ["default"]  # AVFoundation's own word for the camera that the system prefers
    try:
        found = enumerate_input_devices(_system())
    except (av.FFmpegError, NotImplementedError, ValueError):
        return []  # the system cannot list them: that no camera was found is told with how to name one
    return [each.name for each in found if "video" in each.media_types]


def attempts(wish: CameraRequest, system: str) -> list[dict[str, str]]:
    """Options for opening, the best first. MJPEG reaches 720p at 30 a second on USB 2, where YUYV gives
    10; the last attempt asks for nothing."""
    common = {"fflags": "nobuffer"}  # or what FFmpeg reads to look at it comes out again, old
    asked = dict(common)
    if wish.size:
        asked["video_size"] = wish.size
    if wish.rate:
        asked["framerate"] = str(wish.rate)
    spelling = {"v4l2": ("input_format", "input_format"), "dshow": ("vcodec", "pixel_format")}
    mjpeg, raw = spelling.get(system, ("", "pixel_format"))
    each = {"mjpeg": {mjpeg: "mjpeg"}, "yuyv422": {raw: "yuyv422"}}
    order = [wish.pixels] if wish.pixels else []
    order += [name for name in each if name != wish.pixels] if system != "avfoundation" else []
    named = [each[name] for name in order if "" not in each[name]]
    without_size = {key: value for key, value in asked.items() if key != "video_size"}
    tries = [{**asked, **one} for one in named] + [asked, without_size, common]
    return [one for index, one in enumerate(tries) if one not in tries[:index]]


class DeviceCamera:
    """Reads a camera on a thread of its own from the moment it is made, and keeps the newest picture.

    say: gets a line when something changes: it gives other than was asked, it is gone, it is back.
    dropped: pictures that were old before they were read, or that nobody fetched, counted from when
    `frames` was asked for.  damaged: packets that could not be decoded.  notice: what there is to
    say about it now, "" when all is well.
    Raises InputError when there is no such camera.
    """

    def __init__(self, name: str | None, wish: CameraRequest, say: Callable[[str], None]) -> None:
        self._asked, self._wish, self._say = name, wish, say
        self.rate = Fraction(wish.rate or 30)
        self.name = name or ""
        self.dropped = self.damaged = 0
        self.notice = ""
        self._door = NormaliseCamera(is_device=True)
        self._closing = Event()
        self._news = Condition()
        self._newest: Frame | None = None
        self._is_asked = False  # before that nobody misses a picture
        self._failure: Exception | None = None
        self._has_ended_well = False  # whether JPEGs of this camera end as they should
        container = self._open()
        self._tell_what_it_gives(container)
        self._thread = Thread(
            target=self._run, args=(container,), name="makeup-camera", daemon=True
        )
        self._thread.start()

    def close(self) -> None:
        self._closing.set()
        with self._news:
            self._news.notify_all()
        self._thread.join(_RETRY_SECONDS)  # a read that hangs is left behind, on a daemon's thread

    def frames(self) -> Generator[Frame, None, None]:
        """The newest picture each time, until `close`. Raises what the reading thread could not handle."""
        self._is_asked = True
        return self._fetched()

    def _fetched(self) -> Generator[Frame, None, None]:
        while (frame := self._next()) is not None:
            yield frame
            del frame

    def _next(self) -> Frame | None:
        """Wait for a picture; None after `close`."""
        with self._news:
            while not self._news.wait_for(self._has_news, _SILENT_SECONDS):
                if not self.notice:
                    self._tell(f"camera {self.name} sends no pictures: waiting for it")
            if self._failure is not None:
                raise self._failure
            frame, self._newest = self._newest, None
        return None if self._closing.is_set() else frame

    def _has_news(self) -> bool:
        return self._newest is not None or self._failure is not None or self._closing.is_set()

    def _tell(self, notice: str, line: str = "") -> None:
        """Said once: a camera that opens and gives nothing is gone all the time."""
        if notice == self.notice:
            return
        self.notice = notice
        self._say(line or notice)

    # -- the reading thread --------------------------------------------------------------------

    def _run(self, container: Any) -> None:
        try:
            while not self._closing.is_set():
                try:
                    self._read(container)
                except MakeupVideoError:
                    raise  # its pictures cannot be used
                except (av.FFmpegError, OSError):
                    pass  # it was unplugged
                finally:
                    container.close()
                if self._closing.is_set():
                    return
                self._tell(f"camera {self.name} is gone: waiting for it")
                container = self._open_again()
        except Exception as error:  # noqa: BLE001  # raised again by `frames`
            with self._news:
                self._failure = error
                self._news.notify_all()

    def _open_again(self) -> Any:
        while not self._closing.wait(_RETRY_SECONDS):
            try:
                return self._open()
            except InputError:
                continue
        return _Nothing()

    def _read(self, container: Any) -> None:
        """Until the camera fails, ends, or is closed."""
        video = container.streams.video[0]
        context = video.codec_context
        context.thread_count = 1  # more threads hold pictures back
        freshness = Freshness()
        independent = context.name in ("mjpeg", "rawvideo")  # of others none may be left out
        began = time.monotonic()
        for packet in self._packets(container, video):
            now = time.monotonic()
            stamp = None if packet.pts is None else float(packet.pts * packet.time_base)
            arrived = freshness(stamp, now, now - began)
            if not packet.size:
                self.damaged += 1  # V4L2: the driver says that the picture is spoilt
            elif arrived is not None or not independent:
                self._decode(context, packet, now if arrived is None else arrived)
            else:
                self.dropped += self._is_asked
            del packet  # its memory is the camera's
            if self._closing.is_set():
                return
            began = time.monotonic()

    def _packets(self, container: Any, video: Any) -> Generator[Any, None, None]:
        while not self._closing.is_set():
            try:
                yield from container.demux(video)
                return
            except av.BlockingIOError:
                self._closing.wait(0.002)  # macOS: no picture yet
            except av.InvalidDataError:
                self.damaged += 1  # V4L2: a picture of which not everything came

    def _decode(self, context: Any, packet: Any, arrived: float) -> None:
        """Decode a copy: the packet's memory belongs to the driver, wants it back soon, and loses it when the
        camera is closed."""
        data = bytes(packet)
        if not self._is_whole(context, data):
            self.damaged += 1
            return
        try:
            pictures = context.decode(av.Packet(data))
        except av.FFmpegError:
            self.damaged += 1
            return
        for picture in pictures:
            if picture.is_corrupt:
                self.damaged += 1
            else:
                self._show(self._door(picture, arrived))

    def _is_whole(self, context: Any, data: bytes) -> bool:
        """False for a JPEG that breaks off, which the decoder would fill with grey. Some cameras end
        none as they should: those are believed."""
        if context.name != "mjpeg":
            return True
        begins, end = data.find(b"\xff\xda"), data.rfind(b"\xff\xd9")
        ends = end > begins
        self._has_ended_well |= ends
        return ends or not self._has_ended_well

    def _show(self, frame: Frame) -> None:
        with self._news:
            self.dropped += self._is_asked and self._newest is not None
            self._newest = frame
            self._news.notify_all()
        if self.notice:
            self._tell("", f"camera {self.name} is back")

    # -- opening -------------------------------------------------------------------------------

    def _open(self) -> Any:
        names = [self._asked] if self._asked else devices_found()
        reason = "none was found"
        for name in names:
            for options in attempts(self._wish, _system()):
                try:
                    container = open_camera(name, _system(), options)
                except (av.FFmpegError, OSError, ValueError) as error:
                    number = getattr(error, "errno", None) or 0
                    reason = _HELP.get(number) or getattr(error, "strerror", None) or str(error)
                    if number in _NOT_THERE or number in _HELP:
                        break
                    continue
                if container.streams.video:
                    self.name = name
                    return container
                container.close()
                reason = "it gives no pictures"
        raise InputError(_no_camera(self._asked, reason))

    def _tell_what_it_gives(self, container: Any) -> None:
        """One line when it is other than what was asked for."""
        video, wish = container.streams.video[0], self._wish
        size = f"{video.codec_context.width}x{video.codec_context.height}"
        rate = video.average_rate or video.guessed_rate
        pixels = {"rawvideo": video.codec_context.pix_fmt}.get(video.name, video.name)
        differs = []
        if wish.size and size != wish.size:
            differs.append(f"{size}, not {wish.size}")
        if rate and 0 < rate <= 240:
            self.rate = Fraction(rate)
            if wish.rate and abs(float(rate) - wish.rate) > 0.5:
                differs.append(f"{float(rate):.3g} frames a second, not {wish.rate}")
        if wish.pixels and pixels != wish.pixels:
            differs.append(f"{pixels}, not {wish.pixels}")
        if differs:
            self._say(f"camera {self.name} gives {'; '.join(differs)}")


class _Nothing:
    """Stands for a camera that never came back before the run ended."""

    def close(self) -> None: ...


def _system() -> str:
    """FFmpeg's name of the way to cameras on this system."""
    return _SYSTEMS.get("linux" if sys.platform.startswith("linux") else sys.platform, "v4l2")


def _no_camera(asked: str | None, reason: str) -> str:
    found = devices_found()
    seen = f"found: {', '.join(found)}" if found else "no camera was found on this machine"
    what = f"the camera {asked} cannot be opened" if asked else "no camera can be opened"
    return f"{what} ({reason}; {seen}): plug one in and name it, or give a video file in its place"
