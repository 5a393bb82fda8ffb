"""The segments of a JPEG file: ITU-T T.81, annex B, and ICC.1:2022, annex B.4."""

import re
import struct
from collections.abc import Iterable, Iterator
from itertools import takewhile

from makeup_video.pipeline.files.marks import JPEG_MARK

COMMENT = 0xFE
APP1, APP2, APP13 = 0xE1, 0xE2, 0xED
# A marker. More FF may stand before it as fill bytes; FF 00 and FF D0 to FF D7 belong to the coded
# pixels. The pattern has no repetition: without one, Python finds FF twenty times as fast.
_MARKER = re.compile(rb"\xff([^\x00\xd0-\xd7\xff])")
_END = 0xD9
_SCAN = 0xDA  # coded pixels follow
_APPS = range(0xE0, 0xF0)
_FRAMES = set(range(0xC0, 0xD0)) - {0xC4, 0xC8, 0xCC}  # markers of the size and the components
_COMPONENTS_AT = 5  # place of the number of components in the content of such a segment
MOST_BYTES = 65533  # the longest content of a segment
_PROFILE = b"ICC_PROFILE\0"
_PROFILE_HEAD = len(_PROFILE) + 2  # then the segment's number from 1, and the count of segments
_PROFILE_BYTES = MOST_BYTES - _PROFILE_HEAD
_MOST_PARTS = 255
# Adobe Photoshop File Formats Specification, "Image Resource Blocks"
_PHOTOSHOP = b"Photoshop 3.0\0"
_RESOURCE = b"8BIM"
_IPTC = b"\x04\x04"
Segment = tuple[int, bytes]  # marker and content


def segments(data: bytes) -> Iterator[Segment]:
    """Yield each segment of a file; the content of the last, `_END`, is all behind the picture.

    A file that is damaged or cut short yields the segments before the damage.
    """
    at = len(JPEG_MARK)
    while found := _MARKER.search(data, at):
        marker, begin = found[1][0], found.end()
        if marker == _END:
            yield marker, data[begin:]
            return
        at = begin + int.from_bytes(data[begin : begin + 2], "big")
        if not begin + 2 <= at <= len(data):
            return
        yield marker, data[begin + 2 : at]


def segment(marker: int, content: bytes) -> bytes:
    return struct.pack(">BBH", 0xFF, marker, len(content) + 2) + content


def behind_picture(found: Iterable[Segment]) -> bytes:
    """The data behind the end of the picture: a gain map, other pictures, a movie."""
    return next((content for marker, content in found if marker == _END), b"")


def is_cmyk(found: Iterable[Segment]) -> bool:
    """True for a picture of four components."""
    frames = (content for marker, content in found if marker in _FRAMES)
    frame = next(frames, b"")
    return frame[_COMPONENTS_AT : _COMPONENTS_AT + 1] == b"\x04"


def icc_profile(data: bytes) -> bytes:
    """The ICC profile, joined from all its segments; b"" if there is none."""
    # searching the coded pixels would take as long as all the rest
    heads = takewhile(lambda one: one[0] != _SCAN, segments(data))
    parts = [
        content[len(_PROFILE) :]
        for marker, content in heads
        if marker == APP2 and content.startswith(_PROFILE)
    ]
    return b"".join(part[2:] for part in sorted(parts))  # each part begins with its number


def iptc_of(found: Iterable[Segment]) -> bytes:
    """The IPTC data of a file; b"" if there is none.

    Photoshop's other data, such as a thumbnail of the picture, is left out.
    """
    resources = b"".join(
        content[len(_PHOTOSHOP) :]
        for marker, content in found
        if marker == APP13 and content.startswith(_PHOTOSHOP)
    )
    at = 0
    while at + 7 <= len(resources):  # some programs have marks of their own in place of _RESOURCE
        name, number = resources[at + 6], resources[at + 4 : at + 6]
        at += 6 + name + 2 - name % 2  # the name, with its length byte, is padded to even length
        size = int.from_bytes(resources[at : at + 4], "big")
        data = resources[at + 4 : at + 4 + size]
        at += 4 + size + size % 2
        if number == _IPTC and data:
            return data
    return b""


def iptc_segment(data: bytes) -> bytes:
    """A segment with IPTC data; b"" if the data does not fit into one segment."""
    head = _PHOTOSHOP + _RESOURCE + _IPTC + bytes(2) + struct.pack(">I", len(data))
    content = head + data + bytes(len(data) % 2)
    return segment(APP13, content) if len(content) <= MOST_BYTES else b""


def with_icc_profile(data: bytes, profile: bytes) -> bytes:
    """Insert a profile into a JPEG file, behind all other APP segments.

    A profile that needs more than 255 segments is left out.
    """
    starts = range(0, len(profile), _PROFILE_BYTES)
    if len(starts) > _MOST_PARTS:
        return data
    blocks = [
        segment(APP2, _PROFILE + bytes([number, len(starts)]) + profile[at : at + _PROFILE_BYTES])
        for number, at in enumerate(starts, 1)
    ]
    before = takewhile(lambda one: one[0] in _APPS, segments(data))
    at = len(JPEG_MARK) + sum(len(segment(*one)) for one in before)
    return data[:at] + b"".join(blocks) + data[at:]
