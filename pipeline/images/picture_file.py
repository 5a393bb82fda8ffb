"""Reads and writes picture files with their metadata: JPEG, PNG and WebP with OpenCV.

HEIC is read with pi-heif, and never written.
"""

import os
from pathlib import Path
from typing import IO

import numpy as np
from makeup_video.pipeline.errors import DecodeError, InputError, OutputError
from makeup_video.pipeline.files.disk_errors import unreadable
from makeup_video.pipeline.files.marks import JPEG_MARK, PNG_MARK
from makeup_video.pipeline.files.ordinary import read_ordinary
from makeup_video.pipeline.images.exif import EXIF_MARK, orientation_alone
from makeup_video.pipeline.images.file_tags import without_announcements
from makeup_video.pipeline.images.heif import DamagedHeifError, decode, is_heif
from makeup_video.pipeline.images.jpeg_segments import (
    MOST_BYTES,
    icc_profile,
    with_icc_profile,
)
from makeup_video.pipeline.images.picture_size import MOST_FILE_BYTES, TIFF_MARKS, check_size
from makeup_video.pipeline.images.quiet import silent_opencv

# The extensions of pictures that we write.
WRITERS = {".jpg": "jpeg", ".jpeg": "jpeg", ".png": "png", ".webp": "webp"}
# The kinds of metadata, as messages name them.
EXIF, XMP, ICC_PROFILE = "EXIF", "XMP", "ICC profile"
Metadata = dict[str, bytes]  # by kind
# This begins an APP1 segment of a JPEG that holds XMP (XMP specification part 3, section 1.1.3).
_XMP_IN_JPEG = b"http://ns.adobe.com/xap/1.0/\0"
# the sizes that the second header of a BMP has in its versions
_BMP_HEADERS = [size.to_bytes(4, "little") for size in (12, 40, 52, 56, 64, 108, 124)]
_ANIMATION = 2  # the animation flag in WebP's VP8X chunk
_NO_MEMORY = -4  # cv2.Error.StsNoMem


def is_picture(path: Path) -> bool:
    """True when the file begins like a still JPEG, PNG, WebP or HEIC.

    Motion JPEG without a container begins like a JPEG, too; its extension tells it apart. Raises
    DecodeError for an animated WebP, which neither OpenCV nor FFmpeg reads as a whole, and for
    other kinds of stills. Raises InputError when the file cannot be read.
    """
    try:
        with path.open("rb") as file:
            head = file.read(4096)
            if head.startswith(PNG_MARK):
                return not _is_animated_png(file)
    except OSError as error:
        raise InputError(unreadable(path, error)) from error
    if head[:4] == b"RIFF" and head[8:12] == b"WEBP":
        if head[12:16] == b"VP8X" and len(head) > 20 and head[20] & _ANIMATION:
            raise DecodeError(f"{path} is an animated WebP: convert it to a video first")
        return True
    if is_heif(head):
        return True
    if (kind := _other_still(head)) is not None:
        raise DecodeError(
            f"{path} is {kind} picture, which is read only as the photo of a look: save it as PNG "
            "first"
        )
    return head.startswith(JPEG_MARK + b"\xff") and path.suffix.lower() not in (".mjpeg", ".mjpg")


def _other_still(head: bytes) -> str | None:
    """In words, a kind of still picture that we do not paint; a GIF counts as a video."""
    if head[:4] in TIFF_MARKS:
        return "a TIFF"
    if head[:2] == b"BM" and head[14:18] in _BMP_HEADERS:
        return "a BMP"
    return "an AVIF" if head[4:12] == b"ftypavif" else None


def _is_animated_png(file: IO[bytes]) -> bool:
    """True for an animated PNG, which is read as a video.

    The chunk that marks an animation stands before the pixels, but profiles and EXIF of any length
    may stand before the chunk.
    """
    file.seek(len(PNG_MARK))
    while len(head := file.read(8)) == 8 and head[4:] != b"IDAT":
        if head[4:] == b"acTL":
            return True
        # skip the chunk's data and checksum
        file.seek(int.from_bytes(head[:4], "big") + 4, os.SEEK_CUR)
    return False


def read_bytes(path: Path, *, is_own: bool = False) -> bytes:
    """Read the file of a picture. Raises InputError, or DecodeError for too many pixels.

    is_own: we wrote the file, so its size is not checked. A picture of before and after may have
    twice as many pixels.
    """
    try:
        data = read_ordinary(path, MOST_FILE_BYTES)
    except OSError as error:
        raise InputError(unreadable(path, error)) from error
    if not is_own:
        check_size(data, path)
    return data


