"""A photo's file -> upright sRGB pixels, whatever it is stored as, or one line that says why not.

Pillow reads it, because it knows ICC profiles, CMYK and AVIF, which OpenCV's reader leaves out.
"""

import io
import logging
import os
import struct
import warnings
from collections.abc import Callable, Generator
from contextlib import contextmanager
from pathlib import Path
from typing import IO, Any

import numpy as np
from makeup_video.pipeline.errors import InputError, PhotoError
from makeup_video.pipeline.files.ordinary import open_ordinary
from makeup_video.pipeline.frames.orientation import UPRIGHT, Orientation, orientation_of
from makeup_video.pipeline.images.picture_size import MOST_PX
from PIL import ExifTags, Image, ImageCms, UnidentifiedImageError, features

logging.getLogger("PIL").addHandler(logging.NullHandler())  # else Python prints its errors
# Only formats of photos: others of Pillow's run programs (EPS) or open more files.
_FORMATS = ("JPEG", "PNG", "WEBP", "AVIF", "TIFF", "BMP", "GIF")
_KINDS = "JPEG, PNG, WebP, AVIF, TIFF or BMP"
LARGE_PX = (
    4096  # longer side; beyond, a photo is averaged down: a face still has far more than needed
)
_HEIC = (b"heic", b"heix", b"heim", b"heis", b"hevc", b"hevx", b"mif1", b"msf1")
_AVIF = (b"avif", b"avis")
_TIFF = (b"II*\0", b"MM\0*", b"II+\0", b"MM\0+")
_BEGINNINGS = (b"\xff\xd8\xff", b"\x89PNG\r\n\x1a\n", b"GIF8", b"BM")  # of JPEG, PNG, GIF, BMP
# What shows through is no part of the photo and tells nothing of its light: a middle grey, as
# cameras expose for.
_BEHIND = (128, 128, 128)
# How much a progressive JPEG may ask of the decoder, which goes over the whole picture for each of its passes:
# ordinary ones have ten or so, and a small file can have thousands.
_MOST_PASSES_PX = 20 * MOST_PX
_GREY_MODES = ("1", "L", "LA", "La", "I", "F")  # and I;16, I;16B, ...
# Whatever Pillow's decoders raise for a file that is damaged.
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
# How videos begin that come as bytes: those are shown to no decoder of videos.
_MOVING = (b"\x1a\x45\xdf\xa3", b"FLV", b"\0\0\x01\xba", b"\0\0\x01\xb3")  # Matroska, FLV, MPEG
_MOST_BYTES = 1_000_000_000  # the largest photo has no more, even when nothing is compressed


class _Photo:
    """A photo's file, open once: it may be removed, or another put in its place, while it is read.

    path: None for a photo in memory.  str() calls it in messages.
    """

    def __init__(self, data: IO[bytes], name: str, path: Path | None = None) -> None:
        self.data, self.path, self._name = data, path, name
        self.short_name = name if path is None else path.name

    def __str__(self) -> str:
        return self._name

    def begins(self, count: int = -1) -> bytes:
        """The first bytes, or all of them. Pillow finds the file as it left it."""
        at = self.data.tell()
        self.data.seek(0)
        found = self.data.read(count)
        self.data.seek(at)
        return found


def read_photo(
    photo: str | os.PathLike[str] | bytes,
    name: str = "the photo",
    most_px: int = MOST_PX,
    before_decoding: Callable[[], None] = lambda: None,
) -> np.ndarray:
    """(H, W, 3) uint8, R'G'B' as sRGB encodes it, turned upright as EXIF says.

    photo: the path of a file, or what is in one as bytes: then `name` calls it in messages.
    most_px: a photo with more pixels is refused.  before_decoding: called when the header is found
    good, and not a pixel has been decoded.

    Colours are converted from the file's ICC profile; without one they count as sRGB. Transparent
    pixels are laid on middle grey. A photo with more than 4096 px on its longer side is averaged
    down by a whole factor. Raises InputError when the file cannot be opened, PhotoError when it is
    no photo to read colours from: another kind of file, moving, grey, damaged, too large.
    """
    file = _opened(photo, name)
    Image.init()
    formats = [name for name in _FORMATS if name in Image.OPEN]
    try:
        with file.data, warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of Pillow's: our one line says what is wrong
            with _damage_told(file):
                picture = Image.open(file.data, formats=formats)
            with picture:
                with _damage_told(file):
                    moves = _is_moving(picture)
                _refuse(picture, moves, file, most_px)
                before_decoding()
                with _damage_told(file):
                    picture.load()
                return _pixels(picture)
    except MemoryError:
        raise PhotoError(f"{file} needs more memory than there is: make it smaller first") from None


