"""Checks the size that a picture's header declares, before anything is decoded."""

import io
from pathlib import Path

from makeup_video.pipeline.errors import DecodeError
from makeup_video.pipeline.files.marks import PNG_MARK
from makeup_video.pipeline.images.heif import DamagedHeifError, is_heif, size_wh

# The largest phone camera in wide use has 108 Mpx.
MOST_PX = 120_000_000
MOST_FILE_BYTES = 1_000_000_000  # even the largest uncompressed picture has a smaller file
TIFF_MARKS = (b"II*\0", b"MM\0*", b"II+\0", b"MM\0+")  # a TIFF begins with one of these
_LONGEST_PX = 1_000_000  # libpng's limit for a row or a column


def check_size(data: bytes, path: Path) -> None:
    """Raise DecodeError when a JPEG, PNG, WebP or HEIC declares more pixels than we can paint.

    A damaged header passes, since the decoder will report the damage.
    """
    size = _size_wh(data, path)
    if size is not None and max(size) > _LONGEST_PX:
        raise _too_large(path, size, f"{_LONGEST_PX} px in a row or column")
    if size is not None and size[0] * size[1] > MOST_PX:
        raise _too_large(path, size, f"{MOST_PX / 1e6:.0f} million px")


def _size_wh(data: bytes, path: Path) -> tuple[int, int] | None:
    """(width, height) in the header; None when the header is damaged."""
    if data.startswith(b"RIFF"):
        return _webp_size_wh(data)
    if is_heif(data):
        try:
            return size_wh(data, path)
        except DamagedHeifError:
            return None
    from PIL.JpegImagePlugin import JpegImageFile
    from PIL.PngImagePlugin import PngImageFile

    # the plugins, since Image.open raises for the largest pictures before we can read their size
    kind = PngImageFile if data.startswith(PNG_MARK) else JpegImageFile
    try:
        with kind(io.BytesIO(data)) as picture:
            return picture.size
    except Exception:  # noqa: BLE001  # the decoder will report whatever stops Pillow here
        return None


def _webp_size_wh(data: bytes) -> tuple[int, int] | None:
    """(width, height) by RFC 9649, sections 2.5 to 2.7.

    Pillow would first allocate memory for the pixels.
    """
    kind, small = data[12:16], 0x3FFF
    if len(data) < 30:
        return None
    if kind == b"VP8X":
        return _little(data[24:27]) + 1, _little(data[27:30]) + 1
    if kind == b"VP8L":
        bits = _little(data[21:25])
        return (bits & small) + 1, (bits >> 14 & small) + 1
    return _little(data[26:28]) & small, _little(data[28:30]) & small


def _little(data: bytes) -> int:
    return int.from_bytes(data, "little")


def _too_large(path: Path, size_wh: tuple[int, int], most: str) -> DecodeError:
    return DecodeError(
        f"{path} has {size_wh[0]} x {size_wh[1]} px, and no picture of more than {most} can be "
        "painted: make it smaller first"
    )
