"""Lists the cameras and microphones that FFmpeg finds on this machine, and reads their packets."""

import time
from collections.abc import Callable, Generator
from typing import Any, Literal

import av
from av.device import enumerate_input_devices

_NOT_YET_SECONDS = 0.002


def device_packets(
    container: Any, stream: Any, is_closing: Callable[[], bool]
) -> Generator[Any, None, None]:
    """Yield the packets of a device's stream until it ends or is_closing() is true.

    Raises FFmpeg's errors, except the one with which macOS reports "nothing yet": this waits.
    """
    while not is_closing():
        try:
            yield from container.demux(stream)
            return
        except av.BlockingIOError:
            time.sleep(_NOT_YET_SECONDS)


def input_devices(system: str, kind: Literal["video", "audio"]) -> list[Any]:
    """PyAV's DeviceInfo of each camera (video) or microphone (audio).

    system: FFmpeg's name for the system's interface, such as dshow.  Returns an empty list when
    that interface cannot list devices.
    """
    try:
        found = enumerate_input_devices(system)
    except (av.FFmpegError, NotImplementedError, ValueError):
        return []
    return [device for device in found if kind in device.media_types]
