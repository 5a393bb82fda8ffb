"""A photo's file -> upright sRGB pixels, whatever it is stored as, or one line that says why not.

Pillow reads it, because it knows ICC profiles, CMYK and AVIF, which OpenCV's reader leaves out.
"""

import io
import os
import struct
import warnings
from pathlib import Path

import numpy as np
from makeup_video.pipeline.errors import InputError, PhotoError
from makeup_video.pipeline.source import local_file, open_video
from makeup_video.pipeline.still import orientation_of
from PIL import Image, ImageCms, UnidentifiedImageError

# Only formats of photos: others of Pillow's run programs (EPS) or open more files.
_FORMATS = ("JPEG", "PNG", "WEBP", "AVIF", "TIFF", "BMP", "GIF")
_KINDS = "JPEG, PNG, WebP, AVIF, TIFF or BMP"
MOST_PX = 120_000_000  # the largest phone camera in wide use has 108 Mpx; 360 MB as RGB
LARGE_PX = (
    4096  # longer side; beyond, a photo is averaged down: a face still has far more than needed
)
_HEIC = (b"heic", b"heix", b"heim", b"heis", b"hevc", b"hevx", b"mif1", b"msf1")
# What shows through is no part of the photo and tells nothing of its light: a middle grey, as
# cameras expose for.
_BEHIND = (128, 128, 128)
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
    struct.error,
)
# EXIF orientation -> what makes the picture upright (Exif 2.32, section 4.6.4)
_UPRIGHT = {
    2: Image.Transpose.FLIP_LEFT_RIGHT,
    3: Image.Transpose.ROTATE_180,
    4: Image.Transpose.FLIP_TOP_BOTTOM,
    5: Image.Transpose.TRANSPOSE,
    6: Image.Transpose.ROTATE_270,
    7: Image.Transpose.TRANSVERSE,
    8: Image.Transpose.ROTATE_90,
}


def read_photo(path: str | os.PathLike[str]) -> np.ndarray:
    """(H, W, 3) uint8, R'G'B' as sRGB encodes it, turned upright as EXIF says.

    Colours are converted from the file's ICC profile; without one they count as sRGB. Transparent
    pixels are laid on middle grey. A photo with more than 4096 px on its longer side is averaged
    down by a whole factor. Raises InputError when the file cannot be opened, PhotoError when it is
    no photo to read colours from: another kind of file, moving, grey, damaged, too large.
    """
    file = local_file(path)
    Image.init()
    formats = [name for name in _FORMATS if name in Image.OPEN]
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of Pillow's: our one line says what is wrong
        try:
            with Image.open(file, formats=formats) as picture:
                _refuse(picture, path)
                return _pixels(picture)
        except PhotoError:
            raise
        except Image.DecompressionBombError:
            raise PhotoError(_too_large(path, "more than 170 million")) from None
        except UnidentifiedImageError:
            raise PhotoError(_unknown(file)) from None
        except (*_DAMAGE, MemoryError) as error:
            raise PhotoError(
                f"{path} is damaged or cut short: save the photo again, or give another one"
            ) from error


def _refuse(picture: Image.Image, path: str | os.PathLike[str]) -> None:
    """What can be told before any pixel is decoded."""
    if picture.width * picture.height > MOST_PX:
        raise PhotoError(_too_large(path, f"{picture.width} x {picture.height}"))
    # an MPO is a JPEG with more pictures behind it (depth, the other eye): the first is the photo
    if getattr(picture, "is_animated", False) and picture.format != "MPO":
        count = getattr(picture, "n_frames", 2)
        raise PhotoError(f"{path} holds {count} pictures: save the one that shows the makeup")
    if picture.mode in _GREY_MODES or picture.mode.startswith("I;16"):
        raise PhotoError(f"{path} is a grey picture without colours: give a colour photo")


def _pixels(picture: Image.Image) -> np.ndarray:
    orientation = orientation_of(picture.info.get("exif", b""))
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
    turn = _UPRIGHT.get(orientation)
    if turn is not None:  # mirroring is number 0
        image = image.transpose(turn)
    return np.array(image)


def _in_srgb(image: Image.Image, profile: bytes | None) -> Image.Image:
    """Mode RGB, in sRGB. A profile that is broken or of another kind of picture is left aside."""
    if image.mode == "RGBA":
        image = image.convert("RGB")
    if profile:
        try:
            source = ImageCms.ImageCmsProfile(io.BytesIO(profile))
            if not ImageCms.getProfileDescription(source).startswith("sRGB"):
                converted = ImageCms.profileToProfile(
                    image, source, ImageCms.createProfile("sRGB"), outputMode="RGB"
                )
                if converted is not None:
                    return converted
        except (ImageCms.PyCMSError, OSError, ValueError):
            pass
    return image if image.mode == "RGB" else image.convert("RGB")


def _too_large(path: str | os.PathLike[str], size: str) -> str:
    return f"{path} has {size} px, more than {MOST_PX / 1e6:.0f} million: make it smaller first"


def _unknown(file: Path) -> str:
    """Why Pillow does not know it."""
    with file.open("rb") as opened:
        head = opened.read(12)
    if head[4:8] == b"ftyp" and head[8:] in _HEIC:
        return f"{file} is a HEIC photo, which cannot be read here: save it as JPEG or PNG"
    try:
        open_video(file).close()
    except InputError:
        return f"{file} is no photo that can be read: give a {_KINDS} file"
    return (
        f"{file} is a video, and the makeup is read from a photo: save one of its frames as a "
        f"picture (ffmpeg -ss SECONDS -i {file.name} -frames:v 1 look.png)"
    )
