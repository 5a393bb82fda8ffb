"""Sends MPEG-TS on by an ffmpeg that knows SRT: PyAV's build does not."""

import contextlib
import os
import select
import shutil
import subprocess
from urllib.parse import urlsplit

import av
from makeup_video.pipeline.errors import UsageError

TIMEOUT_SECONDS = 5


class SrtRelay:
    """A file to write MPEG-TS to, which an `ffmpeg` on this machine sends on: PyAV's has no SRT."""

    name = "relay"

    def __init__(self, program: str, url: str) -> None:
        command = [program, "-nostdin", "-loglevel", "quiet"]
        # it looks at so many microseconds before it sends anything; 5 seconds, if nothing is said
        command += ["-analyzeduration", "500000", "-f", "mpegts", "-i", "pipe:0"]
        command += ["-c", "copy", "-f", "mpegts", url]
        self._process = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
        )
        assert self._process.stdin is not None
        self._pipe = self._process.stdin.fileno()
        self.has_sent_all = False
        self._waits = os.name == "posix"  # elsewhere a pipe cannot be waited for
        if self._waits:
            os.set_blocking(self._pipe, False)

    def write(self, data: bytes) -> int:
        """Raises OSError when the relay has ended, or takes nothing for some seconds."""
        rest = memoryview(data)
        while rest:
            if self._waits and not select.select([], [self._pipe], [], float(TIMEOUT_SECONDS))[1]:
                raise TimeoutError(110, "nothing is taken any more")
            with contextlib.suppress(BlockingIOError):
                rest = rest[os.write(self._pipe, rest) :]
        return len(data)

    def close(self) -> None:
        with contextlib.suppress(OSError):
            self._process.stdin and self._process.stdin.close()
        try:
            self.has_sent_all = self._process.wait(1) == 0
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()


def needs_relay(url: str) -> bool:
    """True when FFmpeg as PyAV brings it does not know the protocol; nothing is connected for that."""
    scheme = urlsplit(url).scheme.lower()
    if scheme != "srt":
        return False  # the others are always there
    try:
        av.open(f"{scheme}:").close()
    except av.error.ProtocolNotFoundError:
        return True
    except (av.FFmpegError, OSError):
        return False
    return False


def relay_program(name: str) -> str:
    """An `ffmpeg` that knows SRT. Raises UsageError when there is none."""
    program = shutil.which("ffmpeg")
    if program:
        asked = subprocess.run(
            [program, "-hide_banner", "-protocols"], capture_output=True, text=True, check=False
        )
        if "srt" in asked.stdout.split():
            return program
    raise UsageError(
        f"{name} needs an ffmpeg with SRT on the PATH (apt install ffmpeg): install one, or use rtmp://"
    )
