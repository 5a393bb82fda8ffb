"""Corrects the header of an mp4 or mov file that FFmpeg has written: ISO/IEC 14496-12."""

from collections.abc import Iterator
from pathlib import Path
from typing import IO

_SUBTITLES = (b"sbtl", b"subt", b"text")  # handlers of tracks
_KIND_AT = 8  # of the handler, in its box
_FLAGS_AT = 3  # the last byte of a track header's flags
_ENABLED = 1


def hide_subtitles(path: Path) -> None:
    """Switch off every track of subtitles.

    FFmpeg's muxer switches on the first one where none is to be shown unasked.
    """
    with path.open("r+b") as file:
        whole = 0, path.stat().st_size
        for movie in _boxes(file, whole, b"moov"):
            for track in _boxes(file, movie, b"trak"):
                if _kind(file, track) in _SUBTITLES:
                    for begin, _ in _boxes(file, track, b"tkhd"):
                        file.seek(begin + _FLAGS_AT)
                        flags = file.read(1)[0]
                        file.seek(begin + _FLAGS_AT)
                        file.write(bytes([flags & ~_ENABLED]))


def _kind(file: IO[bytes], track: tuple[int, int]) -> bytes:
    """The handler of a track, such as b"vide"."""
    for media in _boxes(file, track, b"mdia"):
        for begin, _ in _boxes(file, media, b"hdlr"):
            file.seek(begin + _KIND_AT)
            return file.read(4)
    return b""


def _boxes(file: IO[bytes], span: tuple[int, int], name: bytes) -> Iterator[tuple[int, int]]:
    """(begin, end) of the content of each box of that name within a span of the file."""
    at, end = span
    while at + 8 <= end:
        file.seek(at)
        head = file.read(16)
        size, begin = int.from_bytes(head[:4], "big"), at + 8
        if size == 1:  # the size has 64 bits
            size, begin = int.from_bytes(head[8:], "big"), at + 16
        if size < 8:
            return
        if head[4:8] == name:
            yield begin, at + size
        at += size
