"""The microphones of this machine."""

import re
import sys
from pathlib import Path

import av
from av.device import enumerate_input_devices

_SYSTEMS = {"linux": "alsa", "darwin": "avfoundation", "win32": "dshow"}
_ALSA_DEVICES = Path("/proc/asound/pcm")


def microphones_found() -> list[tuple[str, str]]:
    """List the microphones of the system: (FFmpeg's name of it, what it is called)."""
    if _system() == "alsa":
        return _alsa_microphones()
    if _system() == "avfoundation":
        return [("default", "the microphone that the system prefers")]
    try:
        found = enumerate_input_devices(_system())
    except (av.FFmpegError, NotImplementedError, ValueError):
        return []  # the system cannot list its microphones
    return [(one.name, one.description) for one in found if "audio" in one.media_types]


def _alsa_microphones() -> list[tuple[str, str]]:
    """The kernel's list of capture devices, after the system's default."""
    try:
        lines = _ALSA_DEVICES.read_text().splitlines()
    except OSError:
        return []  # no sound on this machine
    found = []
    for line in lines:  # such as "01-00: USB Audio : USB Audio : capture 1"
        place = re.match(r"(\d+)-(\d+): ([^:]*)", line)
        if place and "capture" in line:
            card, device = int(place[1]), int(place[2])
            found.append((f"plughw:{card},{device}", place[3].strip()))
    return [("default", "the microphone that the system prefers"), *found] if found else []


def _system() -> str:
    """FFmpeg's name for the sound interface of this system."""
    return _SYSTEMS.get("linux" if sys.platform.startswith("linux") else sys.platform, "alsa")
