"""Corrects the header of an mp4 or mov file that FFmpeg has written: ISO/IEC 14496-12."""

from pathlib import Path
from typing import IO

from makeup_video.pipeline.media.mp4_boxes import Box, boxes_at, whole_file

_SUBTITLES = (b"sbtl", b"subt", b"text")  # handlers of subtitle tracks
_KIND_AT = 8  # place of the handler's kind in its box
_FLAGS_AT = 3  # the last byte of a track header's flags
_ENABLED = 1


def hide_subtitles(path: Path) -> None:
    """Switch off every track of subtitles.

    FFmpeg's muxer switches on the first one even where none is to be shown unasked.
    """
    with path.open("r+b") as file:
        for track in boxes_at(file, whole_file(path), b"moov", b"trak"):
            if _kind(file, track) in _SUBTITLES:
                for header in boxes_at(file, track, b"tkhd"):
                    file.seek(header.begin + _FLAGS_AT)
                    flags = file.read(1)[0]
                    file.seek(header.begin + _FLAGS_AT)
                    file.write(bytes([flags & ~_ENABLED]))


def _kind(file: IO[bytes], track: Box) -> bytes:
    """The handler of a track, such as b"vide"."""
    for handler in boxes_at(file, track, b"mdia", b"hdlr"):
        file.seek(handler.begin + _KIND_AT)
        return file.read(4)
    return b""
