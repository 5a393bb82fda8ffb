"""Frames of a live run -> packets whose times begin at 0, for recordings and streams."""

from collections.abc import Iterator
from fractions import Fraction
from typing import Any

import av
from av.codec.context import Flags
from makeup_video.pipeline.errors import EncodeError
from makeup_video.pipeline.frames.frame import Frame
from makeup_video.pipeline.live.interfaces import LIVE_TIME_BASE
from makeup_video.pipeline.media.encode import describe_pictures
from makeup_video.pipeline.media.scheduling import open_encoder


class LiveEncoder:
    """An encoder and its stream in `container`, opened for frames like the given one.

    The encoder only reads the pictures, since other sinks use them, too. There are no B-frames, so
    packets come in the order of their times.
    rate: frames per second, for rate control alone.
    bit_rate: bits per second; None when the options set the quality.
    global_header: the container stores the codec's headers once, not in each key frame.
    at_once: every picture comes out before the next one goes in.
    Raises EncodeError when the encoder refuses the frame.
    """

    def __init__(
        self,
        container: Any,
        encoder: str,
        options: dict[str, str],
        frame: Frame,
        rate: Fraction,
        *,
        bit_rate: int | None = None,
        global_header: bool = False,
        at_once: bool = False,
    ) -> None:
        self._encoder = encoder
        self._first_us = frame.pts
        self._last_us = frame.pts - 1
        self._stream = container.add_stream(encoder, rate=rate)
        describe_pictures(self._stream, frame)
        context = self._stream.codec_context
        self._stream.time_base = context.time_base = LIVE_TIME_BASE
        # frame threads use two cores better, but each thread holds back a picture
        context.thread_type = "SLICE" if at_once else "AUTO"
        if bit_rate is not None:
            context.bit_rate = bit_rate
        if global_header:
            context.flags |= Flags.global_header
        self._stream.options.update(options)
        try:
            open_encoder(context)
        except (av.FFmpegError, ValueError) as error:
            raise EncodeError(
                f"{encoder} refuses {frame.width_px}x{frame.height_px} {frame.pix_fmt}: "
                "choose another size"
            ) from error

    def __call__(self, picture: av.VideoFrame | None) -> Iterator[Any]:
        """Encode a picture and yield the packets that are ready; None flushes. Raises EncodeError.

        A picture that is not later than the last one is skipped.
        """
        if picture is not None:
            if picture.pts is None or picture.pts <= self._last_us:
                return
            self._last_us = picture.pts
        try:
            for packet in self._stream.encode_lazy(picture):
                yield self._from_zero(packet)
        except av.FFmpegError as error:
            raise EncodeError(f"{self._encoder} failed: {error.strerror}") from error

    def _from_zero(self, packet: Any) -> Any:
        ticks = round(self._first_us * LIVE_TIME_BASE / packet.time_base)
        if packet.pts is not None:
            packet.pts -= ticks
        if packet.dts is not None:
            packet.dts -= ticks
        return packet
