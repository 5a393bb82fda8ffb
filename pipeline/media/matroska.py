"""Writes the display size of a video into the header of a finished Matroska or WebM file.

FFmpeg's muxer takes the shape of non-square pixels from a field that PyAV 18 cannot set, so without
this an anamorphic clip comes out squeezed. The muxer leaves a gap (a Void element) after its seek
table. Info and Tracks move into this gap by as many bytes as Tracks grows, so nothing after them
has to move.
Element ids and layout: RFC 8794 (EBML) and RFC 9559 (Matroska).
"""

import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from fractions import Fraction
from pathlib import Path

_SEGMENT, _SEEK_HEAD, _SEEK, _SEEK_POSITION = (
    b"\x18\x53\x80\x67", b"\x11\x4d\x9b\x74", b"\x4d\xbb", b"\x53\xac"
)  # fmt: skip
_VOID, _CRC, _TRACKS = b"\xec", b"\xbf", b"\x16\x54\xae\x6b"
_ENTRY, _NUMBER, _VIDEO = b"\xae", b"\xd7", b"\xe0"
_DISPLAY_WIDTH, _DISPLAY_HEIGHT, _DISPLAY_UNIT = b"\x54\xb0", b"\x54\xba", b"\x54\xb2"
_RATIO = 3  # the display unit that makes the two numbers an aspect ratio
_HEADER_BYTES = 1 << 20  # Tracks is near the beginning; this holds the codec headers of many tracks


@dataclass(frozen=True)
class Element:
    """One EBML element: its id, and the bytes of the buffer where it and its content are."""

    id: bytes
    start: int
    content: int
    end: int


def set_display_size(path: Path, track_number: int, shown: tuple[int, int] | Fraction) -> bool:
    """Show Matroska's track `track_number` (1 is the first) at a size, or at an aspect ratio.

    shown: (width, height) in pixels, or width / height.
    Only the header of the file changes, in place. False when it has no room for the change.
    """
    with path.open("r+b") as file:
        data = bytearray(file.read(_HEADER_BYTES))
        segment = next(e for e in _children(data, 0, len(data)) if e.id == _SEGMENT)
        parts: dict[bytes, Element] = {}
        for element in _children(data, segment.content, min(segment.end, len(data))):
            parts.setdefault(element.id, element)
            if element.id == _TRACKS:
                break
        if not {_SEEK_HEAD, _VOID, _TRACKS} <= set(parts):
            return False
        void, tracks = parts[_VOID], parts[_TRACKS]
        if tracks.end > len(data):
            return False
        new_tracks = _element(_TRACKS, _with_size(data, tracks, track_number, _size_fields(shown)))
        grown = len(new_tracks) - (tracks.end - tracks.start)
        gap = void.end - void.start - grown
        if gap < 9:  # a Void's id and its size of 8 bytes
            return False
        moved = bytes(data[void.end : tracks.start])
        data[void.start : tracks.end] = _void(gap) + moved + new_tracks
        _move_seeks(data, parts[_SEEK_HEAD], segment.content, void.end, tracks.end, grown)
        file.seek(0)
        file.write(data)
    return True


def _size_fields(shown: tuple[int, int] | Fraction) -> bytes:
    if isinstance(shown, Fraction):
        width, height = shown.as_integer_ratio()
        unit = [(_DISPLAY_UNIT, _RATIO)]
    else:
        (width, height), unit = shown, []  # no unit means pixels
    fields = [(_DISPLAY_WIDTH, width), (_DISPLAY_HEIGHT, height), *unit]
    return b"".join(_element(name, number.to_bytes(4)) for name, number in fields)


def _with_size(data: bytearray, tracks: Element, number: int, size: bytes) -> bytes:
    """The content of Tracks, with the display size added to one entry."""
    out = b""
    for entry in _children(data, tracks.content, tracks.end):
        if entry.id == _CRC:
            continue  # computed anew below
        raw = bytes(data[entry.start : entry.end])
        fields = list(_children(data, entry.content, entry.end))
        if entry.id == _ENTRY and any(
            f.id == _NUMBER and int.from_bytes(data[f.content : f.end]) == number for f in fields
        ):
            raw = _element(_ENTRY, b"".join(_field(data, f, size) for f in fields))
        out += raw
    has_crc = next(_children(data, tracks.content, tracks.end)).id == _CRC
    return _crc(out) + out if has_crc else out


def _field(data: bytearray, field: Element, size: bytes) -> bytes:
    raw = bytes(data[field.start : field.end])
    if field.id != _VIDEO:
        return raw
    kept = b"".join(
        bytes(data[e.start : e.end])
        for e in _children(data, field.content, field.end)
        if e.id not in (_DISPLAY_WIDTH, _DISPLAY_HEIGHT, _DISPLAY_UNIT)
    )
    return _element(_VIDEO, kept + size)


def _move_seeks(
    data: bytearray, head: Element, origin: int, first: int, last: int, by: int
) -> None:
    """Subtract `by` from every seek position between first and last."""
    for seek in _children(data, head.content, head.end):
        for field in _children(data, seek.content, seek.end) if seek.id == _SEEK else ():
            place = origin + int.from_bytes(data[field.content : field.end])
            if field.id == _SEEK_POSITION and first <= place < last:
                length = field.end - field.content
                data[field.content : field.end] = (place - by - origin).to_bytes(length)
    if (check := next(_children(data, head.content, head.end))).id == _CRC:
        data[check.start : check.end] = _crc(bytes(data[check.end : head.end]))


def _children(data: bytearray, start: int, end: int) -> Iterator[Element]:
    """The elements from start to end, one after the other."""
    while start < end - 1:
        size_start = start + _length(data[start])
        content = size_start + _length(data[size_start])
        marker = 1 << 7 * (content - size_start)
        size = int.from_bytes(data[size_start:content]) & ~marker
        is_unknown = size == marker - 1
        stop = end if is_unknown else content + size
        yield Element(bytes(data[start:size_start]), start, content, stop)
        start = stop


def _length(first_byte: int) -> int:
    """Bytes of a variable-length number: one more than the zero bits it begins with."""
    return 9 - first_byte.bit_length()


def _element(identifier: bytes, content: bytes) -> bytes:
    if len(content) > 126:
        size = (len(content) | 1 << 56).to_bytes(8)  # in 8 bytes, as the muxer writes it
    else:
        size = bytes([len(content) | 128])
    return identifier + size + content


def _void(total: int) -> bytes:
    return _VOID + ((total - 9) | 1 << 56).to_bytes(8) + bytes(total - 9)


def _crc(content: bytes) -> bytes:
    return _CRC + b"\x84" + zlib.crc32(content).to_bytes(4, "little")
