"""Joins painted segments and the source's other streams into one video, without re-encoding."""

from collections.abc import Iterator, Sequence
from typing import Any

from makeup_video.pipeline.errors import EncodeError
from makeup_video.pipeline.frames.frame import Frame
from makeup_video.pipeline.media.decode import Decoder
from makeup_video.pipeline.media.encode import VideoEncoder
from makeup_video.pipeline.media.mux import Muxer
from makeup_video.pipeline.media.segment_file import SegmentFile
from makeup_video.pipeline.media.side_by_side import SideBySide

# Packets of video that are read before the output is opened, so that the first packets of the other
# streams are known by then.
_READ_AHEAD = 32


def first_frame(decoder: Decoder, *, compare: bool) -> Frame:
    """The video's first frame as the encoder gets it, but without makeup.

    All segments open their encoder with this frame, so that their parameter sets are the same.
    Raises as Decoder.frames does.
    """
    frames = decoder.frames()
    frame = next(frames)
    frames.close()
    return SideBySide(lambda same: same)(frame) if compare else frame


class Join:
    """One output of many segments.

    decoder: the source's, with nothing read yet; it gives the other streams to `muxer`.
    encoder: has the settings of all segments. It writes the output's header and encodes nothing.
    """

    def __init__(self, decoder: Decoder, encoder: VideoEncoder, muxer: Muxer) -> None:
        self._decoder, self._encoder, self._muxer = decoder, encoder, muxer

    def begin(self, *, compare: bool) -> None:
        """Open the output. This shows what would be lost before any segment is painted.

        Raises as a run without segments does.
        """
        frame = first_frame(self._decoder, compare=compare)
        while self._decoder.stats.packets < _READ_AHEAD:
            packet = next(self._decoder.packets, None)
            if packet is None:
                break
            self._copy(packet)
        self._encoder.open(frame)

    def finish(self, files: Sequence[SegmentFile]) -> None:
        """Write all packets in the source's order, and give the output its name.

        Each segment's file is removed once it has been read. The decoder's stats must already hold
        the counts of all segments.
        Raises EncodeError when the segments do not fit together, and OutputError.
        """
        for file in files:
            if file.headers != self._encoder.headers:
                raise EncodeError(
                    f"{file.path} has other parameter sets than the output, so it was encoded by "
                    "another version of the encoder: install the same version everywhere"
                )
        painted = _timed_packets(files)
        for _ in range(self._decoder.stats.packets):
            self._write_next(painted)
        for packet in self._decoder.packets:
            if not self._copy(packet):
                self._write_next(painted)
        for packet in painted:
            self._muxer.write(packet)
        self._decoder.finish()
        self._muxer.finish()

    def _copy(self, packet: Any) -> bool:
        """Give a packet of another stream to the output; False for one of the video."""
        if packet.stream.index == self._decoder.source.video.index:
            return False
        if packet.size:
            self._muxer.copy(packet)
        return True

    def _write_next(self, painted: Iterator[Any]) -> None:
        packet = next(painted, None)
        if packet is not None:
            self._muxer.write(packet)
        else:  # after the last packet of an excerpt, the rest of the file need not be read
            self._decoder.trim.is_past_end = self._decoder.trim.end is not None


def _timed_packets(files: Sequence[SegmentFile]) -> Iterator[Any]:
    """The packets of all segments, with decoding times that go on across the seams."""
    times = decoding_times(files)
    for file in files:
        for packet in file.packets():
            packet.dts = next(times)
            yield packet
        file.path.unlink(missing_ok=True)


def decoding_times(files: Sequence[SegmentFile]) -> Iterator[int]:
    """The decoding time of each packet, in ticks: as one encoder would give them.

    With x264 and x265 a packet is decoded when the picture `delay` places before it is shown. Each
    segment's encoder makes up times for its first `delay` packets. Here only the video's first
    `delay` packets get such times.
    """
    shown = sorted(time.pts for file in files for time in file.times)
    delay = max(map(_delay, files))
    early = shown[min(delay, len(shown) - 1)] - shown[0]
    for index in range(len(shown)):
        yield shown[index - delay] if index >= delay else shown[index] - early


def _delay(file: SegmentFile) -> int:
    """How many packets are decoded before the segment's first picture is shown."""
    first = min(time.pts for time in file.times)
    return sum(time.dts is not None and time.dts < first for time in file.times)
