"""Reads photo files as upright sRGB pixels.

Pillow reads them, since it knows ICC profiles, CMYK and AVIF, which OpenCV's reader does not.
pi-heif decodes HEIC as a format of Pillow.
"""

import io
import logging
import os
import struct
from collections.abc import Callable, Generator
from contextlib import contextmanager
from importlib import import_module
from pathlib import Path
from typing import IO, Any

import numpy as np
from makeup_video.pipeline.errors import InputError, PhotoError
from makeup_video.pipeline.files.disk_errors import unreadable
from makeup_video.pipeline.files.local_file import local_file
from makeup_video.pipeline.files.marks import JPEG_MARK, PNG_MARK
from makeup_video.pipeline.files.ordinary import open_ordinary
from makeup_video.pipeline.frames.orientation import UPRIGHT, Orientation, orientation_of
from makeup_video.pipeline.images.exif import orientation
from makeup_video.pipeline.images.heif import HEAD_BYTES, is_heif, register_with_pillow, to_srgb
from makeup_video.pipeline.images.picture_size import MOST_FILE_BYTES, MOST_PX, TIFF_MARKS
from makeup_video.pipeline.images.quiet import without_warnings
from PIL import ExifTags, Image, ImageCms, UnidentifiedImageError, features

# Without a handler Python would print the errors that Pillow logs.
logging.getLogger("PIL").addHandler(logging.NullHandler())
# Pillow's modules for photos, one for each format. Loading all of Pillow's modules takes longer,
# and some of them run programs (EPS) or open more files.
_PLUGINS = ("Jpeg", "Png", "WebP", "Avif", "Tiff", "Bmp", "Gif")
_FORMATS = tuple(name.upper() for name in _PLUGINS)
_KINDS = "JPEG, PNG, WebP, HEIC, AVIF, TIFF or BMP"
# Photos with a longer side than this are averaged down; a face then still has more than enough px.
LARGE_PX = 4096
_SEQUENCES = (b"hevc", b"hevx", b"msf1")
_AVIF = (b"avif", b"avis")
_BEGINNINGS = (JPEG_MARK + b"\xff", PNG_MARK, b"GIF8", b"BM")  # of JPEG, PNG, GIF and BMP
# Transparent pixels are laid on this middle grey, for which cameras expose. What shows through is
# not part of the photo and must not change its light.
_BEHIND = (128, 128, 128)
# A limit for progressive JPEGs, whose decoder goes over the whole picture in every pass. Ordinary
# files have about ten passes, but even a small file can have thousands.
_MOST_PASSES_PX = 20 * MOST_PX
_GREY_MODES = ("1", "L", "LA", "La", "I", "F")  # and I;16, I;16B, ...
# The errors that Pillow's decoders raise for damaged files.
_DAMAGE = (
    OSError,
    SyntaxError,
    ValueError,
    TypeError,
    KeyError,
    IndexError,
    EOFError,
    ArithmeticError,
    RuntimeError,  # AVIF's
    struct.error,
)
# How videos begin, for photos that come as bytes: only files are tried with a video decoder.
_MOVING = (b"\x1a\x45\xdf\xa3", b"FLV", b"\0\0\x01\xba", b"\0\0\x01\xb3")  # Matroska, FLV, MPEG


class _Photo:
    """An open photo file, opened only once: it may be removed or replaced while it is read.

    path: None for a photo in memory.  str() gives the photo's name for messages.
    """

    def __init__(self, data: IO[bytes], name: str, path: Path | None = None) -> None:
        self.data, self.path, self._name = data, path, name
        self.short_name = name if path is None else path.name

    def __str__(self) -> str:
        return self._name

    def begins(self, count: int = -1) -> bytes:
        """The first `count` bytes; -1: all bytes. The position in the file does not change."""
        position = self.data.tell()
        self.data.seek(0)
        head = self.data.read(count)
        self.data.seek(position)
        return head


