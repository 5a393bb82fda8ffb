"""Adds the source's other streams to an output: copied, converted, or as attachments."""

from collections.abc import Callable, Iterable
from typing import Any

from makeup_video.pipeline.media.codecs import MP4
from makeup_video.pipeline.media.input_file import VideoSource, is_cover
from makeup_video.pipeline.media.pcm_gaps import FillPcmGaps, has_pcm, is_pcm_of_mp4
from makeup_video.pipeline.media.streams import (
    codec_name,
    copy_stream,
    is_implied,
    label_of,
    lost_marks,
    mystery,
    refusal,
    tags,
)
from makeup_video.pipeline.media.transcode import (
    AudioConverter,
    SubtitleConverter,
    audio_codec_for,
    can_be_mixed,
    subtitle_codec_for,
)

Convert = Callable[[Any], Iterable[Any]]


class OtherStreams:
    """The streams of an output besides the painted video.

    container: the output.  first_packets: those that came before the output was opened.
    dropped, converted: one line for each stream that is left out, or changes its codec.
    hardly_played: one line for each copied stream that few players can play in the container.
    converters: to be flushed at the end.
    lost_late: by index, a line about each stream of data that is lost once it sends anything.
    """

    def __init__(
        self, container: Any, container_format: str, source: VideoSource, first_packets: list[Any]
    ) -> None:
        self._container, self._format, self._source = container, container_format, source
        self._first_packets = first_packets
        self._routes: dict[int, tuple[Any, Convert | None]] = {}
        self.lost_late: dict[int, str] = {}
        self.dropped: list[str] = []
        self.converted: list[str] = []
        self.hardly_played: list[str] = []
        self.converters: list[AudioConverter | SubtitleConverter] = []

    def route(self, index: int) -> tuple[Any, Convert | None] | None:
        """(the output's stream, what converts its packets) for a stream of the source.

        None when the output has no such stream.
        """
        return self._routes.get(index)

    def add(self, stream: Any) -> Any | None:
        """Add a stream of the source and return the output's; None when its packets get none."""
        if is_implied(stream, self._source):
            return None
        if is_cover(stream) and self._format == "matroska":
            self._attach_cover(stream)
            return None
        if (unknown := mystery(stream)) is not None:
            self.dropped.append(f"{label_of(stream)}: {unknown}")
            return None
        reason = refusal(stream, self._format, self._first_packet(stream))
        if reason is None:
            added = copy_stream(self._container, stream)
            counts_samples = self._format in MP4 and has_pcm(stream)
            self._routes[stream.index] = (added, FillPcmGaps(stream) if counts_samples else None)
            if counts_samples and self._format == "mp4" and not is_pcm_of_mp4(stream):
                self.hardly_played.append(
                    f"{label_of(stream)}: few players can play PCM in mp4; more can in mov"
                )
        else:
            added = self._add_converted(stream)
            if added is None and stream.type == "data" and self._first_packet(stream) is None:
                self.lost_late[stream.index] = f"{label_of(stream)}: {reason}"
                return None
            if added is None:
                self.dropped.append(f"{label_of(stream)}: {reason}")
                return None
        added.metadata.update(tags(stream, self._format))
        added.disposition = stream.disposition
        if (lost := lost_marks(stream, self._format)) is not None:
            self.dropped.append(lost)
        return added

    def _add_converted(self, stream: Any) -> Any | None:
        """Add the stream in another codec; None when the container has none for such a stream."""
        if stream.codec_context is None or is_cover(stream):
            return None
        codec: str | None
        if stream.type == "audio":
            if not can_be_mixed(stream):
                return None
            codec = audio_codec_for(self._format)
            decoder = self._source.decoder_of(stream)
            audio = AudioConverter(self._container, stream, codec, decoder)
            self.converters.append(audio)
            self._routes[stream.index] = (audio.stream, audio)
        elif stream.type == "subtitle" and (codec := subtitle_codec_for(self._format, stream)):
            text = SubtitleConverter(self._container, codec, self._source.decoder_of(stream))
            self.converters.append(text)
            self._routes[stream.index] = (text.stream, text)
        else:
            return None
        self.converted.append(f"{label_of(stream)} -> {codec}")
        return self._routes[stream.index][0]

    def _attach_cover(self, stream: Any) -> None:
        """Matroska keeps cover art as attachments, which are part of the header."""
        packet = self._first_packet(stream)
        if packet is None:
            self.dropped.append(
                f"{label_of(stream)}: its picture is not at the beginning of the file"
            )
            return
        codec = codec_name(stream)
        mime = {"mjpeg": "image/jpeg", "png": "image/png"}.get(codec, "image/x-unknown")
        extension = {"mjpeg": "jpg"}.get(codec, codec)
        metadata = {key.lower(): value for key, value in stream.metadata.items()}
        self._container.add_attachment(
            metadata.get("filename", f"cover.{extension}"),
            metadata.get("mimetype", mime),
            bytes(packet),
        )

    def _first_packet(self, stream: Any) -> Any | None:
        return next((p for p in self._first_packets if p.stream.index == stream.index), None)
