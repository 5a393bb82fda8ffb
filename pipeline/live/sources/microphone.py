"""A microphone of this machine -> blocks of sound."""

import os
import re
import sys
import time
from collections.abc import Callable, Generator
from pathlib import Path
from typing import Any

import av
import numpy as np
from makeup_video.pipeline.errors import InputError, reason_of
from makeup_video.pipeline.live.sound import RATE, SoundBlock
from makeup_video.pipeline.live.sources.input_devices import device_packets, input_devices

_SYSTEMS = {"linux": "alsa", "darwin": "avfoundation", "win32": "dshow"}
_ALSA_CONFIG = Path("/usr/share/alsa/alsa.conf")
_ALSA_DEVICES = Path("/proc/asound/pcm")
_RETRY_SECONDS = 1.0


def microphones_found() -> list[tuple[str, str]]:
    """List the system's microphones: (the name that Microphone takes, a name for people)."""
    if _system() == "alsa":
        return _alsa_microphones()
    if _system() == "avfoundation":
        return [("default", "the microphone that the system prefers")]
    return [(one.name, one.description) for one in input_devices(_system(), "audio")]


class Microphone:
    """Reads a microphone. When it is unplugged, opening it is tried again once a second.

    name: as microphones_found lists it; None: the first microphone that opens.
    log: called with a line of text when the microphone is gone, and when it is back.
    Raises InputError when no microphone can be opened.
    """

    def __init__(self, name: str | None, log: Callable[[str], None]) -> None:
        self._log = log
        self._is_closing = False
        names = [name] if name else [found for found, _ in microphones_found()]
        self._container, self.name = _first_open(names, name)
        context = self._container.streams.audio[0].codec_context
        self.channels = min(2, context.channels)

    def close(self) -> None:
        self._is_closing = True

    def blocks(self) -> Generator[SoundBlock, None, None]:
        """Yield the sound until `close`."""
        while not self._is_closing:
            try:
                yield from self._read()
            except (av.FFmpegError, OSError):
                pass  # the microphone was unplugged
            finally:
                self._container.close()
            if self._is_closing:
                return
            self._log(f"microphone {self.name} is gone: waiting for it")
            self._open_again()

    def _read(self) -> Generator[SoundBlock, None, None]:
        layout = "mono" if self.channels == 1 else "stereo"
        resampler = av.AudioResampler("fltp", layout, RATE)
        stream = self._container.streams.audio[0]
        for packet in device_packets(self._container, stream, lambda: self._is_closing):
            now = time.monotonic()
            pieces = [
                resampled.to_ndarray()
                for frame in packet.decode()
                for resampled in resampler.resample(_without_time(frame))
            ]
            if pieces:
                samples = np.concatenate(pieces, axis=1)
                yield SoundBlock(samples, now - samples.shape[1] / RATE)
            if self._is_closing:
                return

    def _open_again(self) -> None:
        while not self._is_closing:
            time.sleep(_RETRY_SECONDS)
            try:
                self._container, _ = _first_open([self.name], self.name)
            except InputError:
                continue
            self._log(f"microphone {self.name} is back")
            return


def _without_time(frame: av.AudioFrame) -> av.AudioFrame:
    """The frame without its pts, by which the resampler would see gaps and fill them."""
    frame.pts = None
    return frame


def _first_open(names: list[str], wanted: str | None) -> tuple[Any, str]:
    reason = "none was found"
    for name in names:
        try:
            container = _open(name)
        except (av.FFmpegError, OSError, ValueError) as error:
            reason = reason_of(error)
            continue
        if container.streams.audio:
            return container, name
        container.close()
        reason = "it gives no audio"
    found = ", ".join(name for name, _ in microphones_found()) or "none"
    problem = f"the microphone {wanted} cannot be opened" if wanted else "no microphone opens"
    raise InputError(f"{problem} ({reason}; found: {found}): name another one, or none")


def _open(name: str) -> Any:
    system = _system()
    if system == "alsa":
        # PyAV's own ALSA library looks for its configuration in the folder where it was built
        if _ALSA_CONFIG.exists():
            os.environ.setdefault("ALSA_CONFIG_PATH", str(_ALSA_CONFIG))
        for channels in ("2", "1"):
            try:
                options = {"sample_rate": str(RATE), "channels": channels}
                return av.open(name, format=system, container_options=options)
            except (av.FFmpegError, OSError) as error:
                failure = error
        raise failure
    place = f"audio={name}" if system == "dshow" else f":{name}"
    return av.open(place, format=system)


def _alsa_microphones() -> list[tuple[str, str]]:
    """The system's default, then the kernel's list of capture devices; empty without any."""
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
    return _SYSTEMS.get(sys.platform, "alsa")
