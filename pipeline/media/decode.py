"""Path -> Frame ...: demuxes the input, decodes its video, hands every other packet on."""

from collections.abc import Generator
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import av
from makeup_video.pipeline.errors import DecodeError, StrictError, UsageError
from makeup_video.pipeline.frames.colour_tags import ColourTags
from makeup_video.pipeline.frames.frame import Frame
from makeup_video.pipeline.media.duration import beyond_end
from makeup_video.pipeline.media.input_file import VideoSource, is_cover, late_tracks, packets_of
from makeup_video.pipeline.media.mux import Muxer
from makeup_video.pipeline.media.pixel_format import ConvertPixelFormat
from makeup_video.pipeline.media.trim import Trim

_SEEK_BACK_SECONDS = (0, 2, 10, 60, 10**9)  # the last one is the beginning of the file
_INTERLEAVE_SECONDS = 10  # no file stores sound further from its pictures than this
_LONGEST_SECONDS = 2**52  # no clock counts so far; in milliseconds it still fits into 64 bits
_SHORT_SECONDS = Fraction(1, 2)  # headers round; half a second missing is a file cut short


@dataclass(slots=True)
class DecodeStats:
    """What came out of the input, and what was wrong with it.

    corrupt_frames: decoded with visible damage.  lost_frames: in the file, but not decodable.
    mended_times: frames whose time was missing or did not increase.
    """

    frames: int = 0
    packets: int = 0
    corrupt_frames: int = 0
    lost_frames: int = 0
    decode_errors: int = 0
    mended_times: int = 0
    truncated: bool = False

    @property
    def is_damaged(self) -> bool:
        return bool(self.decode_errors or self.corrupt_frames or self.lost_frames or self.truncated)


