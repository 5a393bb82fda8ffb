"""Gives each of several outputs of one video its own copies of frames and packets."""

from collections.abc import Sequence
from fractions import Fraction
from typing import Any

import av
from av.filter import Graph
from makeup_video.pipeline.frames.frame import Frame
from makeup_video.pipeline.media.mux import Muxer


class CopyFrames:
    """Makes `count` frames of one, with the same time, colour tags and side data.

    The frames share their memory until somebody paints on one of them: `Frame.writable_planes` then
    copies the planes of that one.
    """

    def __init__(self, count: int) -> None:
        self._count = count
        self._source: Any = None
        self._sinks: list[Any] = []

    def __call__(self, frame: Frame) -> list[Frame]:
        if self._source is None:
            self._open(frame)
        self._source.push(frame.picture)
        pictures = [sink.pull() for sink in self._sinks]
        return [
            Frame(
                picture,
                frame.pts,
                frame.time_base,
                frame.tags,
                frame.rotation_degrees,
                frame.is_mirrored,
            )
            for picture in pictures
        ]

    def _open(self, frame: Frame) -> None:
        """Set up FFmpeg's filter `split`: PyAV itself cannot make two frames that share memory."""
        self._graph = Graph()
        self._source = self._graph.add_buffer(
            width=frame.width_px,
            height=frame.height_px,
            format=av.VideoFormat(frame.pix_fmt),
            time_base=frame.time_base,
        )
        split = self._graph.add("split", str(self._count))
        self._source.link_to(split)
        for index in range(self._count):
            sink = self._graph.add("buffersink")
            split.link_to(sink, index, 0)
            self._sinks.append(sink)
        self._graph.configure()


class CopyToAll:
    """Copies the packets of a video's other streams to several outputs; see StreamCopier.

    errors: for each output the error that ended it, or None. An ended output gets no more packets.
    When an output cannot take a packet, its error is noted here and its file is removed at once: on
    a full disk the other outputs need the space.
    """

    def __init__(self, muxers: Sequence[Muxer], errors: list[Exception | None]) -> None:
        self._muxers, self._errors = muxers, errors
        self.strict = muxers[0].strict

    def add_dropped(self, lines: Sequence[str]) -> None:
        for muxer in self._muxers:
            muxer.add_dropped(lines)

    def trim(self, start: Fraction | None, end: Fraction | None, shift: Fraction) -> None:
        for muxer in self._muxers:
            muxer.trim(start, end, shift)

    def copy(self, packet: Any) -> None:
        for index, muxer in enumerate(self._muxers):
            if self._errors[index] is None:
                try:
                    # passed separately, since PyAV cannot set is_discard on the copy
                    muxer.copy(copy_of(packet), is_hidden=packet.is_discard)
                except Exception as error:  # noqa: BLE001  # as in FanOut, ends this output only
                    self._errors[index] = self._errors[index] or error
                    muxer.abort()


def copy_of(packet: Any) -> Any:
    """A copy of a packet, with its stream, content, times and side data, and with its flags for key
    frames and damage.

    Each output needs its own copy, since muxers change a packet's stream and its times.
    """
    copy = av.Packet(packet.size)  # with the padding that decoders need
    if packet.size:
        copy.update(packet)
    copy.stream, copy.time_base = packet.stream, packet.time_base
    copy.pts, copy.dts, copy.duration = packet.pts, packet.dts, packet.duration
    copy.is_keyframe, copy.is_corrupt = packet.is_keyframe, packet.is_corrupt
    for data in packet.iter_sidedata():
        copy.set_sidedata(data)
    return copy
