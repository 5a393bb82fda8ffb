"""Encodes the painted frames, with the colour tags and metadata of the source."""

import os
import time
from collections.abc import Callable, Iterator, Sequence
from fractions import Fraction
from typing import Any, Protocol

import av
from av.codec.context import Flags
from makeup_video.pipeline.errors import EncodeError, UsageError, option
from makeup_video.pipeline.frames.colour_tags import FULL_RANGE, is_full_range
from makeup_video.pipeline.frames.display_matrix import matrix_of
from makeup_video.pipeline.frames.frame import Frame
from makeup_video.pipeline.media.codecs import CODECS, MATROSKA, MP4, VideoCodec, codecs_with
from makeup_video.pipeline.media.hardware import add_stream, handed_format
from makeup_video.pipeline.media.hdr import hdr_parameters
from makeup_video.pipeline.media.input_file import VideoSource
from makeup_video.pipeline.media.lost_side_data import lost_side_data
from makeup_video.pipeline.media.sample_description import DOLBY_VISION, lost_descriptions
from makeup_video.pipeline.media.scheduling import open_encoder

_STOP_SECONDS = 0.5  # after Ctrl-C, flushing the encoder may take no longer than this
# A video of so few frames has no B-frames. x265 returns random decoding times for it, which mp4
# and mov often refuse.
_FEW_FRAMES = 2
_BOTTOM_FIRST = (3, 4)  # FFmpeg's AV_FIELD_BB and AV_FIELD_TB: which field is shown first


class PacketWriter(Protocol):
    """Writes the encoder's packets to a file; see Muxer and SegmentWriter.

    format: FFmpeg's name of the output's container.  dropped: one line for each loss.
    """

    format: str
    dropped: list[str]

    def open(self, source: VideoSource, add_video: Callable[[Any], Any]) -> Any: ...
    def start(self) -> None: ...
    def write(self, packet: Any) -> None: ...
    def drop(self, what: str) -> None: ...
    def finish(self, keep_part: bool = False) -> None: ...