def read_photo(
    photo: str | os.PathLike[str] | bytes,
    name: str = "the photo",
    most_px: int = MOST_PX,
    before_decoding: Callable[[], None] = lambda: None,
    most_jpeg_px: int | None = None,
) -> np.ndarray:
    """Read a photo as (H, W, 3) uint8, R'G'B' as sRGB encodes it, turned upright by its EXIF block.

    photo: the path of a file, or the content of a file as bytes; messages call the bytes `name`.
    most_px: a photo with more pixels is refused.
    before_decoding: called once the header has passed all checks, before any pixel is decoded.
    most_jpeg_px: the limit for JPEG; None: `most_px`. A large JPEG is averaged while it is decoded,
    so it needs less memory.

    Colours are converted from the file's ICC profile; without one they count as sRGB. Transparent
    pixels are laid on middle grey. A photo with more than 4096 px on its longer side is averaged
    down by a whole factor. Raises InputError when the file cannot be opened. Raises PhotoError when
    no colours can be read: another kind of file, several pictures, grey, damaged, too large. Raises
    InstallError for a HEIC photo without pi-heif.
    """
    file = _opened(photo, name)
    for plugin in _PLUGINS:
        import_module(f"PIL.{plugin}ImagePlugin")
    formats = [name for name in _FORMATS if name in Image.OPEN]
    if is_heif(file.begins(HEAD_BYTES)):
        formats = [register_with_pillow(file)]
    try:
        with file.data, without_warnings:
            with _damage_as_photo_error(file):
                picture = Image.open(file.data, formats=formats)
            with picture:
                with _damage_as_photo_error(file):
                    moves = _is_moving(picture)
                is_jpeg = picture.format in ("JPEG", "MPO")
                _refuse(picture, moves, file, (is_jpeg and most_jpeg_px) or most_px)
                before_decoding()
                with _damage_as_photo_error(file):
                    _shrink_while_decoding(picture)
                    _forget_xmp(picture)
                    picture.load()
                return _pixels(picture)
    except MemoryError:
        raise PhotoError(f"{file} needs more memory than there is: make it smaller first") from None


def _opened(photo: str | os.PathLike[str] | bytes, name: str) -> _Photo:
    if isinstance(photo, bytes):
        if not photo:
            raise InputError(f"{name} is empty (0 bytes): give a photo file")
        return _Photo(io.BytesIO(photo), name)
    path = local_file(photo, "photo")
    try:
        return _Photo(open_ordinary(path, MOST_FILE_BYTES), str(path), path)
    except OSError as error:
        raise InputError(unreadable(path, error)) from error


@contextmanager
def _damage_as_photo_error(file: _Photo) -> Generator[None, None, None]:
    """Turn Pillow's errors into PhotoError.

    Use this only around calls of Pillow that read the file: an error in our own code must not be
    reported as a damaged photo.
    """
    try:
        yield
    except Image.DecompressionBombError:
        raise PhotoError(_too_large(file)) from None
    except UnidentifiedImageError:
        raise PhotoError(_unknown(file)) from None
    except _DAMAGE as error:
        raise PhotoError(_damaged(file)) from error


def _is_moving(picture: Image.Image) -> bool:
    """True for animations and for files of several pages.

    The pages are not counted, since a hostile file may have a million of them.
    """
    # An MPO is a JPEG with more pictures behind it (depth, the other eye); its first picture is the
    # photo. A HEIF file names its main picture.
    return getattr(picture, "is_animated", False) and picture.format not in ("MPO", "HEIF")


def _refuse(picture: Image.Image, moves: bool, file: _Photo, most_px: int) -> None:
    """Raise PhotoError for every fault that shows before any pixel is decoded."""
    if picture.width * picture.height > most_px:
        raise PhotoError(_too_large(file, f"{picture.width} x {picture.height} px, ", most_px))
    if moves:
        raise PhotoError(f"{file} holds several pictures: save the one that you mean as a photo")
    if "progressive" in picture.info and _passes(file) * picture.width * picture.height > (
        _MOST_PASSES_PX
    ):
        raise PhotoError(f"{file} is stored in far too many passes: save the photo again")
    if picture.mode in _GREY_MODES or picture.mode.startswith("I;16"):
        raise PhotoError(f"{file} is a grey picture without colours: give a colour photo")


def _passes(file: _Photo) -> int:
    """The number of passes of a progressive JPEG, including the passes of its thumbnail."""
    return file.begins().count(b"\xff\xda")


