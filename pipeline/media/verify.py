"""Reads a finished file back, and finds what it lacks of the streams and packets sent to it."""

from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import av
from makeup_video.pipeline.media.codecs import MATROSKA
from makeup_video.pipeline.media.input_file import is_cover

# Codecs for which mp4 and mov put several packets into one sample.
_REGROUPED = {"eac3", "truehd", "mlp"}


@dataclass(slots=True)
class SentStream:
    """One stream of an output, and how many packets were sent to it.

    name: for messages.  kind: FFmpeg's "video", "audio", "subtitle" or "data".  codec: its name.
    exact: the file must hold exactly this many packets; so for the painted video. Other streams may
    hold more: mp4 puts empty subtitles between the others.
    """

    name: str
    kind: str
    codec: str
    exact: bool = False
    packets: int = 0


def missing_from(
    path: Path, container_format: str, sent: list[SentStream], covers: int = 0
) -> str | None:
    """What a closed file lacks, in words; None when everything is there.

    sent: in the order of the file.  covers: how many pictures of cover art were sent.
    """
    try:
        found, found_covers = _streams_in(path, container_format)
    except (av.FFmpegError, ValueError) as error:
        return f"it cannot be read back ({error})"
    # Where the next stream may be in the file: some muxers leave out a stream to which nothing was
    # sent, others write an empty one.
    positions = {0}
    for stream in sent:
        after = {n + 1 for n in positions if n < len(found) and _is_whole(stream, *found[n])}
        if not stream.packets:
            after |= positions
        if not after:
            first = min(positions)
            return _difference(stream, found[first] if first < len(found) else None)
        positions = after
    if found_covers < covers:
        return f"it holds {found_covers} pieces of cover art, but the number sent is {covers}"
    return None


def _difference(stream: SentStream, found: tuple[str, int] | None) -> str:
    kind, count = found or ("nothing", 0)
    if kind != stream.kind:
        return f"{stream.name} was sent, but its place in the file holds {kind}"
    return f"{stream.name} has {count} packets, but {stream.packets} were sent"


def _is_whole(stream: SentStream, kind: str, count: int) -> bool:
    if kind != stream.kind:
        return False
    if stream.exact:
        return count == stream.packets
    return count >= (min(1, stream.packets) if stream.codec in _REGROUPED else stream.packets)


def _streams_in(path: Path, container_format: str) -> tuple[list[tuple[str, int]], int]:
    """(kind, packets) of each stream but cover art and attachments; the count of cover art."""
    # without its parsers FFmpeg returns the packets as they are stored, and decodes nothing
    options = {"protocol_whitelist": "file", "fflags": "noparse+nofillin", "analyzeduration": "1"}
    with av.open(f"file:{path.absolute()}", container_options=options) as container:
        streams = [s for s in container.streams if s.type != "attachment" and not is_cover(s)]
        if container_format in MATROSKA:
            # its header has no counts
            counts = Counter(p.stream.index for p in container.demux(streams) if p.size)
        else:
            counts = Counter({stream.index: stream.frames for stream in streams})
        covers = sum(map(is_cover, container.streams))
        return [(stream.type, counts[stream.index]) for stream in streams], covers


def sent_stream(name: str, stream: Any, *, exact: bool = False) -> SentStream:
    """A stream to which nothing has been sent yet; stream: the output's."""
    return SentStream(name, stream.type, str(getattr(stream, "name", None)), exact)