def _opened(photo: str | os.PathLike[str] | bytes, name: str) -> _Photo:
    if isinstance(photo, bytes):
        if not photo:
            raise InputError(f"{name} is empty (0 bytes): give a photo file")
        return _Photo(io.BytesIO(photo), name)
    from makeup_video.pipeline.media.input_file import local_file

    path = local_file(photo, "photo")
    try:
        return _Photo(open_ordinary(path, _MOST_BYTES), str(path), path)
    except OSError as error:
        raise InputError(f"{path} cannot be read: {error.strerror}") from error


@contextmanager
def _damage_told(file: _Photo) -> Generator[None, None, None]:
    """Only around calls of Pillow that read the file, so that a fault of ours is not told as damage."""
    try:
        yield
    except Image.DecompressionBombError:
        raise PhotoError(_too_large(file)) from None
    except UnidentifiedImageError:
        raise PhotoError(_unknown(file)) from None
    except _DAMAGE as error:
        raise PhotoError(_damaged(file)) from error


def _is_moving(picture: Image.Image) -> bool:
    """Or has pages. They are not counted: in a file of a million that takes as long as it likes."""
    # an MPO is a JPEG with more pictures behind it (depth, the other eye): the first is the photo
    return getattr(picture, "is_animated", False) and picture.format != "MPO"


def _refuse(picture: Image.Image, moves: bool, file: _Photo, most_px: int) -> None:
    """What can be told before any pixel is decoded."""
    if picture.width * picture.height > most_px:
        raise PhotoError(_too_large(file, f"{picture.width} x {picture.height} px, ", most_px))
    if moves:
        raise PhotoError(f"{file} holds several pictures: save the one that shows the makeup")
    if "progressive" in picture.info and _passes(file) * picture.width * picture.height > (
        _MOST_PASSES_PX
    ):
        raise PhotoError(f"{file} is stored in far too many passes: save the photo again")
    if picture.mode in _GREY_MODES or picture.mode.startswith("I;16"):
        raise PhotoError(f"{file} is a grey picture without colours: give a colour photo")


def _passes(file: _Photo) -> int:
    """Of a progressive JPEG; those of a thumbnail in it count too."""
    return file.begins().count(b"\xff\xda")


def _pixels(picture: Image.Image) -> np.ndarray:
    """Of a picture that is loaded: what a PNG says behind its pixels is known only then."""
    orientation = _orientation(picture)
    profile = picture.info.get("icc_profile")
    many = -(-max(picture.size) // LARGE_PX)
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
    if orientation.transposition:
        image = image.transpose(Image.Transpose[orientation.transposition])
    return np.array(image)


def _orientation(picture: Image.Image) -> Orientation:
    """The orientation in the EXIF block; upright when the block has none or is damaged."""
    try:
        return orientation_of(picture.getexif().get(ExifTags.Base.Orientation, 1))
    except _DAMAGE:
        return UPRIGHT


def _in_srgb(image: Image.Image, profile: Any) -> Image.Image:
    """Mode RGB, in sRGB. A profile that is broken or of another kind of picture is left aside (in a
    TIFF it can be a number); one that calls itself sRGB is converted too, for there are linear ones
    of that name."""
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
    """Why Pillow does not know it."""
    head = file.begins(12)
    brand = head[8:] if head[4:8] == b"ftyp" else b""
    if brand in _HEIC:
        return f"{file} is a HEIC photo, which cannot be read here: save it as JPEG or PNG"
    if brand in _AVIF and not features.check("avif"):
        return f"{file} is an AVIF photo, which cannot be read here: save it as JPEG or PNG"
    if head.startswith(_TIFF):
        return (
            f"{file} is damaged, or a kind of TIFF that cannot be read here: save it as JPEG or PNG"
        )
    if brand in _AVIF or head.startswith(_BEGINNINGS) or head[8:] == b"WEBP":
        return _damaged(file)
    if not _is_video(file, head):
        return f"{file} is no photo that can be read: give a {_KINDS} file"
    return (
        f"{file} is a video, and the makeup is read from a photo: save one of its frames as a "
        f"picture (ffmpeg -ss SECONDS -i {file.short_name} -frames:v 1 look.png)"
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
