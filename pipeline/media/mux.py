"""Writes the output file: the painted video, and every other stream of the source as it was."""

import contextlib
import errno
import threading
from collections.abc import Callable, Iterable, Sequence
from fractions import Fraction
from typing import Any, TypeVar

import av
from av.stream import Disposition
from makeup_video.pipeline.errors import OutputError, cannot_keep, is_of_the_system
from makeup_video.pipeline.files.output_file import OutputFile, write_errors
from makeup_video.pipeline.media.clip import Clip
from makeup_video.pipeline.media.codecs import MATROSKA, MP4
from makeup_video.pipeline.media.input_file import VideoSource, is_cover
from makeup_video.pipeline.media.matroska import set_display_size
from makeup_video.pipeline.media.mp4_length import TrackLength
from makeup_video.pipeline.media.mp4_tracks import hide_subtitles
from makeup_video.pipeline.media.other_streams import OtherStreams
from makeup_video.pipeline.media.streams import container_options, label_of, shown_wh, tags
from makeup_video.pipeline.media.timecode import moved_timecode
from makeup_video.pipeline.media.transcode import AudioConverter
from makeup_video.pipeline.media.verify import SentStream, missing_from, sent_stream

T = TypeVar("T")
# System error numbers with which FFmpeg reports bad content of a packet.
_OF_CONTENT = {errno.EINVAL, errno.ERANGE, errno.EDOM, errno.ENOSYS}


