"""Writes the output file: the new video, and everything else of the source as it was."""

import contextlib
import errno
import threading
from collections.abc import Callable
from fractions import Fraction
from typing import Any, TypeVar

import av
from makeup_video.pipeline.errors import OutputError, StrictError
from makeup_video.pipeline.files.output_file import OutputFile, write_errors
from makeup_video.pipeline.media.codecs import MATROSKA
from makeup_video.pipeline.media.input_file import VideoSource, is_cover
from makeup_video.pipeline.media.matroska import set_display_size
from makeup_video.pipeline.media.streams import (
    codec_name,
    copy_stream,
    is_implied,
    is_odd,
    mystery,
    refusal,
    shown_wh,
    tags,
)
from makeup_video.pipeline.media.transcode import (
    AudioConverter,
    SubtitleConverter,
    audio_codec_for,
    subtitle_codec_for,
)
from makeup_video.pipeline.media.verify import SentStream, missing_from, sent_stream

Convert = Callable[[Any], list[Any]]
T = TypeVar("T")
# What FFmpeg says of a packet's content in the system's words; its own error numbers lie far above.
_OF_CONTENT = {errno.EINVAL, errno.ERANGE, errno.EDOM, errno.ENOSYS}
_LAST_OF_THE_SYSTEM = 4096


