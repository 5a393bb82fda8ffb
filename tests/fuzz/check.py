"""Compares an output with its report and with the input."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import av
import cv2
from makeup_video.pipeline.media.input_file import is_cover, open_video

_NAMED = re.compile(r"(audio|subtitle|video|attachment|data) #(\d+)\b")
# Read packets as stored: FFmpeg's parsers must not change them, and edit lists must not hide any.
_AS_STORED = {"fflags": "+noparse+nofillin", "ignore_editlist": "1"}
_EMPTY_TITLE_BYTES = 2
_PCM = re.compile(r"pcm_[suf](8|16|24|32|64)")


@dataclass
class Stream:
    """One stream of a file, and the payloads of its packets."""

    kind: str
    index: int
    codec: str
    is_cover: bool
    channels: int = 0
    payloads: list[bytes] = field(default_factory=list)


def picture_faults(output: Path) -> list[str]:
    pixels = cv2.imread(str(output), cv2.IMREAD_UNCHANGED)
    return ["the output picture does not decode"] if pixels is None else []


def video_faults(source: Path, output: Path, report: dict[str, Any], trimmed: bool) -> list[str]:
    """One line for each broken promise. trimmed: the run kept only a part of the source."""
    opened = open_video(source)
    painted = int(opened.video.index)
    before = read_streams(opened.container)
    opened.close()
    try:
        with av.open(
            str(output), metadata_errors="replace", container_options=_AS_STORED
        ) as container:
            after = read_streams(container)
        return list(_faults(before, after, painted, output, report, trimmed))
    except av.FFmpegError as error:
        return [f"the output does not open or decode: {type(error).__name__}: {error}"]


def read_streams(container: Any) -> list[Stream]:
    """All streams that the file's header declares, read as far as the file is readable."""
    streams = [_read_stream(stream) for stream in container.streams]
    try:
        for packet in container.demux():
            if packet.size:
                streams[packet.stream.index].payloads.append(bytes(packet))
    except (av.FFmpegError, IndexError):
        # The product, too, keeps the packets before the damage. PyAV raises IndexError for a
        # stream that begins after the header.
        pass
    return streams


def _read_stream(stream: Any) -> Stream:
    # a stream has no name if this build of FFmpeg does not know its codec
    codec = str(getattr(stream, "name", None) or "")
    context = stream.codec_context if stream.type == "audio" else None
    channels = context.layout.nb_channels if context is not None else 0
    return Stream(stream.type, stream.index, codec, is_cover(stream), channels)


def _faults(
    before: Sequence[Stream],
    after: Sequence[Stream],
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
        in_output = [t for t in after if t.kind == kind and not t.is_cover]
        if len(in_output) < len(kept):  # mp4 writes no stream without a packet
            least = 0 if kind == "video" else report["skipped_packets"]
            kept = [t for t in kept if len(t.payloads) > least]
        if trimmed and kind != "video" and len(in_output) < len(kept):
            continue  # nor a stream without a packet in the kept part
        if len(kept) != len(in_output):
            yield f"{kind} streams: {len(kept)} promised, {len(in_output)} in the output"
            continue
        for old, new in zip(kept, in_output, strict=True):
            if (kind, old.index) == ("video", painted):
                yield from _frame_faults(output, new, report)
            elif kind != "video" and (kind, old.index) not in converted:
                missing += (lost := _lost(old, new, trimmed)) or 0
                if lost is None:
                    yield f"{kind} #{old.index} ({old.codec}): other packets than in the input"
    if not trimmed and missing > report["skipped_packets"]:
        skipped = report["skipped_packets"]
        yield f"{missing} packets of copied streams are missing, {skipped} reported"


def _named(texts: Any) -> set[tuple[str, int]]:
    """(kind, index) of the stream at the start of each line of a report."""
    found = (_NAMED.match(text) for text in texts)
    return {(match[1], int(match[2])) for match in found if match}


def _frame_faults(output: Path, stream: Stream, report: dict[str, Any]) -> Iterator[str]:
    reported = report["frames_out"]
    if report["frames_in"] != reported:
        yield f"{report['frames_in']} frames in, {reported} out"
    if len(stream.payloads) != reported:
        yield f"{reported} frames reported, {len(stream.payloads)} packets in the output"
    with av.open(str(output), metadata_errors="replace") as container:
        shown = sum(1 for _ in container.decode(container.streams[stream.index]))
    if shown != reported:
        yield f"{reported} frames reported, {shown} come out of the output's decoder"


def _lost(old: Stream, new: Stream, trimmed: bool) -> int | None:
    """The number of missing packets; None if packets are new or in another order."""
    payloads, output = _payloads(old), b"".join(_payloads(new))
    if (trimmed and output in b"".join(payloads)) or _is_ragged(old):
        return 0
    position = missing = 0
    for payload in payloads:  # compare bytes, not packets: muxers split PCM in many ways
        if output.startswith(payload, position):
            position += len(payload)
        else:
            missing += 1
    return missing if position == len(output) else None


def _is_ragged(stream: Stream) -> bool:
    """True for PCM with a packet that ends inside a sample: mp4 and mov store whole samples."""
    pcm = _PCM.match(stream.codec)
    size = int(pcm[1]) // 8 * stream.channels if pcm else 0
    return bool(size) and any(len(payload) % size for payload in stream.payloads)


def _payloads(stream: Stream) -> list[bytes]:
    if stream.codec.startswith("aac"):
        return [_without_adts(payload) for payload in stream.payloads]
    if stream.codec == "mov_text":  # muxers fill the gaps between titles with empty packets
        return [payload for payload in stream.payloads if len(payload) > _EMPTY_TITLE_BYTES]
    return stream.payloads


def _without_adts(payload: bytes) -> bytes:
    """Drop the ADTS header, which every AAC packet of a transport stream has."""
    if payload[:1] != b"\xff" or len(payload) < 2 or payload[1] < 0xF0:
        return payload
    return payload[7 if payload[1] & 1 else 9 :]
