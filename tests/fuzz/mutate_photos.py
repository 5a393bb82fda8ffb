"""Mutations that know how pictures are stored, and keep their checksums right."""

import zlib
from collections.abc import Sequence
from random import Random

from fuzz.mutate import NUMBERS, Mutation, number, put

_PNG = b"\x89PNG\r\n\x1a\n"
_FRAME_MARKERS = set(range(0xC0, 0xD0)) - {0xC4, 0xC8, 0xCC}
_JPEG_SIZES = (b"\xff\xff\xff\xff", b"\0\0\0\0", b"\0\1\xff\xff", b"\x20\0\x20\0")
_TIFF_ENTRY_BYTES = 12


def png_chunks(r: Random, data: bytes) -> bytes:
    """Change, delete, duplicate or move a chunk; every CRC stays right."""
    parts = _png_chunks(data)
    if not parts:
        return number(r, data)
    one, what = r.randrange(len(parts)), r.randrange(5)
    if what == 0:
        parts[0] = (parts[0][0], _byte_changed(r, parts[0][1]))
    elif what == 1:
        parts.insert(r.randrange(len(parts)), parts[one])
    elif what == 2:
        r.shuffle(parts)
    elif what == 3:
        parts[one] = (parts[one][0], _byte_changed(r, parts[one][1]))
    else:
        del parts[one]
    return _PNG + b"".join(
        len(body).to_bytes(4, "big") + name + body + zlib.crc32(name + body).to_bytes(4, "big")
        for name, body in parts
    )


def jpeg_segments(r: Random, data: bytes) -> bytes:
    """Change, delete, repeat or move a segment, or change the picture's size."""
    parts, rest = _jpeg_segments(data)
    if not parts:
        return number(r, data)
    one, what = r.randrange(len(parts)), r.randrange(6)
    if what == 0:
        r.shuffle(parts)
    elif what == 1:
        parts[one] = parts[one][:4] + _byte_changed(r, parts[one][4:])
    elif what == 2:
        del parts[one]
    elif what == 3:
        parts += [parts[one]] * r.choice((1, 5, 300))
    elif what == 4:
        size = r.choice(_JPEG_SIZES)
        parts = [p[:5] + size + p[9:] if p[1] in _FRAME_MARKERS else p for p in parts]
    else:
        rest = rest[: r.randrange(1, max(2, len(rest)))] + rest * r.choice((1, 3))
    return b"\xff\xd8" + b"".join(parts) + rest


def tiff_tags(r: Random, data: bytes) -> bytes:
    """Change a tag's number, type, count or value."""
    order = {b"II": "little", b"MM": "big"}.get(data[:2])
    if order is None or len(data) < 8:
        return number(r, data)
    first = int.from_bytes(data[4:8], "big" if order == "big" else "little")
    count = int.from_bytes(data[first : first + 2], "big" if order == "big" else "little")
    if not 0 < count < 200 or first + 2 + _TIFF_ENTRY_BYTES * count > len(data):
        return number(r, data)
    changed = bytearray(data)
    for _ in range(r.randint(1, 3)):
        at = first + 2 + _TIFF_ENTRY_BYTES * r.randrange(count)
        offset, width = r.choice(((0, 2), (2, 2), (4, 4), (8, 4)))
        value = r.randint(0, 17) if offset == 2 else r.choice((*NUMBERS, r.randrange(len(data))))
        put(changed, at + offset, value, width, order)
    return bytes(changed)


OWN: dict[str, Sequence[Mutation]] = {
    ".png": (png_chunks,), ".apng": (png_chunks,), ".jpg": (jpeg_segments,), ".tiff": (tiff_tags,),
}  # fmt: skip


def _byte_changed(r: Random, data: bytes) -> bytes:
    if not data:
        return data
    changed = bytearray(data)
    changed[r.randrange(len(data))] = r.randrange(256)
    return bytes(changed)


def _png_chunks(data: bytes) -> list[tuple[bytes, bytes]]:
    """(name, body) of each chunk; empty if the data is no PNG."""
    parts, at = [], len(_PNG)
    while data.startswith(_PNG) and at + 12 <= len(data):
        size = int.from_bytes(data[at : at + 4], "big")
        parts.append((data[at + 4 : at + 8], data[at + 8 : at + 8 + size]))
        at += 12 + size
    return parts


def _jpeg_segments(data: bytes) -> tuple[list[bytes], bytes]:
    """The segments before the scan, with their markers; and the bytes from the scan on."""
    parts, at = [], 2
    while (
        data.startswith(b"\xff\xd8")
        and at + 9 <= len(data)
        and data[at] == 0xFF
        and data[at + 1] != 0xDA
    ):
        size = int.from_bytes(data[at + 2 : at + 4], "big")
        parts.append(data[at : at + 2 + size])
        at += 2 + size
    return parts, data[at:]
