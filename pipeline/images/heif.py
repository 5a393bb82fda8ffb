"""Reads HEIF photos, such as the HEIC files of phones, with pi-heif.

The file's primary picture is read, upright and with its tiles joined. Thumbnails, depth and the
gain map of HDR photos are left out. Without the gain map a photo looks as on an ordinary screen.
"""

from io import BytesIO
from typing import Any

import numpy as np
from makeup_video.pipeline.errors import InstallError

# Brands of HEVC pictures (ISO/IEC 23008-12, annex B). "mif1" says only that there is a picture.
_STILLS = {b"heic", b"heix", b"heim", b"heis"}
_ANY = {b"mif1"}
_OTHERS = {b"avif", b"avis"}
HEAD_BYTES = 64  # the first bytes of a file, enough for the brands that cameras write
_BANDS_PX = 1_000_000  # colours are converted in bands of this many pixels, to bound the memory
# Marks of data beside the picture: ISO/IEC 23008-12, 6.5.8; ISO 21496-1 (an item of the kind
# "tmap"); and Apple's names. pi-heif does not list all of this data.
_BESIDE = {
    b":hdrgainmap\0": "gain map of HDR",
    b"tmap\0": "gain map of HDR",
    b":auxid:2\0": "depth",
    b":disparity\0": "depth",
    b"matte\0": "masks of the camera",
}

# The errors that pi-heif raises for damaged files.
_DAMAGE = (OSError, ValueError, SyntaxError, RuntimeError, EOFError, IndexError)


class DamagedHeifError(Exception):
    """The file is damaged, cut short, or of a kind that pi-heif does not decode."""


def is_heif(head: bytes) -> bool:
    """True when a file that begins with these bytes holds an HEVC picture."""
    if head[4:8] != b"ftyp":
        return False
    end = min(int.from_bytes(head[:4], "big"), HEAD_BYTES, len(head))
    brands = {head[at : at + 4] for at in (8, *range(16, end - 3, 4)) if at + 4 <= end}
    return bool(brands & (_STILLS | _ANY)) and not brands & _OTHERS


def _library(name: object) -> Any:
    """Import pi-heif, set to read nothing but the pictures.

    name: the photo, for the message.  Raises InstallError when pi-heif is missing.
    """
    try:
        import pi_heif
    except ImportError as error:
        raise InstallError(
            f"{name} is a HEIC photo, and pi-heif, which reads them, is not installed: run "
            "pip install pi-heif, or save the photo as JPEG or PNG"
        ) from error
    pi_heif.options.THUMBNAILS = False
    pi_heif.options.DEPTH_IMAGES = False
    pi_heif.options.AUX_IMAGES = False
    pi_heif.options.DECODE_THREADS = 2  # as many as the AVIF decoder gets for a visitor's photo
    return pi_heif


def register_with_pillow(name: object) -> str:
    """Let Pillow open HEIF files; returns Pillow's name of the format. Raises InstallError."""
    _library(name).register_heif_opener()
    return "HEIF"


def size_wh(data: bytes, name: object) -> tuple[int, int]:
    """(width, height) of the upright picture, from the header.

    Raises DamagedHeifError, InstallError.
    """
    pi_heif = _library(name)
    try:
        width_px, height_px = pi_heif.open_heif(BytesIO(data)).size
    except _DAMAGE as error:
        raise DamagedHeifError(str(error)) from error
    return width_px, height_px


def decode(data: bytes, name: object) -> tuple[np.ndarray, dict[str, Any]]:
    """Decode to (pixels, pi-heif's info).

    The pixels are (H, W, 1, 3 or 4), grey or RGB(A), uint8, or uint16 for deeper files. Colours
    without an ICC profile are converted to sRGB by `to_srgb`. The picture is upright, and the EXIF
    block in the info says so. Raises DamagedHeifError, InstallError.
    """
    pi_heif = _library(name)
    try:
        file = pi_heif.open_heif(BytesIO(data), convert_hdr_to_8bit=False)
        picture = file[file.primary_index]
        pixels = np.array(picture)  # a copy: the memory is freed with the file
    except _DAMAGE as error:
        raise DamagedHeifError(str(error)) from error
    # a monochrome picture has no axis of channels
    pixels = pixels[..., None] if pixels.ndim == 2 else pixels
    info = dict(picture.info)
    pi_heif.set_orientation(info)
    if pixels.shape[2] >= 3 and not info.get("icc_profile"):
        pixels = to_srgb(pixels, info.get("nclx_profile"))
    return pixels, info


