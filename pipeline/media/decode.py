"""Demuxes the input and decodes its video; the packets of other streams go to the output."""

from collections.abc import Generator, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from typing import Any, Protocol

import av
from av.video.frame import PictureType
from makeup_video.pipeline.errors import DecodeError, StrictError, UsageError, option
from makeup_video.pipeline.frames.colour_tags import ColourTags
from makeup_video.pipeline.frames.display_matrix import turn_of
from makeup_video.pipeline.frames.frame import Frame
from makeup_video.pipeline.media.clock_jumps import ClockJumps
from makeup_video.pipeline.media.duration import beyond_end
from makeup_video.pipeline.media.frame_times import FrameTimes, until_next
from makeup_video.pipeline.media.input_file import VideoSource, is_cover, late_streams, packets_of
from makeup_video.pipeline.media.pixel_format import ConvertPixelFormat
from makeup_video.pipeline.media.seek import seek_before, subtitles_on_screen
from makeup_video.pipeline.media.segment_trim import SegmentTrim
from makeup_video.pipeline.media.trim import Trim

_INTERLEAVE_SECONDS = 10  # in no file are sound and pictures of one time further apart
_SHORT_SECONDS = Fraction(1, 2)  # headers are rounded; half a second less is a truncated file


@dataclass(slots=True)
class DecodeStats:
    """Counts of what came out of the input, and of what was wrong with it.

    corrupt_frames: decoded with visible damage.  lost_frames: in the file, but not decodable.
    mended_times: frames without a time, or with one that did not increase.
    moved: a line where all times move, which loses nothing.
    """

    frames: int = 0
    packets: int = 0
    corrupt_frames: int = 0
    lost_frames: int = 0
    decode_errors: int = 0
    mended_times: int = 0
    moved: list[str] = field(default_factory=list)
    truncated: bool = False

    @property
    def is_damaged(self) -> bool:
        return bool(self.decode_errors or self.corrupt_frames or self.lost_frames or self.truncated)


class StreamCopier(Protocol):
    """Takes the rest of the input to the output; see Muxer, which is one.

    strict: losses are errors.  add_dropped: takes a line for each stream or property that the
    output cannot hold.
    """

    strict: bool

    def add_dropped(self, lines: Sequence[str]) -> None: ...
    def trim(self, start: Fraction | None, end: Fraction | None, shift: Fraction) -> None: ...
    def copy(self, packet: Any) -> None: ...