class Muxer:
    """One output file. `copy` and `write` may be called from different threads.

    The file grows as NAME.part.EXT beside the target and gets its name once it is whole.
    dropped: one line for each loss.  converted: one line for each stream that changes its codec.
    hardly_played: streams that few players can play in this container.
    skipped_packets: damaged packets of other streams that no muxer or decoder takes.
    video_packets: packets of the painted video so far.  bytes_out: the file's size, once whole.
    is_finished: the file is closed, and has its final name or stays under the name of the part.
    """

    def __init__(self, target: OutputFile, container_format: str, *, strict: bool = False) -> None:
        self.target, self.part = target, target.part
        self.format, self.strict = container_format, strict
        self.dropped: list[str] = []
        self._dropped_by_container: list[str] = []  # Matroska may hold these
        self.converted: list[str] = []
        self.hardly_played: list[str] = []
        self.bytes_out = 0
        self.video_packets = 0
        self.is_finished = False
        self.skipped_packets = 0
        self._clip = Clip()
        self._container: Any = None
        self._video: Any = None
        self._video_number = 0
        self._length = TrackLength() if container_format in MP4 else None
        self._shown_wh: tuple[int, int] | Fraction | None = None
        self._others: OtherStreams
        self._sent: dict[int, SentStream] = {}
        self._covers: set[int] = set()
        self._last_dts: dict[int, int] = {}  # of the packets copied, by stream of the source
        self._begun: set[int] = set()  # other video tracks that had a key frame
        self._over: set[int] = set()  # other video tracks that have reached the excerpt's end
        self._cut_off: set[str] = set()  # lines about what such tracks lose to the excerpt
        # packets that came before the header, and whether each is hidden; None after the header
        self._waiting: list[tuple[Any, bool]] | None = []
        self._lock = threading.Lock()

    def add_dropped(self, lines: Sequence[str]) -> None:
        """Note losses. A strict run refuses them when the output is opened or finished."""
        self.dropped += lines

    # -- opening -------------------------------------------------------------------------------

    def trim(self, start: Fraction | None, end: Fraction | None, shift: Fraction) -> None:
        """Keep the part from start to end (seconds in the source), `shift` seconds earlier."""
        self._clip = Clip(start, end, shift)

    def open(self, source: VideoSource, add_video: Callable[[Any], Any]) -> Any:
        """Create the file with every stream of the source, in the source's order.

        add_video(container) adds and returns the stream of the painted video.  Returns that stream.
        Raises StrictError when the run is strict and something would be lost.
        """
        with self._lock, write_errors(self.part):
            options, dropped = container_options(source, self.format)
            self._dropped_by_container += dropped
            self._container = av.open(
                f"file:{self.target.own_path}", "w", format=self.format, container_options=options
            )
            self._add_streams(source, add_video)
            self._container.metadata.update(self._tags(source.container, source))
            self._container.set_chapters(self._clip.chapters(source.container.chapters()))
            self._refuse_loss()
        return self._video

    def _add_streams(self, source: VideoSource, add_video: Callable[[Any], Any]) -> None:
        first = [packet for packet, _ in self._waiting or []]
        self._others = OtherStreams(self._container, self.format, source, first)
        for stream in source.container.streams:
            if stream.index == source.video.index:
                self._add_video(add_video(self._container), source)
                continue
            added = self._others.add(stream)
            if added is not None and added.type != "attachment" and not is_cover(stream):
                self._sent[added.index] = sent_stream(label_of(stream), added)
        self._dropped_by_container += self._others.dropped
        self.dropped += self._dropped_by_container
        self.converted += self._others.converted
        self.hardly_played += self._others.hardly_played

    def _add_video(self, video: Any, source: VideoSource) -> None:
        self._video = video
        self._sent[video.index] = sent_stream("the painted video", video, exact=True)
        video.metadata.update(self._tags(source.video, source))
        video.disposition = source.video.disposition
        self._shown_wh = shown_wh(video, source)
        # Matroska counts its tracks from 1, and attachments are not tracks
        self._video_number = sum(s.type != "attachment" for s in self._container.streams)

    def _tags(self, holder: Any, source: VideoSource) -> dict[str, str]:
        """The tags of the file or video; the timecode of an excerpt is that of its first frame."""
        kept = tags(holder, self.format)
        if self._clip.start is not None:
            begin = self._clip.shift - (source.video.start_time or 0) * source.time_base
            for key in kept:
                if key.lower() == "timecode":
                    kept[key] = moved_timecode(kept[key], begin, source.rate)
        return kept

    def start(self) -> None:
        """Write the header, then the packets that came before it."""
        with self._lock, write_errors(self.part):
            self._container.start_encoding()
            waiting, self._waiting = self._waiting or [], None
            for packet, is_hidden in waiting:
                self._copy(packet, is_hidden)

    def drop(self, what: str) -> None:
        """Note what is lost from now on. Raises StrictError."""
        self.dropped.append(what)
        if self.strict:
            raise cannot_keep("the output", what, "Cut the video there, or leave")

    def _refuse_loss(self) -> None:
        if self.strict and (self.dropped or self.converted):
            lost = "; ".join([*self.dropped, *(f"{text} (converted)" for text in self.converted)])
            by_container = set(self.dropped) <= set(self._dropped_by_container)
            may_help = by_container and self.part.suffix.lower() != ".mkv"
            advice = "Use .mkv, or leave" if may_help else "Leave"
            raise cannot_keep(self.part.suffix, lost, advice)

    # -- packets -------------------------------------------------------------------------------

    def write(self, packet: Any) -> None:
        """Mux a packet of the painted video."""
        with self._lock, write_errors(self.part):
            for ready in [packet] if self._length is None else self._length(packet):
                self._mux(self._video, ready)
            self.video_packets += 1

    def copy(self, packet: Any, *, is_hidden: bool | None = None) -> None:
        """Mux a packet of another stream of the source, once the output is open.

        is_hidden: the source does not show or play it; None: as the packet itself says.
        """
        hidden = packet.is_discard if is_hidden is None else is_hidden
        with self._lock, write_errors(self.part):
            if self._waiting is not None:
                self._waiting.append((packet, hidden))
            else:
                self._copy(packet, hidden)

    def _copy(self, packet: Any, is_hidden: bool) -> None:
        index = packet.stream.index
        if packet.size and index in self._others.lost_late:
            self.drop(self._others.lost_late.pop(index))
        route = self._others.route(index)
        if route is None or not self._is_in_clip(packet) or self._is_undecodable(packet):
            return
        stream, convert = route
        if packet.stream.name == "mov_text" and packet.size <= 2:
            return  # an empty subtitle that fills a gap; the muxer makes its own
        packets: Iterable[Any] = [packet]
        if not isinstance(convert, AudioConverter) and self._goes_back(packet) and is_hidden:
            return  # between two edits: only a converter's decoder needs it, and no muxer takes it
        if convert is not None:
            packets = self._unless_damaged(convert, packet)
        elif self.format in MATROSKA and is_hidden and _is_before_0(packet):
            return
        self._mux_others(stream, packets)

    def _is_in_clip(self, packet: Any) -> bool:
        """Move a packet into the excerpt's time; False when it lies outside."""
        stream, is_after = packet.stream, self._clip.is_after(packet)
        if stream.type == "video" and is_after:
            self._over.add(stream.index)
        elif stream.index in self._over and packet.size:
            # earlier pictures that come later are decoded with the help of those left out
            self._cut_off.add(f"{label_of(stream)}: its last pictures, which need later ones")
            return False
        return self._clip.take(packet)

    def _goes_back(self, packet: Any) -> bool:
        """True for a packet that comes no later than the one before it in its stream."""
        if packet.dts is None:
            return False
        index = packet.stream.index
        last = self._last_dts.get(index)
        self._last_dts[index] = packet.dts if last is None else max(last, packet.dts)
        return last is not None and packet.dts <= last

    def _is_undecodable(self, packet: Any) -> bool:
        """True for packets of another video track between the excerpt's start and a key frame."""
        stream = packet.stream
        if self._clip.start is None or stream.type != "video" or is_cover(stream):
            return False
        if packet.is_keyframe:
            self._begun.add(stream.index)
        elif stream.index not in self._begun:
            self._cut_off.add(f"{label_of(stream)}: what lies before its first key frame")
            return True
        return False

    def _mux_others(self, stream: Any, packets: Iterable[Any]) -> None:
        """Mux packets of another stream; those that the muxer refuses are counted."""
        for packet in packets:
            self._unless_damaged(self._mux, stream, packet)

    def _unless_damaged(self, work: Callable[..., T], *arguments: Any) -> T | list[Any]:
        """Return what `work` returns; a damaged packet, which `work` refuses, counts as skipped."""
        try:
            return work(*arguments)
        except av.FFmpegError as error:
            if is_of_the_system(error) and error.errno not in _OF_CONTENT:
                raise  # an error of disk or memory
            self.skipped_packets += 1
            return []

    def _mux(self, stream: Any, packet: Any) -> None:
        # PyAV's encoders leave a packet's stream unset, which would mean the first stream
        packet.stream = stream
        self._container.mux_one(packet)
        sent = self._sent.get(stream.index)
        if sent is not None:
            sent.packets += bool(packet.size)  # FLAC's last packet only ends the stream
        elif is_cover(stream):
            self._covers.add(stream.index)

    # -- ending --------------------------------------------------------------------------------

    def finish(self, keep_part: bool = False) -> None:
        """Write the trailer and give the file its name.

        keep_part: the video is not whole, so the file stays under the name of the part.
        Raises StrictError for losses that show only while the file is read, OutputError when the
        file does not hold everything that was sent to it.
        """
        with self._lock, write_errors(self.part):
            for converter in self._others.converters:
                self._mux_others(converter.stream, self._unless_damaged(converter.flush))
            for packet in [] if self._length is None else self._length.finish():
                self._mux(self._video, packet)
            hides_subtitles = self._hides_subtitles()
            self._container.close()
            if hides_subtitles:
                hide_subtitles(self.target.own_path)
            if not self._keep_pixel_aspect():
                self.dropped.append("pixel aspect ratio: no room for it in the header")
            self.bytes_out = self.target.own_path.stat().st_size
            if keep_part:
                self.target.leave()
            else:
                self._refuse_loss()
                self.dropped += sorted(self._cut_off)  # no loss: sound is cut at packets, too
                self._check_written()
                self.target.keep()
            self.is_finished = True

    def _check_written(self) -> None:
        """Read the file back. A file that lost something does not get the output's name."""
        sent = list(self._sent.values())
        missing = missing_from(self.target.own_path, self.format, sent, len(self._covers))
        if missing is not None:
            self.target.leave()
            self.is_finished = True
            raise OutputError(
                f"{self.target.path} is incomplete: {missing}; what was written is kept "
                f"as {self.part}. Try another container, such as .mkv, and report it"
            )

    def _hides_subtitles(self) -> bool:
        """True for an mp4 or mov with subtitles, none of which is to be shown unasked."""
        shown = [s.disposition & Disposition.default for s in self._container.streams.subtitles]
        return self.format not in MATROSKA and bool(shown) and not any(shown)

    def _keep_pixel_aspect(self) -> bool:
        """mp4 and mov take the aspect ratio from the encoder; Matroska's muxer needs help."""
        if self._shown_wh is None or self.format not in MATROSKA:
            return True
        return set_display_size(self.target.own_path, self._video_number, self._shown_wh)

    def abort(self) -> None:
        """Close and remove what was written. Never raises: it runs after another error.

        If another thread is about to write, it gets an error.
        """
        with self._lock:
            if self._container is not None:
                with contextlib.suppress(Exception):
                    self._container.close()
                self._container = None  # FFmpeg crashes when a closed container gets a packet
            self.target.discard()


def _is_before_0(packet: Any) -> bool:
    """True for sound before 0, which Matroska would play, since it has no edit lists to hide sound.

    False for the last packet before 0, since a decoder needs it to get going.
    """
    if packet.stream.type != "audio" or packet.pts is None:
        return False
    return bool(packet.pts + 2 * (packet.duration or 0) <= 0)
