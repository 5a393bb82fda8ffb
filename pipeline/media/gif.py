"""Tells transparent GIFs from opaque ones: GIF89a, sections 20 to 23.

FFmpeg decodes every GIF to pictures with transparency, so its pixel format does not tell.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import IO, Any

import av

_HEAD = 10  # bytes before the flags of the logical screen
_EXTENSION, _CONTROL, _PICTURE, _END = b"\x21", b"\xf9", b"\x2c", b"\x3b"
_STAYS = (0, 1)  # disposal methods: unspecified, and drawing the next picture over this one


def is_opaque(path: Path, container: Any) -> bool:
    """True when the first picture is opaque and all others are drawn over what is there.

    container: the GIF, opened only for this check.  A damaged GIF counts as transparent.
    """
    try:
        first = next(container.decode(container.streams.video[0]), None)
        if first is None or first.to_ndarray(format="bgra")[..., 3].min() < 255:
            return False
        with path.open("rb") as file:
            return all(way in _STAYS for way in _disposals(file))
    except (av.FFmpegError, OSError, IndexError):
        return False


def _disposals(file: IO[bytes]) -> Iterator[int]:
    """The disposal method of each picture that declares one.

    Raises IndexError where the file is cut short, and when another GIF follows this one, which
    FFmpeg would decode as well.
    """
    file.seek(_HEAD)
    _skip_colours(file, file.read(3)[0])
    while (kind := file.read(1)) in (_EXTENSION, _PICTURE):
        if kind == _PICTURE:
            _skip_colours(file, file.read(9)[8])
            file.seek(1, 1)  # the least size of the picture's LZW codes
        elif file.read(1) == _CONTROL:
            yield file.read(2)[1] >> 2 & 7
            file.seek(-2, 1)
        while size := file.read(1)[0]:
            file.seek(size, 1)
    if kind != _END or file.read(3) == b"GIF":
        raise IndexError


def _skip_colours(file: IO[bytes], flags: int) -> None:
    """Go past the table of colours that the flags announce, if any."""
    if flags & 0x80:
        file.seek(3 << (flags & 7) + 1, 1)