def losses(data: bytes) -> tuple[list[str], list[str]]:
    """In words: the data that `decode` leaves out of a photo, and the conversions that it makes."""
    pi_heif = _library("this")
    try:
        file = pi_heif.open_heif(BytesIO(data))
        picture = file[file.primary_index]
    except _DAMAGE:
        return [], []
    info, is_grey = picture.info, not picture.mode.startswith("RGB")
    beside = [name for mark, name in _BESIDE.items() if mark in data]
    if len(file) > 1:
        beside.append("further pictures")
    is_kept = is_grey or info.get("icc_profile")
    colours = "" if is_kept else _colours(info.get("nclx_profile"))
    return list(dict.fromkeys(beside)), [f"{colours} -> sRGB"] if colours else []


def bit_depth(data: bytes) -> int:
    """Bits per sample of a photo that `decode` has decoded."""
    file = _library("this").open_heif(BytesIO(data), convert_hdr_to_8bit=False)
    return int(file[file.primary_index].info["bit_depth"])


def _code_points(nclx: dict[str, Any] | None) -> tuple[int, int]:
    """(primaries, transfer) as numbers of ITU-T H.273; sRGB's where pi-heif gives none."""
    numbers = nclx or {}
    primaries = numbers.get("color_primaries", 1)
    return int(primaries), int(numbers.get("transfer_characteristics", 13))


def _colours(nclx: dict[str, Any] | None) -> str:
    """The name of colours that must be converted to sRGB; "" for colours that may stay."""
    from makeup_video.kernels.colour import HDR_TRANSFERS, WIDE_PRIMARIES

    primaries, transfer = _code_points(nclx)
    if transfer in HDR_TRANSFERS:
        return f"HDR ({HDR_TRANSFERS[transfer]})"
    # other primaries of SDR photos are close to sRGB's, or unspecified
    return WIDE_PRIMARIES.get(primaries, "")


def to_srgb(pixels: np.ndarray, nclx: dict[str, Any] | None) -> np.ndarray:
    """Convert wide-gamut and HDR colours to sRGB; highlights of HDR are rolled off.

    pixels: (H, W, 3 or 4) uint8 or uint16, encoded; alpha stays.  nclx: pi-heif's numbers of ITU-T
    H.273; None counts as sRGB.  Returns the given array itself when its colours may stay.
    """
    if not _colours(nclx):
        return pixels
    primaries, transfer = _code_points(nclx)
    from makeup_video.kernels.colour import (
        HDR_TRANSFERS,
        SRGB,
        WIDE_PRIMARIES,
        from_srgb_primaries,
        to_encoded,
        to_linear,
    )
    from makeup_video.pipeline.images.hdr_preview import rolled_off

    is_hdr = transfer in HDR_TRANSFERS
    to_primaries = np.linalg.inv(
        from_srgb_primaries(primaries if primaries in WIDE_PRIMARIES else 1)
    )
    most = np.iinfo(pixels.dtype).max
    out = pixels.copy()
    rows = max(1, _BANDS_PX // pixels.shape[1])
    for top in range(0, len(out), rows):
        band = out[top : top + rows, :, :3]
        light = to_linear(band / np.float32(most), transfer if is_hdr else SRGB) @ to_primaries.T
        light = rolled_off(np.maximum(light, 0)) if is_hdr else np.clip(light, 0, 1)
        band[:] = (to_encoded(light, SRGB) * most + 0.5).astype(pixels.dtype)
    return out