class Decoder:
    """Iterates over the frames of `source` from start to end.

    start_seconds, end_seconds: counted from where the file begins; None: the whole video.
    segment: keeps the pictures of a segment instead; no packet of another stream is read.
    threads: of FFmpeg's decoder; 0: FFmpeg's choice.
    muxer: gets every packet of every other stream, in the order of the file, on the same thread.
    packets: those still unread. Who needs no more frames may go on with these, and then `finish`.
    After the run `stats` is complete, and `media_seconds` is the length of what was decoded.
    """

    def __init__(
        self,
        source: VideoSource,
        convert: ConvertPixelFormat,
        muxer: StreamCopier,
        *,
        start_seconds: Fraction | None = None,
        end_seconds: Fraction | None = None,
        segment: SegmentTrim | None = None,
        threads: int = 0,
    ) -> None:
        self.source, self.convert, self.muxer = source, convert, muxer
        origin = source.start_seconds  # people count from where a player begins
        start = start_seconds + origin if start_seconds else None
        end = end_seconds + origin if end_seconds is not None else None
        self.trim: Trim[av.VideoFrame] = segment or Trim(
            start, end, source.time_base, source.late_start
        )
        self._streams = [] if segment is None else [source.video]  # none: all of them
        self.stats = DecodeStats()
        self._base = source.time_base
        self._last = Fraction(0), 0  # of the last frame: its time in the clip, its length in ticks
        self._context = _decoder_context(source, threads)
        self._times = FrameTimes(source)
        self._beyond_pts: int | None = None  # of the first picture after the trim's end
        self._jumps = ClockJumps(source)
        self._early: set[tuple[int, int]] = set()  # packets that were copied before the seek
        self._ended: set[int] = set()
        self._ends: dict[int, int] = {}  # of the packets read, in ticks of their streams
        self.packets = self._read()

    def frames(self) -> Generator[Frame, None, None]:
        """Raises DecodeError when nothing can be decoded or the picture's size changes, and
        UsageError when the video ends before `start_seconds` or begins after `end_seconds`."""
        if self.trim.start is not None:
            for packet in (
                () if self._streams else subtitles_on_screen(self.source, self.trim.start)
            ):
                self._early.add((packet.stream.index, packet.pts))
                self.muxer.copy(packet)
            seek_before(self.source, self._context, self.trim.start)
        base = self._base
        for picture, pts, duration in until_next(self._pictures(), _track_end(self.source)):
            kept = self.trim(picture, pts * base, duration * base)
            if self.trim.is_past_end and self._beyond_pts is None:
                self._beyond_pts = pts
            yield from self._kept(kept)
        yield from self._kept(self.trim.finish())
        self.finish()

    def _pictures(self) -> Generator[tuple[av.VideoFrame, int], None, None]:
        """The decoded pictures with their times; other packets go to the muxer."""
        index = self.source.video.index
        for packet in self.packets:
            if packet.stream.index == index:
                for picture in self._decode(packet):
                    yield picture, self._times(picture)
                    if self.trim.is_past_end:
                        break  # a decoder with many threads gives many pictures at once
            elif packet.size:
                self.muxer.copy(packet)

    def finish(self) -> None:
        """Complete the counts, once all packets are read. Raises as `frames` does."""
        self._account()
        self.stats.moved += [
            f"all times from {_in_words(at - self.source.start_seconds)} on: "
            f"{_in_words(abs(by))} {'later' if by > 0 else 'earlier'}, since the clock jumps there"
            for at, by in self._jumps.jumps
        ]
        self.muxer.add_dropped(
            [
                f"{stream}: it begins where the streams of the output are fixed already"
                for stream in late_streams(self.source.container)
            ]
        )

    def close(self) -> None:
        """Read no more. A video that is not read to its end would keep this decoder in memory until
        Python looks for garbage, since `packets` refers to it."""
        self.packets.close()

    def _read(self) -> Generator[Any, None, None]:
        """All packets up to the end of the file or of the trim. A read error ends the file."""
        video, packets = self.source.video.index, packets_of(self.source.container, *self._streams)
        needed = {
            stream.index
            for stream in self._streams or self.source.container.streams
            if stream.type in ("audio", "video") and not is_cover(stream)
        }
        while not needed <= self._ended:
            try:
                packet = next(packets, None)
            except av.FFmpegError:
                self.stats.decode_errors += 1
                self.stats.truncated = True
                yield self._flush_packet()  # the pictures that the decoder still holds are good
                return
            if packet is None:
                return
            index = packet.stream.index
            if (index, packet.pts) in self._early:
                continue
            self._jumps(packet)
            if packet.pts is not None and packet.size:
                end = packet.pts + (packet.duration or 0)
                self._ends[index] = max(self._ends.get(index, 0), end)
            if index == video and packet.size:
                self.stats.packets += not packet.is_discard
            elif self._is_past_end(packet):
                self._ended.add(index)
            if self.trim.is_past_end:
                self._ended.add(video)
                if self._is_past_end(packet, _INTERLEAVE_SECONDS):
                    return
            yield packet

    def _is_past_end(self, packet: Any, by_seconds: int = 0) -> bool:
        if self.trim.end is None or packet.dts is None:
            return False
        return bool(packet.dts * packet.time_base >= self.trim.end + by_seconds)

    def _flush_packet(self) -> Any:
        packet = av.Packet()
        packet.stream, packet.time_base = self.source.video, self.source.time_base
        return packet

    def _decode(self, packet: Any) -> list[av.VideoFrame]:
        if self.trim.is_past_end:
            return []
        try:
            pictures: list[av.VideoFrame] = self._context.decode(packet)
        except av.FFmpegError:
            self.stats.decode_errors += packet.pts is None or self.trim.is_counted(
                packet.pts * packet.time_base
            )
            return []
        return pictures

    def _kept(
        self, kept: list[tuple[av.VideoFrame, Fraction, Fraction]]
    ) -> Generator[Frame, None, None]:
        """The frames of pictures that are kept, with their times and durations in the clip."""
        base = self._base
        for picture, seconds, duration in kept:
            if not self.stats.frames:
                self._begin()
            self.source.tags.complete(picture)
            is_damaged, mended = picture.is_corrupt, self.convert.mended
            in_file = seconds + (self.trim.shift or 0) - self.source.start_seconds
            picture = self.convert(picture, float(in_file))
            is_damaged |= self.convert.mended > mended
            if is_damaged and self.trim.is_counted(seconds + (self.trim.shift or 0)):
                self.stats.corrupt_frames += 1
            if not self.stats.frames:
                self.muxer.add_dropped(self.convert.dropped)
                self._refuse_changes()
            self.stats.frames += 1
            # the source's I/P/B choices must not become the encoder's
            picture.pict_type = PictureType.NONE
            picture.pts, picture.time_base = int(seconds / base), base
            picture.duration = int(duration / base)
            self._last = seconds, max(1, picture.duration)
            yield Frame(picture, picture.pts, base, ColourTags.of(picture), turn_of(picture))

    def _begin(self) -> None:
        """The time of the first frame is known: all other streams move with it."""
        trim, shift = self.trim, self.trim.shift or Fraction(0)
        self.muxer.trim(trim.start, trim.end, shift)
        if not shift or trim.start is not None:  # an excerpt begins at 0 in any case
            return
        if shift < 0:
            why = "later, since the video began before 0"
        else:
            why = "earlier, since the file's clock begins that late"
        self.stats.moved.append(f"all times: {_in_words(abs(shift))} {why}")

    def _refuse_changes(self) -> None:
        if self.muxer.strict and self.convert.unasked:
            strict = option("strict")
            raise StrictError(
                f"{strict}: {self.convert.codec.name} cannot keep the picture as it is: "
                f"{'; '.join(self.convert.unasked)}. Choose another codec, or leave {strict} out."
            )

    @property
    def media_seconds(self) -> Fraction:
        """From 0 to the end of the last frame."""
        seconds, ticks = self._last
        return seconds + ticks * self._base

    @property
    def _file_end_seconds(self) -> Fraction:
        """The end of what was read of the file, on its clock."""
        streams = self.source.container.streams
        ends = [end * streams[index].time_base for index, end in self._ends.items()]
        return max(ends, default=Fraction(0))

    @property
    def expected_frames(self) -> int | None:
        """How many frames will come, as far as the container declares it."""
        expected, trim, rate = self.source.expected_frames, self.trim, self.source.rate
        if expected is None or (trim.start is None and trim.end is None):
            return expected
        origin = self.source.start_seconds
        end = min(expected / rate, trim.end - origin) if trim.end is not None else expected / rate
        start = origin if trim.start is None else trim.start
        return max(0, round((end - (start - origin)) * rate))

    def _account(self) -> None:
        """Count what the container promised and the file did not hold."""
        stats, source = self.stats, self.source
        stats.mended_times = self._times.mended
        is_whole = self.trim.start is None and self.trim.end is None
        if is_whole:
            if "mp4" in source.container.format.name:
                # frames that an edit list hides are not lost
                promised = sum(not entry.is_discard for entry in source.video.index_entries)
            else:
                promised = stats.packets
            stats.truncated |= promised > stats.packets or self._ends_early()
            if stats.is_damaged:
                stats.lost_frames = max(0, promised - stats.frames)
        if not stats.frames:
            self._check_excerpt()
            where = "in it" if is_whole else "in the chosen excerpt"
            raise DecodeError(
                f"{source.path}: no frame could be decoded {where} (packets: {stats.packets}, "
                f"errors: {stats.decode_errors}). Give a file that plays.",
                shows_nothing=True,
            )

    def _ends_early(self) -> bool:
        """Matroska has no count of frames, but its header declares the length of the file."""
        container = self.source.container
        if "matroska" not in container.format.name or container.duration is None:
            return False
        return Fraction(container.duration, av.time_base) - self._file_end_seconds > _SHORT_SECONDS

    def _check_excerpt(self) -> None:
        """Raises UsageError when all pictures lie before the trim's start, or after its end.

        The length of some files is known only once they have been read.
        """
        start, source, times = self.trim.start, self.source, self._times
        if times.last_pts is None or self.stats.decode_errors:
            return
        if self._beyond_pts is not None and self.trim.end is not None:
            first = self._beyond_pts * source.time_base - source.start_seconds
            raise UsageError(
                f"{option('end_seconds')} {float(self.trim.end - source.start_seconds):g} s is "
                f"before the first frame: {source.path} has frames from {float(first):.2f} s on; "
                "choose a later time"
            )
        if start is None:
            return
        end = (times.last_pts + times.last_duration) * source.time_base
        origin = source.start_seconds
        if max(end, self._file_end_seconds) <= start:
            raise beyond_end(source, start - origin, max(end, self._file_end_seconds) - origin)
        raise UsageError(
            f"{option('start_seconds')} {float(start - origin):g} s is beyond the last frame: "
            f"{source.path} has frames until {round(float(end - origin), 2)} s"
        )


def _track_end(source: VideoSource) -> int | None:
    """Where the video ends by the index of an mp4, in ticks; None in other containers."""
    video = source.video
    if "mp4" not in source.container.format.name or not video.duration:
        return None
    return int((video.start_time or 0) + video.duration)


def _decoder_context(source: VideoSource, threads: int) -> Any:
    video = source.video
    if source.has_alpha and video.name in ("vp8", "vp9"):
        # FFmpeg's own VP8/VP9 decoders drop the transparency; libvpx's keep it
        context = av.CodecContext.create("libvpx-vp9" if video.name == "vp9" else "libvpx", "r")
        context.extradata = video.codec_context.extradata
    else:
        context = video.codec_context
    context.thread_type = "AUTO"
    context.thread_count = threads
    return context


def _in_words(seconds: Fraction) -> str:
    """A time in seconds, such as "3.03 s"."""
    return f"{round(float(seconds), 2):.12g} s"
