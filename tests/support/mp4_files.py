"""Puts boxes into the sample description of mp4 and mov files, as other programs write them."""

import struct
from pathlib import Path

_INSIDE = b"moov", b"trak", b"mdia", b"minf", b"stbl", b"stsd"


def box(name: bytes, content: bytes) -> bytes:
    return (8 + len(content)).to_bytes(4) + name + content


def clap(width: int, height: int, right: int = 0) -> bytes:
    """A clean aperture, in pixels, that lies `right` px to the right of the middle."""
    return box(b"clap", struct.pack(">4I4i", width, 1, height, 1, right, 1, 0, 1))


def describe(path: Path, *more: bytes, codec: bytes | None = None) -> Path:
    """Add boxes to the sample description of a file's first track.

    The file's index must lie behind its samples.  codec: a name to replace that of the codec.
    """
    data = bytearray(path.read_bytes())
    begin, end, heads = 0, len(data), []
    for name in _INSIDE:
        head = _find(data, begin, end, name)
        heads.append(head)
        begin, end = head + 8, head + int.from_bytes(data[head : head + 4])
    assert data.find(b"mdat") < heads[0]
    entry = begin + 8
    stop = entry + int.from_bytes(data[entry : entry + 4])
    if codec is not None:
        data[entry + 4 : entry + 8] = codec
    added = b"".join(more)
    data[stop:stop] = added
    for head in (*heads, entry):
        size = int.from_bytes(data[head : head + 4]) + len(added)
        data[head : head + 4] = size.to_bytes(4)
    path.write_bytes(data)
    return path


def _find(data: bytearray, begin: int, end: int, name: bytes) -> int:
    at = begin
    while data[at + 4 : at + 8] != name:
        at += int.from_bytes(data[at : at + 4])
        assert at < end, name
    return at
