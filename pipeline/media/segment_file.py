"""The file of one painted segment: the encoder's packets as they are, and nothing else.

NUT stores the packets of most codecs unchanged, while mp4 and Matroska rewrite those of H.264, HEVC
and AV1. But only WebM and Matroska can hold VP9's transparency, which lies beside the packets, and
NUT does not know ProRes. Such videos take the output's own container, which stores those codecs
unchanged.
"""

import contextlib
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path
from typing import Any, NamedTuple

import av
from makeup_video.pipeline.errors import OutputError
from makeup_video.pipeline.files.output_file import write_errors
from makeup_video.pipeline.media.input_file import VideoSource

_RAW = "nut"
# FFmpeg's parsers must not change the packets
_AS_STORED = {"protocol_whitelist": "file", "fflags": "noparse+nofillin"}


class PacketTime(NamedTuple):
    """The times that the encoder gave a packet, in ticks of the output; dts may be missing."""

    pts: int
    dts: int | None
    duration: int


@dataclass(frozen=True, slots=True)
class SegmentFile:
    """A painted segment that is whole.

    format: FFmpeg's name of its container.  tick: the unit of `times`, in seconds.
    headers: the encoder's parameter sets, as FFmpeg's extradata.
    times: the times of its packets, in the order of the file.
    """

    path: Path
    format: str
    tick: Fraction
    headers: bytes
    times: tuple[PacketTime, ...]

    def packets(self) -> Iterator[Any]:
        """The packets with their times. Raises OutputError when the file has lost some."""
        count = 0
        try:
            with av.open(
                f"file:{self.path}", format=self.format, container_options=_AS_STORED
            ) as file:
                stored = (packet for packet in file.demux(file.streams[0]) if packet.size)
                for packet, time in zip(stored, self.times, strict=False):
                    count += 1
                    packet.pts, packet.dts, packet.duration = time.pts, time.dts, time.duration
                    packet.time_base = self.tick
                    yield packet
        except (av.FFmpegError, IndexError) as error:
            raise OutputError(f"{self.path} cannot be read back: {error}; run again") from error
        if count != len(self.times):
            raise OutputError(
                f"{self.path} has {count} packets, but {len(self.times)} were written: run again"
            )


class SegmentWriter:
    """Writes the packets of one segment; VideoEncoder and Decoder use it in place of a Muxer.

    format: of the output in which the segments are joined; times are in its ticks.
    Packets of other streams are ignored.
    dropped: losses from the first frame on, which the joined video reports, too.
    later: losses that begin at a later frame.
    """

    strict = False

    def __init__(self, path: Path, container_format: str) -> None:
        self.path, self.format = path, container_format
        self.dropped: list[str] = []
        self.later: list[str] = []
        self.is_finished = False
        self._own_format = _RAW
        self._container: Any = None
        self._video: Any = None
        self._tick = Fraction(0)
        self._times: list[PacketTime] = []

    @property
    def video_packets(self) -> int:
        return len(self._times)

    def add_dropped(self, lines: Sequence[str]) -> None:
        self.dropped += lines

    def drop(self, what: str) -> None:
        """Note what is lost from now on."""
        self.later.append(what)

    def trim(self, start: Fraction | None, end: Fraction | None, shift: Fraction) -> None:
        """Does nothing: only the painted video is written."""

    def copy(self, packet: Any) -> None:
        """Does nothing: packets of other streams are copied when the segments are joined."""

    def open(self, source: VideoSource, add_video: Callable[[Any], Any]) -> Any:
        """Create the file; add_video(container) adds and returns the only stream."""
        with write_errors(self.path):
            if source.has_alpha:
                self._own_format = self.format
            self._container = self._opened()
            try:
                self._video = add_video(self._container)
            except ValueError:  # NUT has no name for the codec
                self._container.close()
                self._own_format = self.format
                self._container = self._opened()
                self._video = add_video(self._container)
        return self._video

    def _opened(self) -> Any:
        return av.open(f"file:{self.path}", "w", format=self._own_format)

    def start(self) -> None:
        """Write the header. The encoder is open by now."""
        with write_errors(self.path):
            self._tick = self._video.codec_context.time_base
            self._container.start_encoding()

    def write(self, packet: Any) -> None:
        self._times.append(PacketTime(packet.pts, packet.dts, packet.duration or 0))
        with write_errors(self.path):
            packet.stream = self._video
            self._container.mux_one(packet)

    def finish(self, keep_part: bool = False) -> None:
        """Close the file. keep_part: the segment is not whole, so its file is removed."""
        if keep_part:
            self.abort()
            return
        with write_errors(self.path):
            self._container.close()
        self.is_finished = True

    def abort(self) -> None:
        """Close and remove the file. Never raises: it runs after another error."""
        with contextlib.suppress(Exception):
            if self._container is not None:
                self._container.close()
        with contextlib.suppress(OSError):
            self.path.unlink(missing_ok=True)

    def file(self, headers: bytes) -> SegmentFile:
        """The file, once it is whole."""
        return SegmentFile(self.path, self._own_format, self._tick, headers, tuple(self._times))
