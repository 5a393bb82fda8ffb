"""Demuxes the input and decodes its video; the packets of other streams go to the output."""

from collections.abc import Generator, Sequence
from fractions import Fraction
from typing import Any, Protocol

import av
from av.video.frame import PictureType
from makeup_video.pipeline.errors import cannot_keep
from makeup_video.pipeline.frames.colour_tags import ColourTags
from makeup_video.pipeline.frames.display_matrix import turn_and_mirror_of
from makeup_video.pipeline.frames.frame import Frame
from makeup_video.pipeline.media.clock_jumps import ClockJumps
from makeup_video.pipeline.media.decode_stats import Account
from makeup_video.pipeline.media.frame_times import FrameTimes, until_next
from makeup_video.pipeline.media.input_file import VideoSource, is_cover, late_streams, packets_of
from makeup_video.pipeline.media.pixel_format import ConvertPixelFormat
from makeup_video.pipeline.media.seek import seek_before, subtitles_on_screen
from makeup_video.pipeline.media.segment_trim import SegmentTrim
from makeup_video.pipeline.media.trim import Trim

_INTERLEAVE_SECONDS = 10  # no file stores sound and pictures of the same time further apart


class StreamCopier(Protocol):
    """Copies the other streams of the input to the output; Muxer is one implementation.

    strict: losses are errors.  add_dropped: takes one line for each stream or property that the
    output cannot hold.
    """

    strict: bool

    def add_dropped(self, lines: Sequence[str]) -> None: ...
    def trim(self, start: Fraction | None, end: Fraction | None, shift: Fraction) -> None: ...
    def copy(self, packet: Any) -> None: ...


class Decoder:
    """Iterates over the frames of `source` from start to end.

    start_seconds, end_seconds: counted from where the file begins; None: the whole video.
    segment: keeps the pictures of one segment instead; packets of other streams are not read.
    threads: of FFmpeg's decoder; 0: FFmpeg's choice.
    muxer: gets every packet of every other stream, in the order of the file, on the same thread.
    packets: those not read yet. A caller that needs no more frames may read these itself, and then
    call `finish`.
    stats: complete after the run.
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
        self._origin = source.start_seconds  # people count from where a player begins
        start = start_seconds + self._origin if start_seconds else None
        end = end_seconds + self._origin if end_seconds is not None else None
        self.trim: Trim[av.VideoFrame] = segment or Trim(
            start, end, source.time_base, source.late_start
        )
        self._streams = [] if segment is None else [source.video]  # empty: all of them
        self._base = source.time_base
        self._last_dts: int | None = None  # of the last video packet that was read
        self._hides = False  # whether an edit list hides some video packets
        self._context = _decoder_context(source, threads)
        self._times = FrameTimes(source)
        self._account = Account(source, self.trim, self._times)
        self.stats = self._account.stats
        self._jumps = ClockJumps(source)
        self._early: set[tuple[int, int]] = set()  # packets that were copied before the seek
        self._ended: set[int] = set()
        self.packets = self._read()

    def frames(self) -> Generator[Frame, None, None]:
        """Raises DecodeError when nothing can be decoded or the picture's size changes, and
        UsageError when the video ends before `start_seconds` or begins after `end_seconds`."""
        if self.trim.start is not None:
            if not self._streams:
                self._copy_shown_subtitles(self.trim.start)
            seek_before(self.source, self._context, self.trim.start)
        base, end = self._base, _track_end(self.source)
        for picture, pts, duration in until_next(self._pictures(), end, self._is_read_to_end):
            kept = self.trim(picture, pts * base, duration * base)
            if self.trim.is_past_end and self._account.beyond_pts is None:
                self._account.beyond_pts = pts
            yield from self._kept(kept)
        yield from self._kept(self.trim.finish())
        self.finish()

    def _copy_shown_subtitles(self, start: Fraction) -> None:
        for packet in subtitles_on_screen(self.source, start):
            self._early.add((packet.stream.index, packet.pts))
            self.muxer.copy(packet)

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
        self._account.close(self._jumps.jumps)
        self.muxer.add_dropped(
            [
                f"{stream}: it begins where the streams of the output are fixed already"
                for stream in late_streams(self.source.container)
            ]
        )

    def close(self) -> None:
        """Stop reading. If a video is not read to its end, `packets` refers to this decoder and
        would keep it in memory until Python's garbage collection."""
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
            self._account.note(packet)
            if index == video and packet.size:
                self.stats.packets += not packet.is_discard
                self._last_dts = packet.dts
                self._hides |= packet.is_discard
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

    def _is_read_to_end(self) -> bool:
        """True when the last packet in an mp4's index was read, so that the header's end holds.

        False for fragmented files. False also for a track that begins late and is cut by an edit
        list, where FFmpeg counts the delay twice.
        """
        video = self.source.video
        if self._hides and (video.start_time or 0) > 0:
            return False
        entries = video.index_entries
        is_whole = bool(video.frames) and len(entries) > 0
        return is_whole and bool(entries[-1].timestamp == self._last_dts)

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
        """The kept pictures as frames, with their times and durations in the clip."""
        base = self._base
        for picture, seconds, duration in kept:
            if not self.stats.frames:
                self._begin()
            self.source.tags.complete(picture)
            is_damaged, mended = picture.is_corrupt, self.convert.mended
            in_file = seconds + (self.trim.shift or 0) - self._origin
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
            turn_and_mirror = turn_and_mirror_of(picture)
            yield Frame(picture, picture.pts, base, ColourTags.of(picture), *turn_and_mirror)

    def _begin(self) -> None:
        """Move all other streams with the first frame, once its time is known."""
        self.muxer.trim(self.trim.start, self.trim.end, self.trim.shift or Fraction(0))
        self._account.begin()

    def _refuse_changes(self) -> None:
        if self.muxer.strict and self.convert.unasked:
            lost = f"the picture as it is: {'; '.join(self.convert.unasked)}"
            raise cannot_keep(self.convert.codec.name, lost, "Choose another codec, or leave")

    @property
    def expected_frames(self) -> int | None:
        """How many frames will come, as far as the container declares it."""
        return self._account.expected_frames


def _track_end(source: VideoSource) -> int | None:
    """Where the video ends according to an mp4's header, in ticks; None in other containers."""
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
