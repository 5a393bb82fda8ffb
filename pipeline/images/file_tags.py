"""Reads what PNG, JPEG and HEIF files hold beyond what OpenCV returns, and writes it back.

PNG (W3C, third edition), section 11.3; JPEG File Interchange Format 1.02.
"""

import re
import struct
import zlib
from collections.abc import Iterator, Sequence
from typing import NamedTuple

from makeup_video.pipeline.files.marks import JPEG_MARK, PNG_MARK
from makeup_video.pipeline.images.heif import is_heif, losses
from makeup_video.pipeline.images.jpeg_segments import (
    APP1,
    APP2,
    COMMENT,
    Segment,
    behind_picture,
    iptc_of,
    iptc_segment,
    is_cmyk,
    segment,
    segments,
)

_RESOLUTION = b"pHYs"
_PNG_TAGS = {
    b"gAMA": "gamma",
    b"cHRM": "primaries",
    b"cICP": "code of its colours",
    b"sRGB": "",  # nothing is lost when this chunk is left out
    b"tEXt": "texts",
    b"zTXt": "texts",
    b"iTXt": "texts",
}
# Texts that are not copied: OpenCV reads the first as XMP. In the others older programs kept EXIF,
# XMP and profiles, which would describe the unpainted picture.
_KNOWN_TEXTS = (b"XML:com.adobe.xmp\0", b"Raw profile type ")
# IPTC alone, or within Photoshop's data.
_IPTC_TEXTS = (b"Raw profile type iptc\0", b"Raw profile type 8bim\0")
_EXTENDED_XMP = b"http://ns.adobe.com/xmp/extension/\0"  # begins such an APP1 segment of a JPEG
_COLOUR_TYPE = slice(25, 26)  # its place in a PNG file
# PNG colour types that OpenCV returns as RGB: palette, and grey with transparency.
_READ_AS_RGB = {b"\3": "palette", b"\4": "grey"}
_GREY = b"\0"
_IHDR_END = 33  # a PNG's mark, and its header with length, name and checksum, end here
_JFIF = b"\xff\xe0\x00\x10JFIF\0"  # the first segment of most JPEGs begins so
_JFIF_END = 20  # that segment ends at this byte of the file if it has no thumbnail
_DENSITY = slice(13, 18)  # bytes of the file: a unit, and pixels across and down
_PER_METRE = {1: 1 / 0.0254, 2: 100.0}  # JFIF's units, inch and centimetre, per metre
_SUFFIXES = {"png": "png", "jpeg": "jpg", "webp": "webp"}
_UNKNOWN_PER_INCH = (72, 96)  # programs that know no resolution write these values
_LEAST_BYTES = 100  # fewer bytes behind a picture cannot be another picture
_GAIN_MAP = b"urn:iso:std:iso:ts:21496:"  # begins a segment that announces a gain map
_ADOBE_GAIN_MAP = b"hdrgm:"
# The names with which Adobe, Google and Apple announce further pictures, movies and XMP in the same
# file. They occur as attributes and as elements.
_ANNOUNCED = (
    rb"(?:hdrgm:|Container:|Item:|HDRGainMap:|GCamera:Motion|GCamera:MicroVideo|"
    rb"xmpNote:HasExtendedXMP)[\w.-]*"
)
_ATTRIBUTE = re.compile(rb"\s%b\s*=\s*(?:\"[^\"]*\"|'[^']*')" % _ANNOUNCED)
_TAG = re.compile(rb"<(/?)%b(?:\s[^<>]*?)?(/?)>" % _ANNOUNCED)


class FileTags(NamedTuple):
    """What a file holds that OpenCV does not return.

    kind: "png" or "jpeg"; "" for other files.  names: what the blocks hold, in words.
    blocks: chunks of a PNG, or comments and IPTC of a JPEG, as they stand in the file.
    per_metre: the print resolution, pixels per metre across and down; None: not given.
    lost: lines about data that no output can hold.
    conversions: how reading the file changes the pixels, such as "CMYK -> RGB".
    """

    kind: str
    names: tuple[str, ...] = ()
    blocks: bytes = b""
    per_metre: tuple[int, int] | None = None
    lost: tuple[str, ...] = ()
    conversions: tuple[str, ...] = ()


def file_tags(data: bytes) -> FileTags:
    """Read the tags of a picture's file; of a damaged file, those before the damage."""
    if data.startswith(PNG_MARK):
        return _tags_of_png(data)
    if is_heif(data):
        return _tags_of_heif(data)
    return _tags_of_jpeg(data) if data.startswith(JPEG_MARK) else FileTags("")