class VideoEncoder:
    """The pipeline's sink: opens encoder and output with the first frame, then encodes each frame.

    options: the encoder's own, from `encoder_options`.  threads: 0 lets the encoder choose.
    note: how the encoder was chosen, for the report.
    first_packet_at: when the first packet came, in seconds of Unix time; None before.
    max_pts_error_seconds: the largest distance between a frame's time and the time written.
    headers: the encoder's parameter sets as FFmpeg's extradata, once it is open.
    span: after the run, when the first frame begins and when the last one ends, in seconds.
    """

    def __init__(
        self,
        muxer: PacketWriter,
        source: VideoSource,
        codec: VideoCodec,
        options: dict[str, str],
        threads: int = 0,
        note: str = "",
    ) -> None:
        self.muxer, self.source, self.codec, self.note = muxer, source, codec, note
        self.options, self.threads = dict(options), threads
        self.max_pts_error_seconds = Fraction(0)
        self.first_packet_at: float | None = None
        self.headers = b""
        self._stream: Any = None
        self._tick = Fraction(0)
        self._frames = 0
        self._first_pts: int | None = None
        self._last_pts: int | None = None
        self._last_duration = 1
        self._durations: dict[int, int] = {}  # of the frames in the encoder, by pts
        self._is_interlaced = False

    def __call__(self, frame: Frame) -> None:
        """Raises EncodeError when the encoder refuses its settings or a frame."""
        self.open(frame)
        picture = frame.picture
        if picture.interlaced_frame and not self._is_interlaced:
            self._is_interlaced = True
            self.muxer.drop(f"fields from {frame.seconds:.2f} s on: the video begins without any")
        duration = picture.duration
        # in the source's own ticks there is nothing to convert, and fractions are slow
        is_same = frame.time_base == self._tick
        if not is_same:
            duration = round(duration * frame.time_base / self._tick)
        picture.pts, picture.time_base = self._ticks(frame, is_same), self._tick
        picture.duration = self._durations[picture.pts] = duration
        if self._first_pts is None:
            self._first_pts = picture.pts
        self._last_duration = max(1, duration)
        self._frames += 1
        for packet in self._encode(picture):
            self._write(packet)

    def finish(self, stopped: bool) -> None:
        """Flush the encoder and close the file; after Ctrl-C a playable part file remains."""
        if self._stream is None:
            return
        deadline = time.monotonic() + _STOP_SECONDS
        for packet in self._encode(None):  # all packets of a video shorter than the look-ahead
            if self._frames <= _FEW_FRAMES:
                packet.dts = packet.pts
            self._write(packet)
            if stopped and time.monotonic() > deadline:
                break
        self.muxer.finish(keep_part=stopped)

    @property
    def span(self) -> tuple[Fraction, Fraction]:
        if self._first_pts is None or self._last_pts is None:
            return Fraction(0), Fraction(0)
        end = self._last_pts + self._last_duration
        return self._first_pts * self._tick, end * self._tick

    def _write(self, packet: Any) -> None:
        # SVT-AV1 loses the durations, and FFmpeg's muxers would guess the last one
        packet.duration = self._durations.pop(packet.pts, 0) or packet.duration
        self.muxer.write(packet)
        self.first_packet_at = self.first_packet_at or time.time()

    def _encode(self, picture: av.VideoFrame | None) -> Iterator[Any]:
        """Packets as the encoder returns them; None flushes the encoder."""
        try:
            yield from self._stream.encode_lazy(picture)
        except av.FFmpegError as error:
            raise EncodeError(
                f"{self.codec.encoder} failed after pts {self._last_pts}: {error.strerror}"
            ) from error

    def _ticks(self, frame: Frame, is_same: bool) -> int:
        """The frame's time in the output's ticks: exact, or the nearest one that still increases.

        is_same: the frame has these ticks already.
        """
        pts = frame.pts if is_same else round(frame.pts * frame.time_base / self._tick)
        if self._last_pts is not None and pts <= self._last_pts:
            pts = self._last_pts + 1
        self._last_pts = pts
        if not is_same or pts != frame.pts:
            off = abs(pts * self._tick - frame.pts * frame.time_base)
            self.max_pts_error_seconds = max(self.max_pts_error_seconds, off)
        return pts

    def open(self, frame: Frame) -> None:
        """Open encoder and output for frames like this one, unless they are open already."""
        if self._stream is not None:
            return
        stream = self.muxer.open(self.source, lambda container: self._add(container, frame))
        try:
            open_encoder(stream.codec_context)
        except (av.FFmpegError, ValueError) as error:
            shown = " ".join(f"{key}={value}" for key, value in self.options.items())
            raise EncodeError(
                f"{self.codec.encoder} refuses {frame.width_px}x{frame.height_px} {frame.pix_fmt} "
                f"with {shown or 'its defaults'}: choose another size, "
                f"{option('hardware' if self.codec.is_hardware else 'codec')} or {option('preset')}"
            ) from error
        self.headers = bytes(stream.codec_context.extradata or b"")
        self.muxer.start()
        self._stream = stream

    def _add(self, container: Any, frame: Frame) -> Any:
        """The output's video stream, with all that the source declares about its pictures."""
        # Matroska's only tick is the millisecond
        self._tick = Fraction(1, 1000) if self.muxer.format in MATROSKA else frame.time_base
        stream = add_stream(container, self.codec, self.source.rate)
        context = stream.codec_context
        describe_pictures(stream, frame)
        context.pix_fmt = handed_format(self.codec, frame.pix_fmt)
        name_codec(stream, self.codec, container.format.name)
        stream.time_base = context.time_base = self._tick
        context.thread_count = self.threads
        # PyAV's default is slice threads; x264 keeps two cores busier with frame threads
        context.thread_type = "AUTO"
        # libvpx then uses every frame's own duration
        context.flags |= Flags.frame_duration
        context.sample_aspect_ratio = self.source.video.sample_aspect_ratio or Fraction(0, 1)
        self._keep_fields(context, frame)
        self._keep_hdr(frame)
        keep_quiet(self.options, self.codec)
        stream.options.update(self.options)
        return stream

    def _keep_fields(self, context: Any, frame: Frame) -> None:
        if not frame.picture.interlaced_frame:
            return
        self._is_interlaced = True
        if not self.codec.interlaced:
            raise UsageError(
                f"the source is interlaced and {self.codec.name} cannot keep its fields: "
                f"{self._field_keepers()}, or deinterlace it first"
            )
        context.flags |= Flags.interlaced_dct | Flags.interlaced_me
        order = self.source.video.codec_context.field_order
        context.field_order = order
        if order in _BOTTOM_FIRST:
            add_parameters(self.options, self.codec, self.codec.bottom_first)

    def _field_keepers(self) -> str:
        """What to use for interlaced video in this container."""

        def fits(codec: VideoCodec) -> bool:
            return codec.interlaced and self.muxer.format in codec.containers

        if any(map(fits, CODECS.values())):
            return f"use {option('codec')} {codecs_with(fits)}"
        return "choose another container, such as .mkv"

    def _keep_hdr(self, frame: Frame) -> None:
        parameters, lost = hdr_parameters(frame.picture, self.codec)
        lost += lost_side_data(frame.picture, self.codec)
        has_dolby_vision = any(DOLBY_VISION in text for text in lost)  # one line about it is enough
        self.muxer.dropped += lost + [
            text
            for text in lost_descriptions(self.source)
            if not (has_dolby_vision and DOLBY_VISION in text)
        ]
        add_parameters(self.options, self.codec, parameters)


def keep_quiet(options: dict[str, str], codec: VideoCodec) -> None:
    """Stop the encoder's library from printing: only our own lines may reach the terminal."""
    add_parameters(options, codec, codec.quiet)
    for variable, value in codec.quiet_environment:
        os.environ.setdefault(variable, value)


def add_parameters(options: dict[str, str], codec: VideoCodec, parameters: Sequence[str]) -> None:
    """Append name=value parameters for the encoder's library to those in its options."""
    if parameters:
        before = [options[codec.parameters]] if codec.parameters in options else []
        options[codec.parameters] = ":".join([*before, *parameters])


def name_codec(stream: Any, codec: VideoCodec, container_format: str) -> None:
    """Give a new output stream the codec tag that players expect in this container."""
    if codec.tag is not None and container_format in MP4:
        stream.codec_context.codec_tag = codec.tag


def describe_pictures(stream: Any, frame: Frame) -> None:
    """Set size, pixel format, colour tags and rotation of a new output stream."""
    context = stream.codec_context
    context.width, context.height = frame.width_px, frame.height_px
    context.pix_fmt = frame.pix_fmt
    is_full = is_full_range(frame.tags.range, frame.pix_fmt)
    context.colorspace = frame.tags.matrix
    context.color_range = FULL_RANGE if is_full else frame.tags.range
    context.color_trc, context.color_primaries = frame.tags.transfer, frame.tags.primaries
    matrix = matrix_of(frame.picture)
    if matrix is not None:
        stream.set_display_matrix(matrix)
