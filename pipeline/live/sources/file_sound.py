"""The sound of a file that is played as the camera, in step with its pictures."""

import math
import time
from collections.abc import Generator
from contextlib import suppress
from pathlib import Path
from threading import Event
from typing import Any, Protocol

import av
from makeup_video.pipeline.live.sound import RATE, SoundBlock
from makeup_video.pipeline.media.input_file import lacks_format, open_container, packets_of

_POLL_SECONDS = 0.005
_SEEK_SECONDS = 1.0  # sound this much older than what is due now is not even decoded
_CHANNELS = {1: "mono", 2: "stereo"}


class Playing(Protocol):
    """How far a file has played; another thread sets this.

    turn: from 1, raised by every pass over the file, and where the file plays on late.
    zero_seconds: when time 0 of the file is due in this turn, by time.monotonic(); None before the
    first picture of the turn.
    """

    turn: int
    zero_seconds: float | None


class FileSound:
    """Plays a file's first decodable audio stream, each block when it is due.

    playing: how far the file's pictures have played.
    """

    def __init__(self, path: Path, playing: Playing) -> None:
        self._path, self._playing = path, playing
        self._closing = Event()
        self.name = path.name
        with open_container(path) as container:
            self.channels = min(2, _sound_in(container).codec_context.channels)

    def close(self) -> None:
        self._closing.set()

    def blocks(self) -> Generator[SoundBlock, None, None]:
        turn = 0
        while (turn := self._next_turn(turn)) and not self._closing.is_set():
            yield from self._one_turn(turn)

    def _next_turn(self, before: int) -> int:
        """Wait for the pictures' next turn; 0 after `close`."""
        while self._playing.turn == before or self._playing.zero_seconds is None:
            if self._closing.wait(_POLL_SECONDS):
                return 0
        return self._playing.turn

    def _one_turn(self, turn: int) -> Generator[SoundBlock, None, None]:
        resampler = av.AudioResampler("fltp", _CHANNELS[self.channels], RATE)
        with open_container(self._path) as container:
            least = self._past_seconds(turn)
            _seek(container, least)
            for frame in _frames(container):
                if frame.pts is None or frame.time_base is None:
                    continue
                seconds = float(frame.pts * frame.time_base)
                if seconds < least:
                    continue
                for piece in resampler.resample(frame):
                    samples = piece.to_ndarray()
                    zero = self._zero_of(turn)
                    if zero is None:
                        return  # the pictures have begun another turn
                    due = zero + seconds
                    if self._closing.wait(max(0.0, due - time.monotonic())):
                        return
                    yield SoundBlock(samples, due, is_exact=True)
                    seconds += samples.shape[1] / RATE

    def _past_seconds(self, turn: int) -> float:
        """A time in the file shortly before what is due now: a recording may begin late."""
        zero = self._zero_of(turn)
        return -math.inf if zero is None else time.monotonic() - zero - _SEEK_SECONDS

    def _zero_of(self, turn: int) -> float | None:
        zero = self._playing.zero_seconds
        return zero if self._playing.turn == turn else None


def has_sound(path: Path) -> bool:
    """Whether a file has an audio stream that can be decoded."""
    with open_container(path) as container:
        return _sound_in(container) is not None


def _sound_in(container: Any) -> Any:
    """The first audio stream that can be decoded; None without one."""
    for stream in container.streams.audio:
        if stream.codec_context is not None and not lacks_format(stream):
            return stream
    return None


def _seek(container: Any, seconds: float) -> None:
    """Go to a time of the file, or a little before; a file that cannot seek stays where it is."""
    if seconds > (container.start_time or 0) / av.time_base:
        with suppress(av.FFmpegError):
            container.seek(round(seconds * av.time_base))


def _frames(container: Any) -> Generator[av.AudioFrame, None, None]:
    """Decode the audio, without damaged packets. A file that is cut short ends at the cut."""
    with suppress(av.FFmpegError):
        for packet in packets_of(container, _sound_in(container)):
            yield from _decoded(packet)


def _decoded(packet: Any) -> Generator[av.AudioFrame, None, None]:
    with suppress(av.FFmpegError):
        yield from packet.decode()