def with_file_tags(data: bytes, kind: str, tags: FileTags) -> tuple[bytes, list[str]]:
    """Add the tags that the file can hold; return the new file, and lines about lost tags.

    data: a file as OpenCV writes it.  kind: of that file, "png", "jpeg" or "webp".
    """
    lost = [] if kind == tags.kind else list(tags.names)
    blocks = tags.blocks if kind == tags.kind else b""
    if kind == "png":
        if tags.per_metre is not None:
            blocks += _chunk(_RESOLUTION, struct.pack(">IIB", *tags.per_metre, 1))
        data = data[:_IHDR_END] + blocks + data[_IHDR_END:]
    elif kind == "jpeg":
        if tags.per_metre is not None:
            # JFIF forbids a density of 0
            across, down = (max(1, min(round(one * 0.0254), 65535)) for one in tags.per_metre)
            density = struct.pack(">BHH", 1, across, down)
            data = data[: _DENSITY.start] + density + data[_DENSITY.stop :]
        data = data[:_JFIF_END] + blocks + data[_JFIF_END:]
    elif tags.per_metre is not None and not _is_usual(tags.per_metre):
        lost.append("resolution")
    lines = [f"{', '.join(lost)}: not accepted in .{_SUFFIXES[kind]}"] if lost else []
    return data, [*tags.lost, *lines]


def without_announcements(xmp: bytes) -> bytes:
    """XMP that no longer announces a gain map, further pictures, a movie or more XMP in the file.

    We do not write those, so a viewer would look for them in vain.
    """
    kept, begin, depth = [], 0, 0
    for tag in _TAG.finditer(xmp):
        ends, is_empty = tag.groups()
        if not depth:
            kept.append(xmp[begin : tag.start()])
        if not is_empty:
            depth = max(0, depth - 1) if ends else depth + 1
        begin = tag.end()
    if not depth:
        kept.append(xmp[begin:])
    return _ATTRIBUTE.sub(b"", b"".join(kept))


def _is_usual(per_metre: tuple[int, int]) -> bool:
    return all(round(count * 0.0254) in _UNKNOWN_PER_INCH for count in per_metre)


def _tags_of_png(data: bytes) -> FileTags:
    names, blocks, per_metre = [], b"", None
    lost: tuple[str, ...] = ()
    colour_type = data[_COLOUR_TYPE]
    for chunk in _chunks(data):
        name, content = chunk[4:8], chunk[8:-4]
        if name in _PNG_TAGS and not content.startswith(_KNOWN_TEXTS):
            names.append(_PNG_TAGS[name])
            blocks += chunk
        elif content.startswith(_IPTC_TEXTS):
            lost += ("IPTC: it is not read from a PNG",)
        elif name == b"tRNS" and colour_type == _GREY:
            lost += ("transparency: it is not read where one tone of grey is transparent",)
        elif name == _RESOLUTION and len(content) == 9:
            across, down, unit = struct.unpack(">IIB", content)
            per_metre = (across, down) if unit == 1 and across and down else None
    names = [name for name in dict.fromkeys(names) if name]
    was = _READ_AS_RGB.get(colour_type)
    changed = (f"{was} -> RGB",) if was else ()
    return FileTags("png", tuple(names), blocks, per_metre, tuple(dict.fromkeys(lost)), changed)


def _tags_of_jpeg(data: bytes) -> FileTags:
    found = list(segments(data))  # only once, since a large photo takes milliseconds
    comments = b"".join(segment(*one) for one in found if one[0] == COMMENT)
    per_metre = None
    if data[len(JPEG_MARK) :].startswith(_JFIF) and len(data) >= _JFIF_END:
        unit, across, down = struct.unpack(">BHH", data[_DENSITY])
        if unit in _PER_METRE and across and down:
            per_metre = (round(across * _PER_METRE[unit]), round(down * _PER_METRE[unit]))
    data_of_iptc = iptc_of(found)
    iptc = iptc_segment(data_of_iptc) if data_of_iptc else b""
    names = [name for name, block in (("comment", comments), ("IPTC", iptc)) if block]
    lost = [*_lost_behind(found)]
    if data_of_iptc and not iptc:
        lost.append("IPTC: it is longer than 64 kB")
    if any(marker == APP1 and content.startswith(_EXTENDED_XMP) for marker, content in found):
        lost.append("extended XMP: the first 64 kB are written alone")
    changed = ("CMYK -> RGB",) if is_cmyk(found) else ()
    return FileTags("jpeg", tuple(names), iptc + comments, per_metre, tuple(lost), changed)


def _tags_of_heif(data: bytes) -> FileTags:
    beside, changed = losses(data)
    lost = (f"{', '.join(beside)}: the picture is written alone",) if beside else ()
    return FileTags("", lost=lost, conversions=tuple(changed))


def _lost_behind(found: Sequence[Segment]) -> tuple[str, ...]:
    """A line about data behind the picture: a gain map, more pictures, a movie, a phone's data."""
    rest = behind_picture(found).strip(b"\0")
    if len(rest) < _LEAST_BYTES:
        return ()
    has_gain_map = any(
        (marker == APP2 and content.startswith(_GAIN_MAP))
        or (marker == APP1 and _ADOBE_GAIN_MAP in content)
        for marker, content in found
    )
    if has_gain_map:
        name = "gain map of HDR"
    elif JPEG_MARK + b"\xff" in rest or b"ftyp" in rest:
        name = "further pictures or a movie"
    else:
        name = "data of the camera"
    return (f"{name}: {len(rest) / 1e3:.1f} kB behind the picture, which is written alone",)


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
