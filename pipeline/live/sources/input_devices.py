"""Lists the cameras and microphones that FFmpeg finds on a system."""

from typing import Any, Literal

import av
from av.device import enumerate_input_devices


def input_devices(system: str, kind: Literal["video", "audio"]) -> list[Any]:
    """PyAV's DeviceInfo of each camera (video) or microphone (audio).

    system: FFmpeg's name for the interface of the system, such as dshow. Empty where that cannot
    list devices.
    """
    try:
        found = enumerate_input_devices(system)
    except (av.FFmpegError, NotImplementedError, ValueError):
        return []
    return [device for device in found if kind in device.media_types]
