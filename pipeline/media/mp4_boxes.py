"""Finds boxes in mp4 and mov files without reading what they hold: ISO/IEC 14496-12."""

import itertools
from collections.abc import Iterator
from pathlib import Path
from typing import IO, NamedTuple

_BEGINNINGS = frozenset((b"ftyp", b"wide", b"free", b"skip", b"mdat"))
_INDEXES = frozenset((b"moov", b"moof", b"meta"))
_MOST_BOXES = 1000  # at the top of a file; a damaged one may seem to have millions


class Box(NamedTuple):
    """A box: its name, and where in the file its content begins and ends."""

    name: bytes
    begin: int
    end: int


def whole_file(path: Path) -> Box:
    """The file itself, as the box that holds the boxes at its top level."""
    return Box(b"", 0, path.stat().st_size)


def boxes_in(file: IO[bytes], outer: Box) -> Iterator[Box]:
    """The boxes in another box, in order. A damaged box ends the walk."""
    at = outer.begin
    while at + 8 <= outer.end:
        file.seek(at)
        head = file.read(16)
        size, begin = int.from_bytes(head[:4], "big"), at + 8
        if size == 1:  # the size has 64 bits
            size, begin = int.from_bytes(head[8:], "big"), at + 16
        elif size == 0:  # the box ends with the outer one
            size = outer.end - at
        if at + size < begin:
            return
        yield Box(head[4:8], begin, min(at + size, outer.end))
        at += size


def boxes_at(file: IO[bytes], outer: Box, *names: bytes) -> Iterator[Box]:
    """All boxes at a path of names, such as b"moov", b"trak", within another box."""
    first, *rest = names
    for box in boxes_in(file, outer):
        if box.name == first:
            if rest:
                yield from boxes_at(file, box, *rest)
            else:
                yield box


def lacks_index(path: Path) -> bool:
    """True for an mp4 or mov without an index: it is unfinished, still being written, or cut short.

    Programs write the index (moov) last. Raises OSError.
    """
    with path.open("rb") as file:
        boxes = itertools.islice(boxes_in(file, whole_file(path)), _MOST_BOXES)
        names = [box.name for box in boxes]
    return bool(names) and names[0] in _BEGINNINGS and not _INDEXES & set(names)