class Decoder:
    """Iterates over the frames of `source` between start and end (seconds from where the file
    begins, None: all of it).

    The muxer gets every packet of every other stream, in file order, from the same thread. After
    the run `stats` is complete and `media_seconds` is the length of what was decoded.
    """

    def __init__(
        self,
        source: VideoSource,
        door: ConvertPixelFormat,
        muxer: Muxer,
        *,
        start_seconds: Fraction | None = None,
        end_seconds: Fraction | None = None,
        threads: int = 0,
    ) -> None:
        self.source, self.door, self.muxer = source, door, muxer
        origin = source.start_seconds  # people count from where a player begins
        start = start_seconds + origin if start_seconds else None
        end = end_seconds + origin if end_seconds is not None else None
        self.trim: Trim[av.VideoFrame] = Trim(start, end, source.time_base)
        self.stats = DecodeStats()
        self.media_seconds = Fraction(0)  # from 0 to the end of the last frame
        self._context = _decoder_context(source, threads)
        self._last_pts: int | None = None
        self._last_duration = 1
        # AVI stores no presentation times; FFmpeg makes some up, in the wrong order for these
        self._guesses_wrong = (
            source.container.format.name == "avi"
            and source.video.name in ("h264", "hevc")
            and bool(source.video.codec_context.has_b_frames)
        )
        self._dts_delay: int | None = None
        self._ended: set[int] = set()
        self._file_end_seconds = Fraction(0)

    def frames(self) -> Generator[Frame, None, None]:
        """Raises DecodeError when nothing could be decoded or the picture's size changes, and
        UsageError when the film ends before `start_seconds`."""
        if self.trim.start is not None:
            self._seek(self.trim.start)
        for packet in self._packets():
            if packet.stream.index == self.source.video.index:
                for picture in self._decode(packet):
                    seconds = self._mended_pts(picture) * self.source.time_base
                    duration = picture.duration * self.source.time_base
                    yield from self._kept(self.trim(picture, seconds, duration))
            elif packet.size:
                self.muxer.copy(packet)
        yield from self._kept(self.trim.finish())
        self._account()
        self.muxer.dropped += [
            f"{track}: it begins where the tracks of the output are fixed already"
            for track in late_tracks(self.source.container)
        ]

    def _seek(self, start: Fraction) -> None:
        """Go to where decoding gives every frame from `start` on.

        Containers may land behind the wanted keyframe (mpegts has no index; an open group of
        pictures has frames that need the one before): try, look at the first frame, go further back.
        """
        video, container = self.source.video, self.source.container
        if container.duration is None:
            return  # a bare stream has no times to seek by: decode it from its beginning
        for back in _SEEK_BACK_SECONDS:
            try:
                ticks = int(max(Fraction(0), start - back) / self.source.time_base)
                container.seek(ticks, stream=video)
                self._context.flush_buffers()
                if back == _SEEK_BACK_SECONDS[-1] or self._first_decodable() <= start:
                    container.seek(ticks, stream=video)
                    self._context.flush_buffers()
                    return
            except av.FFmpegError:
                return  # no seeking in this file: decode from where it stands

    def _first_decodable(self) -> Fraction:
        """Seconds of the first frame that comes out from here."""
        for packet in packets_of(self.source.container, self.source.video):
            try:
                pictures = self._context.decode(packet)
            except av.FFmpegError:
                continue  # counted when it is decoded for good
            for picture in pictures:
                if picture.pts is not None and not picture.is_corrupt:
                    return Fraction(picture.pts * self.source.time_base)
        return Fraction(2**62)

    def _packets(self) -> Generator[Any, None, None]:
        """All packets until the end, of the file or of the trim. A read error ends the file."""
        video, packets = self.source.video.index, packets_of(self.source.container)
        needed = {
            stream.index
            for stream in self.source.container.streams
            if stream.type in ("audio", "video") and not is_cover(stream)
        }
        while not needed <= self._ended:
            try:
                packet = next(packets, None)
            except av.FFmpegError:
                self.stats.decode_errors += 1
                self.stats.truncated = True
                yield self._flush_packet()  # what the decoder still holds can be shown
                return
            if packet is None:
                return
            if packet.pts is not None and packet.size:
                end = (packet.pts + (packet.duration or 0)) * packet.time_base
                self._file_end_seconds = max(self._file_end_seconds, end)
            if packet.stream.index == video and packet.size:
                self.stats.packets += not packet.is_discard
            elif self._is_past_end(packet):
                self._ended.add(packet.stream.index)
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
            self.stats.decode_errors += 1
            return []
        return pictures

    def _kept(self, kept: list[tuple[av.VideoFrame, Fraction]]) -> Generator[Frame, None, None]:
        """The frames of pictures that are kept, with their times in the clip."""
        base = self.source.time_base
        for picture, seconds in kept:
            if not self.stats.frames:
                self._begin()
            self.source.tags.complete(picture)
            is_damaged, mended = picture.is_corrupt, self.door.mended
            picture = self.door(picture)
            self.stats.corrupt_frames += is_damaged or self.door.mended > mended
            if not self.stats.frames:
                self.muxer.dropped += self.door.dropped
                self._refuse_changes()
            self.stats.frames += 1
            # The source's I/P/B choices must not become the encoder's.
            picture.pict_type = 0
            picture.pts, picture.time_base = int(seconds / base), base
            self.media_seconds = seconds + max(1, picture.duration) * base
            turned = round(picture.rotation / 90) * 90 % 360
            yield Frame(picture, picture.pts, base, ColourTags.of(picture), turned)

    def _refuse_changes(self) -> None:
        if self.muxer.strict and self.door.unasked:
            raise StrictError(
                f"--strict: {self.door.codec.name} cannot keep the picture as it is: "
                f"{'; '.join(self.door.unasked)}. Choose another codec, or leave --strict out."
            )

    def _begin(self) -> None:
        """The first frame is known: everything else moves with it."""
        trim, shift = self.trim, self.trim.shift or Fraction(0)
        self.muxer.trim(trim.start, trim.end, shift)
        if shift < 0:
            self.muxer.converted.append(
                f"all times: {float(-shift):g} s later, since the video began before 0"
            )

    @property
    def expected_frames(self) -> int | None:
        """How many frames will come, as far as the container says."""
        expected, trim, rate = self.source.expected_frames, self.trim, self.source.rate
        if expected is None or (trim.start is None and trim.end is None):
            return expected
        origin = self.source.start_seconds
        end = min(expected / rate, trim.end - origin) if trim.end is not None else expected / rate
        return max(0, round((end - (trim.start - origin if trim.start else 0)) * rate))

    def _mended_pts(self, picture: av.VideoFrame) -> int:
        """A frame's time in ticks, strictly increasing whatever the container says."""
        pts = picture.pts
        if self._guesses_wrong:
            pts = self._pts_from_dts(picture)
        if pts is not None and abs(pts * self.source.time_base) > _LONGEST_SECONDS:
            pts = None
        if picture.duration * self.source.time_base > _LONGEST_SECONDS:
            picture.duration = 0
        last = self._last_pts
        if pts is None or (last is not None and pts <= last):
            self.stats.mended_times += 1
            pts = 0 if last is None else last + self._last_duration
        self._last_pts = pts
        self._last_duration = max(1, picture.duration or self._last_duration)
        return int(pts)

    def _pts_from_dts(self, picture: av.VideoFrame) -> int | None:
        """The times of AVI's decoding order, moved so that the first frame keeps its own."""
        if picture.dts is None:
            return None if self._last_pts is None else self._last_pts + self._last_duration
        if self._dts_delay is None:
            self._dts_delay = picture.dts - (picture.pts or 0)
        return int(picture.dts - self._dts_delay)

    def _ends_early(self) -> bool:
        """Matroska counts no frames, but its header says how long the file is."""
        container = self.source.container
        if "matroska" not in container.format.name or container.duration is None:
            return False
        return Fraction(container.duration, av.time_base) - self._file_end_seconds > _SHORT_SECONDS

    def _account(self) -> None:
        """Count what the container promised and the file did not hold."""
        stats, source = self.stats, self.source
        is_whole = self.trim.start is None and self.trim.end is None
        if is_whole:
            if "mp4" in source.container.format.name:
                # what an edit list hides is no loss
                promised = sum(not entry.is_discard for entry in source.video.index_entries)
            else:
                promised = stats.packets
            stats.truncated |= promised > stats.packets or self._ends_early()
            if stats.is_damaged:
                stats.lost_frames = max(0, promised - stats.frames)
        if not stats.frames:
            self._check_start()
            where = "in it" if is_whole else "in the chosen part"
            raise DecodeError(
                f"{source.path}: no frame could be decoded {where} "
                f"({stats.packets} packets, {stats.decode_errors} errors). Give a file that plays."
            )

    def _check_start(self) -> None:
        """Raises UsageError when all pictures lie before the trim's start.

        Some files do not tell their length before they have been read.
        """
        start, source = self.trim.start, self.source
        if start is None or self._last_pts is None or self.stats.decode_errors:
            return
        end = (self._last_pts + self._last_duration) * source.time_base
        origin = source.start_seconds
        if max(end, self._file_end_seconds) <= start:
            raise beyond_end(source, start - origin, max(end, self._file_end_seconds) - origin)
        raise UsageError(
            f"--start {float(start - origin):g} s is beyond the last picture: {source.path} shows "
            f"pictures until {round(float(end - origin), 2)} s"
        )


def _decoder_context(source: VideoSource, threads: int) -> Any:
    video = source.video
    if source.has_alpha and video.name in ("vp8", "vp9"):
        # FFmpeg's own VP8/VP9 decoders drop the transparency; libvpx's keep it.
        context = av.CodecContext.create("libvpx-vp9" if video.name == "vp9" else "libvpx", "r")
        context.extradata = video.codec_context.extradata
    else:
        context = video.codec_context
    context.thread_type = "AUTO"
    context.thread_count = threads
    return context
