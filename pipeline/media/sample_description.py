"""Finds what an mp4 or mov says about its video that no output can say."""

import struct
from collections.abc import Iterator
from typing import IO

from makeup_video.pipeline.media.input_file import VideoSource
from makeup_video.pipeline.media.mp4_boxes import Box, boxes_at, boxes_in, whole_file

DOLBY_VISION = "Dolby Vision"
_DOLBY_VISION_BOXES = (b"dvcC", b"dvvC", b"dvwC")
_DOLBY_VISION_CODECS = (b"dvh1", b"dvhe", b"dvav", b"dva1", b"dav1")
_TRACK_ID_AT = {0: 12, 1: 20}  # in the track header, by its version
_FIRST_ENTRY_AT = 8  # in the sample description (stsd)
_SIZE_AT, _BOXES_AT = 24, 78  # in an entry for video
_CLAP_BYTES = 32


def lost_descriptions(source: VideoSource) -> list[str]:
    """A line for each statement about the video that no output holds: Dolby Vision by name, and a
    clean aperture (`clap`), the part of the picture that is to be shown.

    PyAV gives no access to either. Containers other than mp4 and mov give no lines.
    """
    if not source.container.format.name.startswith("mov"):
        return []
    try:
        with source.path.open("rb") as file:
            lines = [
                line
                for entry in _entries(file, whole_file(source.path), source.video.id)
                for line in _lost_of(file, entry)
            ]
    except (OSError, struct.error):  # the file was removed meanwhile, or its header is damaged
        return []
    return list(dict.fromkeys(lines))


def _entries(file: IO[bytes], whole: Box, track_id: int) -> Iterator[Box]:
    """The entries of a track's sample description; the name of each is its codec's."""
    for track in boxes_at(file, whole, b"moov", b"trak"):
        if track_id not in (_id_in(file, header) for header in boxes_at(file, track, b"tkhd")):
            continue
        for table in boxes_at(file, track, b"mdia", b"minf", b"stbl", b"stsd"):
            yield from boxes_in(file, table._replace(begin=table.begin + _FIRST_ENTRY_AT))


def _id_in(file: IO[bytes], header: Box) -> int | None:
    (version,) = _numbers(file, header.begin, "B")
    at = _TRACK_ID_AT.get(version)
    return None if at is None else int(_numbers(file, header.begin + at, ">I")[0])


def _lost_of(file: IO[bytes], entry: Box) -> Iterator[str]:
    shown_wh = _numbers(file, entry.begin + _SIZE_AT, ">2H")
    boxes = list(boxes_in(file, entry._replace(begin=entry.begin + _BOXES_AT)))
    if entry.name in _DOLBY_VISION_CODECS or any(b.name in _DOLBY_VISION_BOXES for b in boxes):
        yield f"tag of {DOLBY_VISION}: it describes the unpainted picture"
    for box in boxes:
        if box.name == b"clap" and box.end - box.begin >= _CLAP_BYTES:
            wide, by, high, down, *offsets = _numbers(file, box.begin, ">4I4i")
            clean_wh = wide / (by or 1), high / (down or 1)
            if all(clean_wh) and (clean_wh != shown_wh or any(offsets[::2])):
                size = "x".join(f"{length:g}" for length in clean_wh)
                yield f"clean aperture of {size} px: the whole picture is shown"


def _numbers(file: IO[bytes], at: int, layout: str) -> tuple[int, ...]:
    """Numbers at a place of the file, as struct reads them. Raises struct.error at its end."""
    file.seek(at)
    return struct.unpack(layout, file.read(struct.calcsize(layout)))
