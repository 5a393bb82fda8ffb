"""What PNG and JPEG files tell beside their pixels and beside what OpenCV hands over.

PNG (W3C, third edition), section 11.3; JPEG File Interchange Format 1.02, and ITU-T T.81, B.2.4.5.
"""

import struct
import zlib
from collections.abc import Iterator
from typing import NamedTuple

from makeup_video.pipeline.media.input_file import PNG_MARK

_RESOLUTION = b"pHYs"
_PNG_TAGS = {
    b"gAMA": "gamma",
    b"cHRM": "primaries",
    b"cICP": "code of its colours",
    b"sRGB": "",  # nothing is lost where it is left out
    b"tEXt": "texts",
    b"zTXt": "texts",
    b"iTXt": "texts",
}
# Texts that OpenCV reads as XMP, or in which older programs kept EXIF, XMP and profiles, which
# would tell of the picture as it was.
_KNOWN_TEXTS = (b"XML:com.adobe.xmp\0", b"Raw profile type ")
_IHDR_END = 33  # of a PNG: the mark, and the header with its length, name and checksum
_JPEG_MARK = b"\xff\xd8"
_JFIF = b"\xff\xe0\x00\x10JFIF\0"  # how the first segment of most JPEGs begins
_JFIF_END = 20  # of the file's bytes, where that segment has no small picture
_DENSITY = slice(13, 18)  # of the file's bytes: a unit, and pixels across and down
_SCAN, _COMMENT = 0xDA, 0xFE
_PER_METRE = {1: 1 / 0.0254, 2: 100.0}  # of JFIF's units, inch and centimetre
_SUFFIXES = {"png": "png", "jpeg": "jpg", "webp": "webp"}
_UNKNOWN_PER_INCH = (72, 96)  # what programs write that know no resolution


class FileTags(NamedTuple):
    """What a file tells that OpenCV does not.

    kind: "png" or "jpeg"; "" for other files.  names: what the blocks tell, in words.
    blocks: chunks of a PNG or comments of a JPEG, as they stand in the file.
    per_metre: the pixels across and down that a metre holds in print; None: not told.
    """

    kind: str
    names: tuple[str, ...] = ()
    blocks: bytes = b""
    per_metre: tuple[int, int] | None = None


def file_tags(data: bytes) -> FileTags:
    """The tags of a picture's file. A file that is damaged has those before the damage."""
    if data.startswith(PNG_MARK):
        return _tags_of_png(data)
    return _tags_of_jpeg(data) if data.startswith(_JPEG_MARK) else FileTags("")


def with_file_tags(data: bytes, kind: str, tags: FileTags) -> tuple[bytes, list[str]]:
    """A picture as OpenCV writes it with what its kind of file can tell, and a line for the rest.

    kind: of the file that `data` is, "png", "jpeg" or "webp".
    """
    lost = [] if kind == tags.kind else list(tags.names)
    blocks = tags.blocks if kind == tags.kind else b""
    if kind == "png":
        if tags.per_metre is not None:
            blocks += _chunk(_RESOLUTION, struct.pack(">IIB", *tags.per_metre, 1))
        data = data[:_IHDR_END] + blocks + data[_IHDR_END:]
    elif kind == "jpeg":
        if tags.per_metre is not None:
            across, down = (min(round(count * 0.0254), 65535) for count in tags.per_metre)
            density = struct.pack(">BHH", 1, across, down)
            data = data[: _DENSITY.start] + density + data[_DENSITY.stop :]
        data = data[:_JFIF_END] + blocks + data[_JFIF_END:]
    elif tags.per_metre is not None and not _is_usual(tags.per_metre):
        lost.append("resolution")
    return data, [f"{', '.join(lost)}: not accepted in .{_SUFFIXES[kind]}"] if lost else []


def _is_usual(per_metre: tuple[int, int]) -> bool:
    return all(round(count * 0.0254) in _UNKNOWN_PER_INCH for count in per_metre)


def _tags_of_png(data: bytes) -> FileTags:
    names, blocks, per_metre = [], b"", None
    for chunk in _chunks(data):
        name, content = chunk[4:8], chunk[8:-4]
        if name in _PNG_TAGS and not content.startswith(_KNOWN_TEXTS):
            names.append(_PNG_TAGS[name])
            blocks += chunk
        elif name == _RESOLUTION and len(content) == 9:
            across, down, unit = struct.unpack(">IIB", content)
            per_metre = (across, down) if unit == 1 else None
    return FileTags("png", tuple(name for name in dict.fromkeys(names) if name), blocks, per_metre)


def _tags_of_jpeg(data: bytes) -> FileTags:
    comments = b"".join(block for block in _segments(data) if block[1] == _COMMENT)
    per_metre = None
    if data[len(_JPEG_MARK) :].startswith(_JFIF) and len(data) >= _JFIF_END:
        unit, across, down = struct.unpack(">BHH", data[_DENSITY])
        if unit in _PER_METRE and across and down:
            per_metre = (round(across * _PER_METRE[unit]), round(down * _PER_METRE[unit]))
    return FileTags("jpeg", ("comment",) if comments else (), comments, per_metre)


def _chunk(name: bytes, content: bytes) -> bytes:
    sum_ = zlib.crc32(name + content)
    return struct.pack(">I", len(content)) + name + content + struct.pack(">I", sum_)


def _chunks(data: bytes) -> Iterator[bytes]:
    """The whole chunks of a PNG, each with its length, name and checksum."""
    at = len(PNG_MARK)
    while at + 12 <= len(data):
        end = at + 12 + int.from_bytes(data[at : at + 4], "big")
        if end > len(data):
            return
        yield data[at:end]
        at = end


def _segments(data: bytes) -> Iterator[bytes]:
    """The segments of a JPEG before its pixels, each with its marker and length."""
    at = len(_JPEG_MARK)
    while at + 4 <= len(data) and data[at] == 0xFF and data[at + 1] != _SCAN:
        end = at + 2 + int.from_bytes(data[at + 2 : at + 4], "big")
        if end > len(data) or end < at + 4:
            return
        yield data[at:end]
        at = end