class Muxer:
    """One output file. `copy` and `write` may be called from different threads.

    The file grows as NAME.part.EXT beside the target and gets its name when it is whole.
    dropped: what the container cannot hold, by name.  converted: what had to change codec.
    skipped_packets: damaged ones of other tracks, which no muxer or decoder takes.
    """

    def __init__(self, target: OutputFile, container_format: str, *, strict: bool = False) -> None:
        self.target, self.part = target, target.part
        self.format, self.strict = container_format, strict
        self.dropped: list[str] = []
        self.converted: list[str] = []
        self.bytes_out = 0
        self.video_packets = 0
        self.is_finished = False
        self.skipped_packets = 0
        self._shift = Fraction(0)
        self._clip: tuple[Fraction | None, Fraction | None] = (None, None)
        self._container: Any = None
        self._video: Any = None
        self._video_number = 0
        self._sent: dict[int, SentStream] = {}
        self._covers: set[int] = set()
        self._shown_wh: tuple[int, int] | None = None
        self._streams: dict[int, tuple[Any, Convert | None]] = {}
        self._converters: list[AudioConverter] = []
        self._waiting: list[Any] | None = []
        self._lock = threading.Lock()

    # -- opening -------------------------------------------------------------------------------

    def open(self, source: VideoSource, add_video: Callable[[Any], Any]) -> Any:
        """Create the file with every stream of the source, in the source's order.

        add_video(container) adds and returns the stream of the new video.  Returns it.
        """
        with self._lock, write_errors(self.part):
            self._container = av.open(
                f"file:{self.target.own_path}",
                "w",
                format=self.format,
                container_options=self._options(source),
            )
            for stream in source.container.streams:
                if stream.index == source.video.index:
                    self._video = video = add_video(self._container)
                    self._sent[video.index] = sent_stream("the painted video", video, exact=True)
                    video.metadata.update(tags(source.video, self.format))
                    video.disposition = source.video.disposition
                    self._shown_wh = shown_wh(video, source)
                    tracks = [s for s in self._container.streams if s.type != "attachment"]
                    self._video_number = len(tracks)  # as Matroska counts, from 1
                else:
                    self._add(stream, source)
            self._container.metadata.update(tags(source.container, self.format))
            self._container.set_chapters(self._chapters(source.container.chapters()))
            self._refuse_loss()
        return video

    def trim(self, start: Fraction | None, end: Fraction | None, shift: Fraction) -> None:
        """Keep what lies in start..end (source seconds), and take `shift` off its times."""
        self._clip, self._shift = (start, end), shift

    @property
    def _moves(self) -> bool:
        """True when times change or parts fall away, so that every track must be looked at."""
        return bool(self._shift) or self._clip != (None, None)

    def start(self) -> None:
        """Write the header, then the packets that came before it."""
        with self._lock, write_errors(self.part):
            self._container.start_encoding()
            waiting, self._waiting = self._waiting or [], None
            for packet in waiting:
                self._copy(packet)

    def _options(self, source: VideoSource) -> dict[str, str]:
        if self.format in MATROSKA:
            # Matroska would move everything later to get rid of an AAC packet that begins before
            # 0; its blocks can say negative times.
            return {"avoid_negative_ts": "disabled"}
        ticks = str(source.time_base.denominator)
        flags = "+faststart"
        if odd := sorted(key for key in tags(source.container, self.format) if is_odd(key)):
            if self.format == "mp4" and any(map(is_cover, source.container.streams)):
                self.dropped.append(f"tags {', '.join(odd)}: mp4 holds them or cover art, not both")
            else:
                flags += "+use_metadata_tags"
        # Track and edit-list ticks both as fine as the source's, so that every time is exact.
        return {"movflags": flags, "video_track_timescale": ticks, "movie_timescale": ticks}

    def _add(self, stream: Any, source: VideoSource) -> None:
        name = f"{stream.type} #{stream.index} ({codec_name(stream)})"
        if is_implied(stream, source):
            return
        if is_cover(stream) and self.format == "matroska":
            self._attach_cover(stream, name)
            return
        if (unknown := mystery(stream)) is not None:
            self.dropped.append(f"{name}: {unknown}")
            return
        reason = refusal(stream, self.format, self._first_packet(stream))
        if reason is None:
            out = copy_stream(self._container, stream)
            self._streams[stream.index] = (out, None)
        else:
            converted = self._add_converted(stream, name)
            if converted is None:
                self.dropped.append(f"{name}: {reason}")
                return
            out = converted
        out.metadata.update(tags(stream, self.format))
        out.disposition = stream.disposition
        if stream.type != "attachment" and not is_cover(stream):
            self._sent[out.index] = sent_stream(name, out)

    def _add_converted(self, stream: Any, name: str) -> Any | None:
        if stream.codec_context is None or is_cover(stream):
            return None
        codec: str | None
        if stream.type == "audio":
            codec = audio_codec_for(self.format)
            audio = AudioConverter(self._container, stream, codec)
            self._converters.append(audio)
            self._streams[stream.index] = (audio.stream, audio)
        elif stream.type == "subtitle" and (codec := subtitle_codec_for(self.format, stream)):
            text = SubtitleConverter(self._container, stream, codec)
            self._streams[stream.index] = (text.stream, text)
        else:
            return None
        self.converted.append(f"{name} -> {codec}")
        return self._streams[stream.index][0]

    def _attach_cover(self, stream: Any, name: str) -> None:
        """Matroska keeps covers as attachments, which are part of the header."""
        packet = self._first_packet(stream)
        if packet is None:
            self.dropped.append(f"{name}: its picture is not at the start of the file")
            return
        codec = codec_name(stream)
        mime = {"mjpeg": "image/jpeg", "png": "image/png"}.get(codec, "image/x-unknown")
        extension = {"mjpeg": "jpg"}.get(codec, codec)
        named = {key.lower(): value for key, value in stream.metadata.items()}
        self._container.add_attachment(
            named.get("filename", f"cover.{extension}"), named.get("mimetype", mime), bytes(packet)
        )

    def _first_packet(self, stream: Any) -> Any | None:
        waiting = self._waiting or []
        return next((p for p in waiting if p.stream.index == stream.index), None)

    def _chapters(self, chapters: list[Any]) -> list[Any]:
        """The chapters inside the trim, moved with it."""
        start, end = self._clip
        if not self._moves:
            return chapters
        kept = []
        for chapter in chapters:
            base = chapter["time_base"]
            first = max(chapter["start"] * base, start or Fraction(0))
            last = chapter["end"] * base
            last = last if end is None else min(last, end)
            if last > first:
                moved = {
                    "start": int((first - self._shift) / base),
                    "end": int((last - self._shift) / base),
                }
                kept.append({**chapter, **moved, "start": max(0, moved["start"])})
        return kept

    def _refuse_loss(self) -> None:
        if self.strict and (self.dropped or self.converted):
            lost = "; ".join([*self.dropped, *(f"{text} (converted)" for text in self.converted)])
            raise StrictError(
                f"--strict: {self.part.suffix} cannot keep {lost}. Use .mkv, or leave --strict out."
            )

    # -- packets -------------------------------------------------------------------------------

    def copy(self, packet: Any) -> None:
        """Take a packet of the source that is not the painted video's."""
        with self._lock, write_errors(self.part):
            if self._waiting is not None:
                self._waiting.append(packet)
            else:
                self._copy(packet)

    def _copy(self, packet: Any) -> None:
        entry = self._streams.get(packet.stream.index)
        if entry is None or not self._trim(packet):
            return
        stream, convert = entry
        if packet.stream.name == "mov_text" and packet.size <= 2:
            return  # an empty title that fills a gap; the muxer makes its own
        packets = [packet]
        if convert is not None:
            packets = self._unless_damaged(convert, packet)
        self._mux_others(stream, packets)

    def _mux_others(self, stream: Any, packets: list[Any]) -> None:
        """Mux packets of a track that is not the video; those that the muxer refuses are counted."""
        for packet in packets:
            self._unless_damaged(self._mux, stream, packet)

    def _unless_damaged(self, work: Callable[..., T], *arguments: Any) -> T | list[Any]:
        """What `work` returns. A packet that it refuses is counted, and the film goes on without."""
        try:
            return work(*arguments)
        except av.FFmpegError as error:
            if _is_of_the_system(error):
                raise
            self.skipped_packets += 1
            return []

    def _mux(self, stream: Any, packet: Any) -> None:
        # Encoders of PyAV leave a packet's stream unset, which would mean the first track.
        packet.stream = stream
        self._container.mux_one(packet)
        if is_cover(stream):
            self._covers.add(stream.index)
        elif stream.index in self._sent and packet.size:  # FLAC ends with one that only says so
            self._sent[stream.index].packets += 1

    def _trim(self, packet: Any) -> bool:
        """Move the packet by the trim's shift; False when it lies outside."""
        start, end = self._clip
        if not self._moves:
            return True
        at = packet.pts if packet.pts is not None else packet.dts
        if at is None:
            return True
        seconds = at * packet.time_base
        stop = seconds + (packet.duration or 0) * packet.time_base
        is_text = packet.stream.type == "subtitle"
        if end is not None and seconds >= end:
            return False
        if start is not None and (stop <= self._shift if is_text else seconds < self._shift):
            return is_cover(packet.stream)
        ticks = round(self._shift / packet.time_base)
        late = max(0, ticks - at) if is_text else 0
        if is_text and end is not None:
            packet.duration = min(packet.duration, round((end - seconds) / packet.time_base))
        if packet.pts is not None:
            packet.pts += late - ticks
        if packet.dts is not None:
            packet.dts += late - ticks
        if late:
            packet.duration -= late
        return True

    def write(self, packet: Any) -> None:
        """Mux a packet of the new video."""
        with self._lock, write_errors(self.part):
            self._mux(self._video, packet)
            self.video_packets += 1

    # -- ending --------------------------------------------------------------------------------

    def finish(self, keep_part: bool = False) -> None:
        """Write the trailer; then give the file its name, unless the part is all there is."""
        with self._lock, write_errors(self.part):
            for converter in self._converters:
                self._mux_others(converter.stream, self._unless_damaged(converter.flush))
            self._container.close()
            if not self._keep_pixel_aspect():
                self.dropped.append("pixel aspect ratio: no room for it in the header")
            self.bytes_out = self.target.own_path.stat().st_size
            if keep_part:
                self.target.leave()
            else:
                self._refuse_loss()  # some tracks show only while the file is read
                self._check_written()
                self.target.keep()
            self.is_finished = True

    def _check_written(self) -> None:
        """The last belt: a file that lost something does not get the output's name."""
        sent = list(self._sent.values())
        missing = missing_from(self.target.own_path, self.format, sent, len(self._covers))
        if missing is not None:
            self.target.leave()
            self.is_finished = True
            raise OutputError(
                f"{self.target.path} did not come out whole: {missing}; what was written is kept as "
                f"{self.part}. Try another container, such as .mkv, and report it"
            )

    def _keep_pixel_aspect(self) -> bool:
        """mp4 and mov have it from the encoder; Matroska's muxer has to be helped."""
        if self._shown_wh is None or self.format not in MATROSKA:
            return True
        return set_display_size(self.target.own_path, self._video_number, *self._shown_wh)

    def abort(self) -> None:
        """Close and remove what was written. Never raises: it runs after another error."""
        with self._lock:
            if self._container is not None:
                with contextlib.suppress(Exception):
                    self._container.close()
            self.target.discard()


def _is_of_the_system(error: av.FFmpegError) -> bool:
    """True for errors of disk and memory, False for what a damaged packet causes."""
    number = error.errno or 0
    return 0 < number < _LAST_OF_THE_SYSTEM and number not in _OF_CONTENT
