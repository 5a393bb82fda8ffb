"""Finds the place in a file from which a decoder returns every frame of the wanted part."""

from contextlib import suppress
from fractions import Fraction
from typing import Any

import av
from makeup_video.pipeline.media.input_file import VideoSource, packets_of

_SUBTITLE_SECONDS = 60  # subtitles that begin longer than this before a start are not looked for
_BACK_SECONDS = (0, 2, 10, 60, 10**9)  # the last one is the beginning of the file
_EARLIEST = -Fraction(10**9)  # before everything; in ticks it still fits into 64 bits
_NEVER = Fraction(2**62)


def subtitles_on_screen(source: VideoSource, start: Fraction) -> list[Any]:
    """The packets of Matroska's subtitles that begin before `start` (seconds) and end after it.

    A seek to a key frame would skip them. In other containers each stream is sought by itself.
    The file is opened once more for this. Raises InputError where it cannot be opened again.
    """
    texts = [stream.index for stream in source.container.streams if stream.type == "subtitle"]
    if not texts or "matroska" not in source.container.format.name:
        return []
    found, container = [], source.open_again()
    with suppress(av.FFmpegError):  # what was found until then is good
        container.seek(int(max(Fraction(0), start - _SUBTITLE_SECONDS) * av.time_base))
        streams = [container.streams[index] for index in (source.video.index, *texts)]
        for packet in packets_of(container, *streams):
            if packet.pts is None or not packet.size:
                continue
            begins = packet.pts * packet.time_base
            if begins >= start:
                break
            ends = begins + (packet.duration or 0) * packet.time_base
            if packet.stream.type == "subtitle" and ends > start:
                found.append(packet)
    return found


def seek_before(source: VideoSource, decoder: Any, start: Fraction) -> None:
    """Go to a place from which decoding gives every frame from `start` (seconds) on.

    A seek may land after the wanted key frame (mpegts has no index, and an open group of pictures
    has frames that need the group before). So the first frame is decoded, and where that frame
    comes too late, the seek goes further back.
    """
    video, container = source.video, source.container
    if container.duration is None:
        return  # a bare stream has no times to seek by: decode it from its beginning
    if video.start_time is not None and start <= video.start_time * source.time_base:
        return  # seeking to the first picture would lose the sound before it
    # AVI and FLV refuse times before 0. From 0 on, an MPEG stream whose first picture is decoded
    # before 0 would lose its first group of pictures.
    earliest = _EARLIEST if source.has_free_clock else Fraction(0)
    for back in _BACK_SECONDS:
        try:
            ticks = int(max(earliest, start - back) / source.time_base)
            container.seek(ticks, stream=video)
            decoder.flush_buffers()
            if back == _BACK_SECONDS[-1] or _first_decodable(source, decoder) <= start:
                container.seek(ticks, stream=video)
                decoder.flush_buffers()
                return
        except av.FFmpegError:
            return  # no seeking in this file: decode from where it is


def _first_decodable(source: VideoSource, decoder: Any) -> Fraction:
    """The time, in seconds, of the first frame that can be decoded from here."""
    for packet in packets_of(source.container, source.video):
        try:
            pictures = decoder.decode(packet)
        except av.FFmpegError:
            continue  # counted when the packet is decoded again
        for picture in pictures:
            if picture.pts is not None and not picture.is_corrupt:
                return Fraction(picture.pts * source.time_base)
    return _NEVER
