"""Reads a finished file back: does it hold every track and every packet that was sent to it?"""

from collections import Counter
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import av
from makeup_video.pipeline.media.codecs import MATROSKA
from makeup_video.pipeline.media.input_file import is_cover

# Of these the muxers of mp4 and mov put several packets into one sample.
_REGROUPED = {"eac3", "truehd", "mlp"}


@dataclass(slots=True)
class SentStream:
    """One track of an output, in the order of the file, and how many packets were sent to it.

    name: for messages.  kind: FFmpeg's "video", "audio", "subtitle" or "data".  codec: its name.
    exact: the file must hold just as many packets, as it must of the painted video; other tracks
    may hold more, such as the empty titles that mp4 puts between subtitles.
    """

    name: str
    kind: str
    codec: str
    exact: bool = False
    packets: int = 0


def missing_from(
    path: Path, container_format: str, sent: list[SentStream], covers: int = 0
) -> str | None:
    """What a closed file lacks of what was sent, in words; None when everything is there.

    covers: how many pictures were sent to tracks for cover art.
    """
    try:
        found, found_covers = _tracks_in(path, container_format)
    except (av.FFmpegError, ValueError) as error:
        return f"it cannot be read back ({error})"
    # Places in the file where the next track may be: some muxers leave out a track of which nothing
    # was sent, others write an empty one.
    places = {0}
    for track in sent:
        after = {at + 1 for at in places if at < len(found) and _is_whole(track, *found[at])}
        if not track.packets:
            after |= places
        if not after:
            return _difference(track, found[min(places)] if min(places) < len(found) else None)
        places = after
    if found_covers < covers:
        return f"it has {found_covers} pieces of cover art, {covers} were sent"
    return None


def _difference(track: SentStream, found: tuple[str, int] | None) -> str:
    kind, count = found or ("nothing", 0)
    if kind != track.kind:
        return f"{track.name} was sent, its place holds {kind}"
    return f"{track.name} has {count} packets, {track.packets} were sent"


def _is_whole(track: SentStream, kind: str, count: int) -> bool:
    if kind != track.kind:
        return False
    if track.exact:
        return count == track.packets
    return count >= (min(1, track.packets) if track.codec in _REGROUPED else track.packets)


def _tracks_in(path: Path, container_format: str) -> tuple[list[tuple[str, int]], int]:
    """(kind, packets) of each track but covers and attachments; and how many covers there are."""
    # Without its parsers FFmpeg hands out the packets as they are stored, and nothing is decoded.
    options = {"protocol_whitelist": "file", "fflags": "noparse+nofillin", "analyzeduration": "1"}
    with av.open(f"file:{path.absolute()}", container_options=options) as container:
        tracks = [s for s in container.streams if s.type != "attachment" and not is_cover(s)]
        if container_format in MATROSKA:
            # its header counts nothing
            counts = Counter(p.stream.index for p in container.demux(tracks) if p.size)
        else:
            counts = Counter({stream.index: stream.frames for stream in tracks})
        covers = sum(map(is_cover, container.streams))
        return [(stream.type, counts[stream.index]) for stream in tracks], covers


def sent_stream(name: str, stream: Any, *, exact: bool = False) -> SentStream:
    """A track of which nothing has been sent yet; stream: the output's."""
    return SentStream(name, stream.type, str(getattr(stream, "name", None)), exact)
