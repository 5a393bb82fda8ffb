"""Sends MPEG-TS through an ffmpeg program that supports SRT, since PyAV's FFmpeg does not."""

import contextlib
import errno
import os
import select
import shutil
import subprocess
from urllib.parse import urlsplit

import av
from makeup_video.pipeline.errors import InstallError

TIMEOUT_SECONDS = 5


class SrtRelay:
    """A file object for MPEG-TS: an `ffmpeg` on this machine sends the data written to it."""

    name = "relay"

    def __init__(self, program: str, url: str) -> None:
        command = [program, "-nostdin", "-loglevel", "quiet"]
        # microseconds of input that ffmpeg analyses before it sends anything; 5 seconds by default
        command += ["-analyzeduration", "500000", "-f", "mpegts", "-i", "pipe:0"]
        command += ["-c", "copy", "-f", "mpegts", url]
        self._process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )
        assert self._process.stdin is not None
        self._pipe = self._process.stdin.fileno()
        self.has_sent_all = False
        self._waits = os.name == "posix"  # elsewhere `select` cannot wait for a pipe
        if self._waits:
            os.set_blocking(self._pipe, False)

    def write(self, data: bytes) -> int:
        """Write all data. Raises OSError when the relay has ended, or takes none for 5 seconds."""
        rest = memoryview(data)
        while rest:
            if self._waits and not select.select([], [self._pipe], [], float(TIMEOUT_SECONDS))[1]:
                raise TimeoutError(errno.ETIMEDOUT, "the relay takes no more data")
            with contextlib.suppress(BlockingIOError):
                rest = rest[os.write(self._pipe, rest) :]
        return len(data)

    def close(self) -> None:
        """End the relay; one that still runs after a second is killed."""
        with contextlib.suppress(OSError):
            self._process.stdin and self._process.stdin.close()
        try:
            self.has_sent_all = self._process.wait(1) == 0
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()


def needs_relay(url: str) -> bool:
    """True when PyAV's FFmpeg lacks the protocol of the URL. This makes no connection."""
    if urlsplit(url).scheme.lower() != "srt":
        return False  # every build of FFmpeg has the other protocols
    try:
        av.open("srt:").close()
    except av.error.ProtocolNotFoundError:
        return True
    except (av.FFmpegError, OSError):
        return False
    return False


def relay_program(name: str) -> str:
    """Find an `ffmpeg` that supports SRT. Raises InstallError when there is none."""
    program = shutil.which("ffmpeg")
    if program:
        asked = subprocess.run(
            [program, "-hide_banner", "-protocols"], capture_output=True, text=True, check=False
        )
        if "srt" in asked.stdout.split():
            return program
    raise InstallError(
        f"{name} needs an ffmpeg with SRT on the PATH (apt install ffmpeg): install one, or use "
        "rtmp://"
    )