def _shrink_while_decoding(picture: Image.Image) -> None:
    """Let the JPEG decoder average a large photo by 2, 4 or 8, which saves memory and time.

    Other decoders cannot do this.
    """
    many = _factor(picture)
    if many > 1:
        picture.draft(None, (picture.width // many, picture.height // many))


def _factor(picture: Image.Image) -> int:
    """The whole factor by which a picture is averaged down."""
    return -(-max(picture.size) // LARGE_PX)


def _pixels(picture: Image.Image) -> np.ndarray:
    """The upright sRGB pixels of a loaded picture.

    It must be loaded: the metadata of a PNG may stand behind its pixels.
    """
    stored_as = _orientation(picture)
    profile, nclx = picture.info.get("icc_profile"), picture.info.get("nclx_profile")
    many = _factor(picture)
    image: Image.Image = picture
    if image.mode == "P":
        image = image.convert("RGBA" if "transparency" in image.info else "RGB")
    if many > 1:
        image = image.reduce(many)
    if image.has_transparency_data:
        image = image.convert("RGBA")
        ground = Image.new("RGBA", image.size, _BEHIND)
        image = Image.alpha_composite(ground, image)
    image = _in_srgb(image, profile)
    if nclx and not profile:  # only HEIF files have `nclx`
        image = Image.fromarray(to_srgb(np.asarray(image), nclx))
    if stored_as.transposition:
        image = image.transpose(Image.Transpose[stored_as.transposition])
    return np.array(image)


def _forget_xmp(picture: Image.Image) -> None:
    """Keep Pillow from taking an orientation from XMP, as viewers and our painting do not.

    TIFF files are turned as they are loaded; in a PNG the XMP may stand behind the pixels.
    """
    for name in ("xmp", "XML:com.adobe.xmp"):
        picture.info.pop(name, None)


def _orientation(picture: Image.Image) -> Orientation:
    """The orientation in the EXIF block; upright when the block has none or is damaged."""
    block = picture.info.get("exif")
    if isinstance(block, bytes):  # Pillow's own reading may hold the orientation of XMP by now
        return orientation(block)
    _forget_xmp(picture)
    try:
        return orientation_of(picture.getexif().get(ExifTags.Base.Orientation, 1))
    except _DAMAGE:
        return UPRIGHT


def _in_srgb(image: Image.Image, profile: Any) -> Image.Image:
    """The picture in mode RGB, converted to sRGB.

    A profile that is broken or made for another kind of picture is ignored; in a TIFF it can even
    be a number. A profile named sRGB is used like any other: some profiles of that name are linear.
    """
    if image.mode == "RGBA":
        image = image.convert("RGB")
    if isinstance(profile, bytes) and profile:
        try:
            source = ImageCms.ImageCmsProfile(io.BytesIO(profile))
            converted = ImageCms.profileToProfile(
                image, source, ImageCms.createProfile("sRGB"), outputMode="RGB"
            )
            if converted is not None:
                return converted
        except (ImageCms.PyCMSError, OSError, ValueError):
            pass
    return image if image.mode == "RGB" else image.convert("RGB")


def _too_large(file: _Photo, size: str = "", most_px: int = MOST_PX) -> str:
    return f"{file} has {size}more than {most_px / 1e6:.0f} million px: make it smaller first"


def _damaged(file: _Photo) -> str:
    return f"{file} is damaged or cut short: save the photo again, or give another one"


def _unknown(file: _Photo) -> str:
    """Why Pillow does not know the file."""
    head = file.begins(12)
    brand = head[8:] if head[4:8] == b"ftyp" else b""
    if brand in _SEQUENCES:
        return f"{file} holds several pictures: save the one that you mean as a photo"
    if brand in _AVIF and not features.check("avif"):
        return f"{file} is an AVIF photo, which cannot be read here: save it as JPEG or PNG"
    if head.startswith(TIFF_MARKS):
        return (
            f"{file} is damaged, or a kind of TIFF that cannot be read here: save it as JPEG or PNG"
        )
    if (
        is_heif(file.begins(HEAD_BYTES))
        or brand in _AVIF
        or head.startswith(_BEGINNINGS)
        or head[8:] == b"WEBP"
    ):
        return _damaged(file)
    if not _is_video(file, head):
        return f"{file} is no photo that can be read: give a {_KINDS} file"
    problem = f"{file} is a video, and a photo is needed: "
    if file.path is None:  # a visitor of the page gave the photo, perhaps without a command line
        return f"{problem}pause the video, and give a screenshot"
    return (
        f"{problem}save one of its frames as a picture "
        f"(ffmpeg -ss SECONDS -i {file.short_name} -frames:v 1 photo.png)"
    )


def _is_video(file: _Photo, head: bytes) -> bool:
    if file.path is None:
        return head[4:8] == b"ftyp" or head[8:] == b"AVI " or head.startswith(_MOVING)
    from makeup_video.pipeline.media.input_file import open_video

    try:
        open_video(file.path).close()
    except InputError:
        return False
    return True
