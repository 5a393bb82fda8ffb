"""The orientation that a picture's EXIF block declares, and the thumbnail in the block."""

import struct
from typing import Literal

from makeup_video.pipeline.frames.orientation import UPRIGHT, Orientation, orientation_of
from makeup_video.pipeline.images.quiet import without_warnings

_ORIENTATION_TAG = 0x0112
EXIF_MARK = b"Exif\0\0"  # a block may begin with this mark, as in JPEG and HEIC
_SHORT = 3  # EXIF's code for the number type SHORT
_SIZES = {_SHORT: 2, 4: 4}  # bytes of a number by its type: SHORT and LONG
# The tags of the thumbnail's offset and length: of a JPEG, and of plain pixels.
_THUMBNAIL_TAGS = ((0x0201, 0x0202), (0x0111, 0x0117))


def orientation(block: bytes | None) -> Orientation:
    """The orientation that an EXIF block declares; upright when none is declared."""
    return UPRIGHT if block is None else orientation_of(_orientation_tag(block))


def orientation_alone(block: bytes) -> bytes:
    """A short EXIF block that holds only the orientation of the given block."""
    entry = struct.pack("<HHIHH", _ORIENTATION_TAG, _SHORT, 1, _orientation_tag(block), 0)
    return b"II*\0" + struct.pack("<IH", 8, 1) + entry + bytes(4)


def _orientation_tag(block: bytes) -> int:
    """The orientation tag, 1 to 8; 1 (upright) when the block declares none."""
    from PIL import Image  # late: videos do not need Pillow

    exif = Image.Exif()
    try:
        with without_warnings:  # Pillow warns about damaged blocks
            exif.load(block)
            declared = exif.get(_ORIENTATION_TAG, 1)
    except Exception:  # noqa: BLE001  # a damaged block may make Pillow raise anything
        return 1
    return declared if declared in range(1, 9) else 1


def without_thumbnail(block: bytes) -> bytes:
    """An EXIF block without its thumbnail, which would still show the unpainted face.

    When the block gives the thumbnail's place in a way that we do not read, only the link to the
    thumbnail's directory is removed. A damaged block is returned unchanged.
    """
    base = len(EXIF_MARK) if block.startswith(EXIF_MARK) else 0
    order: Literal["little", "big"] = "little" if block[base : base + 2] == b"II" else "big"

    def number(at: int, size: int) -> int:
        if at < base or at + size > len(block):
            raise ValueError("beyond the block")
        return int.from_bytes(block[at : at + size], order)

    try:
        first = base + number(base + 4, 4)
        link = first + 2 + 12 * number(first, 2)  # here stands the second directory's offset
        second = base + number(link, 4)
        if second == base:
            return block
        entries = range(second + 2, second + 2 + 12 * number(second, 2), 12)
        # Only a single SHORT or LONG is read: other entries may hold an offset, not the value.
        values = {
            number(at, 2): number(at + 8, _SIZES[number(at + 2, 2)])
            for at in entries
            if number(at + 2, 2) in _SIZES and number(at + 4, 4) == 1
        }
    except ValueError:
        return block
    changed = bytearray(block)
    changed[link : link + 4] = bytes(4)
    for place, length in _THUMBNAIL_TAGS:
        if values.get(place) and values.get(length):
            begin = base + values[place]
            end = min(begin + values[length], len(block))
            changed[begin:end] = b"" if end == len(block) else bytes(max(end - begin, 0))
            break
    return bytes(changed)
