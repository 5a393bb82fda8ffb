"""Whether an output is what its report promises, beside the input that it was made from."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import av
import cv2
from makeup_video.pipeline.media.input_file import is_cover, open_video

_NAMED = re.compile(r"(audio|subtitle|video|attachment|data) #(\d+)\b")
# What is stored: not what FFmpeg's parsers make of it once more, nor only what players show of it.
_AS_STORED = {"fflags": "+noparse+nofillin", "ignore_editlist": "1"}
_EMPTY_TITLE_BYTES = 2
_PCM = re.compile(r"pcm_[suf](8|16|24|32|64)")


@dataclass
class Track:
    """One track of a file, and what its packets hold."""

    kind: str
    index: int
    codec: str
    is_cover: bool
    channels: int = 0
    payloads: list[bytes] = field(default_factory=list)


def picture_faults(output: Path) -> list[str]:
    pixels = cv2.imread(str(output), cv2.IMREAD_UNCHANGED)
    return ["the output picture does not decode"] if pixels is None else []


def film_faults(source: Path, output: Path, report: dict[str, Any], trimmed: bool) -> list[str]:
    """One line for each promise that is broken. trimmed: only a part of the source was wanted."""
    opened = open_video(source)
    painted = int(opened.video.index)
    before = read_tracks(opened.container)
    opened.close()
    try:
        with av.open(str(output), metadata_errors="replace", container_options=_AS_STORED) as film:
            after = read_tracks(film)
        return list(_faults(before, after, painted, output, report, trimmed))
    except av.FFmpegError as error:
        return [f"the output does not open or decode: {type(error).__name__}: {error}"]


def read_tracks(container: Any) -> list[Track]:
    """All tracks that are told of at the file's beginning, as far as the file can be read."""
    tracks = [_track(stream) for stream in container.streams]
    try:
        for packet in container.demux():
            if packet.size:
                tracks[packet.stream.index].payloads.append(bytes(packet))
    except (av.FFmpegError, IndexError):
        pass  # the product, too, takes what came before; the second is PyAV's, of a late track
    return tracks


def _track(stream: Any) -> Track:
    # a stream whose codec this build does not know has no name
    codec = str(getattr(stream, "name", None) or "")
    context = stream.codec_context if stream.type == "audio" else None
    channels = context.layout.nb_channels if context is not None else 0
    return Track(stream.type, stream.index, codec, is_cover(stream), channels)


def _faults(
    before: Sequence[Track],
    after: Sequence[Track],
    painted: int,
    output: Path,
    report: dict[str, Any],
    trimmed: bool,
) -> Iterator[str]:
    dropped = _named(report["dropped"])
    converted = _named(text for text in report["converted"] if " -> " in text)
    missing = 0
    for kind in ("audio", "subtitle", "video"):
        kept = [t for t in before if t.kind == kind and (kind, t.index) not in dropped]
        kept = [t for t in kept if not t.is_cover]
        there = [t for t in after if t.kind == kind and not t.is_cover]
        if len(there) < len(kept):  # mp4 writes no track without a packet
            least = 0 if kind == "video" else report["skipped_packets"]
            kept = [t for t in kept if len(t.payloads) > least]
        if trimmed and kind != "video" and len(there) < len(kept):
            continue  # nor one of which nothing lies in the part that was wanted
        if len(kept) != len(there):
            yield f"{kind} tracks: {len(kept)} promised, {len(there)} in the output"
            continue
        for old, new in zip(kept, there, strict=True):
            if (kind, old.index) == ("video", painted):
                yield from _frame_faults(output, new, report)
            elif kind != "video" and (kind, old.index) not in converted:
                missing += (lost := _lost(old, new, trimmed)) or 0
                if lost is None:
                    yield f"{kind} #{old.index} ({old.codec}): other packets than in the input"
    if not trimmed and missing > report["skipped_packets"]:
        told = report["skipped_packets"]
        yield f"{missing} packets of copied tracks are missing, {told} reported"


def _named(texts: Any) -> set[tuple[str, int]]:
    """The tracks that lines of a report begin with."""
    found = (_NAMED.match(text) for text in texts)
    return {(one[1], int(one[2])) for one in found if one}


def _frame_faults(output: Path, track: Track, report: dict[str, Any]) -> Iterator[str]:
    told = report["frames_out"]
    if report["frames_in"] != told:
        yield f"{report['frames_in']} frames in, {told} out"
    if len(track.payloads) != told:
        yield f"{told} frames reported, {len(track.payloads)} packets in the output"
    with av.open(str(output), metadata_errors="replace") as film:
        shown = sum(1 for _ in film.decode(film.streams[track.index]))
    if shown != told:
        yield f"{told} frames reported, {shown} come out of the output's decoder"


def _lost(old: Track, new: Track, trimmed: bool) -> int | None:
    """How many packets did not arrive; None when others did, or in another order."""
    was, there = _payloads(old), b"".join(_payloads(new))
    if (trimmed and there in b"".join(was)) or _is_ragged(old):
        return 0
    at = missing = 0
    for payload in was:  # byte by byte: PCM is shared out among packets in many ways
        if there.startswith(payload, at):
            at += len(payload)
        else:
            missing += 1
    return missing if at == len(there) else None


def _is_ragged(track: Track) -> bool:
    """PCM with a packet that ends within a sample: mp4 and mov count samples, and lose the rest."""
    pcm = _PCM.match(track.codec)
    size = int(pcm[1]) // 8 * track.channels if pcm else 0
    return bool(size) and any(len(payload) % size for payload in track.payloads)


def _payloads(track: Track) -> list[bytes]:
    if track.codec.startswith("aac"):
        return [_without_adts(payload) for payload in track.payloads]
    if track.codec == "mov_text":  # muxers fill gaps between titles as they like
        return [payload for payload in track.payloads if len(payload) > _EMPTY_TITLE_BYTES]
    return track.payloads


def _without_adts(payload: bytes) -> bytes:
    """AAC of a transport stream has a header in every packet; elsewhere one stands for all."""
    if payload[:1] != b"\xff" or len(payload) < 2 or payload[1] < 0xF0:
        return payload
    return payload[7 if payload[1] & 1 else 9 :]