def decode_picture(data: bytes, path: Path) -> tuple[np.ndarray, Metadata]:
    """Decode a picture's file to (stored pixels, metadata); path: for messages. Raises DecodeError.

    The pixels are (H, W, 1, 3 or 4) uint8 or uint16, encoded, in BGR(A) order. They are not turned
    by EXIF, but HEIC comes upright.
    """
    import cv2

    if is_heif(data):
        return _decode_heif(data, path)
    try:
        with silent_opencv:
            pixels, kinds, blobs = cv2.imdecodeWithMetadata(
                np.frombuffer(data, np.uint8), flags=cv2.IMREAD_UNCHANGED
            )
    except cv2.error as error:
        if error.code == _NO_MEMORY:
            raise MemoryError(error.err) from error
        raise DecodeError(f"{path} cannot be decoded: {error.err}") from error
    if pixels is None or pixels.size == 0:
        raise DecodeError(f"{path} is damaged or cut short: no picture could be decoded")
    if pixels.ndim == 2:
        pixels = pixels[..., None]
    names = {number: name for name, number in _opencv_kinds().items()}
    metadata = {
        names[kind]: np.asarray(blob).tobytes()
        for kind, blob in zip(kinds, blobs, strict=True)
        if kind in names  # file_tags.py copies a PNG's code of its colours (cICP)
    }
    if data.startswith(JPEG_MARK):
        # OpenCV takes every APP2 segment for a part of the profile, even those of gain maps
        metadata.pop(ICC_PROFILE, None)
        if profile := icc_profile(data):
            metadata[ICC_PROFILE] = profile
    if XMP in metadata:
        plain = metadata[XMP].removeprefix(_XMP_IN_JPEG)
        plain = plain[: plain.rfind(b">") + 1]  # OpenCV 5.0 reads a few bytes too many from a PNG
        metadata[XMP] = without_announcements(plain)
    return pixels, metadata


def _opencv_kinds() -> dict[str, int]:
    """OpenCV's number for each kind of metadata."""
    import cv2

    return {
        EXIF: int(cv2.IMAGE_METADATA_EXIF),
        XMP: int(cv2.IMAGE_METADATA_XMP),
        ICC_PROFILE: int(cv2.IMAGE_METADATA_ICCP),
    }


def _decode_heif(data: bytes, path: Path) -> tuple[np.ndarray, Metadata]:
    """Decode as `decode_picture` does; the pixels of a HEIC photo come upright.

    Raises DecodeError, InstallError.
    """
    try:
        pixels, info = decode(data, path)
    except DamagedHeifError as error:
        raise DecodeError(f"{path} is damaged or cut short: no picture could be decoded") from error
    if pixels.shape[2] >= 3:
        pixels = np.ascontiguousarray(pixels[..., [2, 1, 0, 3][: pixels.shape[2]]])
    metadata = {
        EXIF: (info.get("exif") or b"").removeprefix(EXIF_MARK),
        XMP: without_announcements(info.get("xmp") or b""),
        ICC_PROFILE: info.get("icc_profile") or b"",
    }
    return pixels, {kind: blob for kind, blob in metadata.items() if blob}


def encode_picture(path: Path, pixels: np.ndarray, metadata: Metadata) -> bytes:
    """Encode BGR(A) pixels for the path's extension.

    JPEG has quality 95 and 4:4:4, WebP and PNG are lossless. Raises OutputError.
    """
    import cv2

    suffix = path.suffix.lower()
    options = {
        ".png": [],
        # the second option keeps the colours of transparent pixels
        ".webp": [cv2.IMWRITE_WEBP_LOSSLESS_MODE, cv2.IMWRITE_WEBP_LOSSLESS_PRESERVE_COLOR],
    }.get(
        suffix,
        [
            cv2.IMWRITE_JPEG_QUALITY, 95,
            cv2.IMWRITE_JPEG_SAMPLING_FACTOR, cv2.IMWRITE_JPEG_SAMPLING_FACTOR_444,
        ],
    )  # fmt: skip
    try:
        data = _encode(suffix, pixels, metadata, options)
        if data is None:  # libpng refuses the whole picture because of a malformed profile
            rest = {kind: blob for kind, blob in metadata.items() if kind != ICC_PROFILE}
            data = _encode(suffix, pixels, rest, options)
    except cv2.error as error:
        raise OutputError(f"{path} cannot be encoded: {error.err}. Choose .png") from error
    if data is None:
        advice = "make it smaller" if suffix == ".png" else "choose .png"
        size = f"{pixels.shape[1]} x {pixels.shape[0]} px"
        raise OutputError(f"{path}: {size} cannot be encoded as {suffix}: {advice}")
    return data


def is_exif_too_long(suffix: str, exif: bytes) -> bool:
    """True when a file of this kind cannot hold the EXIF block, and gets only its orientation."""
    # OpenCV writes EXIF_MARK before the block
    return WRITERS[suffix.lower()] == "jpeg" and len(EXIF_MARK) + len(exif) > MOST_BYTES


def _encode(
    suffix: str, pixels: np.ndarray, metadata: Metadata, options: list[int]
) -> bytes | None:
    """Encode with OpenCV; None when OpenCV refuses."""
    import cv2

    blobs, profile = dict(metadata), b""
    if WRITERS[suffix] == "jpeg":
        # OpenCV leaves out a profile that needs several segments
        profile = blobs.pop(ICC_PROFILE, b"")
        if XMP in blobs:
            blobs[XMP] = _XMP_IN_JPEG + blobs[XMP]
        # OpenCV refuses the whole picture because of a block that is too long for a segment. The
        # orientation must stay, or else the picture would lie on its side.
        if EXIF in blobs and is_exif_too_long(suffix, blobs[EXIF]):
            blobs[EXIF] = orientation_alone(blobs[EXIF])
        blobs = {kind: blob for kind, blob in blobs.items() if len(blob) <= MOST_BYTES}
    numbers = _opencv_kinds()
    kinds = [numbers[kind] for kind in blobs]
    arrays = [np.frombuffer(blob, np.uint8) for blob in blobs.values()]
    with silent_opencv:
        ok, data = cv2.imencodeWithMetadata(suffix, pixels, kinds, arrays, options)
    if not ok:
        return None
    return with_icc_profile(data.tobytes(), profile) if profile else data.tobytes()
