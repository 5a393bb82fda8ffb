"""Photos of a face in every file format that is read, and in some that are refused."""

import io
from collections.abc import Callable
from functools import cache, partial
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from heif_files import heic
from PIL import ExifTags, Image, ImageCms, PngImagePlugin

_LOOK = Path(__file__).parents[2] / "samples" / "look.jpg"
_SIZE_WH = 300, 352  # the face is 106 px wide: just enough to read its makeup


@cache
def _face() -> Image.Image:
    with Image.open(_LOOK) as picture:
        return picture.convert("RGB").resize(_SIZE_WH, Image.Resampling.LANCZOS)


@cache
def _profile(space: str = "sRGB") -> bytes:
    """An ICC profile without its creation date."""
    data = bytearray(ImageCms.ImageCmsProfile(ImageCms.createProfile(space)).tobytes())
    data[24:36] = bytes(12)
    return bytes(data)


@cache
def _exif(orientation: int) -> bytes:
    exif = Image.Exif()
    exif[ExifTags.Base.Orientation] = orientation
    exif[ExifTags.Base.Make] = "A camera"
    return exif.tobytes()


def _save(path: Path, mode: str = "RGB", pages: int = 1, **options: Any) -> None:
    picture = _face()
    if mode.endswith("A"):
        picture = picture.copy()
        picture.putalpha(Image.linear_gradient("L").resize(picture.size))
    picture = picture.convert(mode)
    if pages > 1:
        options.update(save_all=True, append_images=[picture] * (pages - 1))
    picture.save(path, **options)


def _save_rest(path: Path) -> None:
    """A palette with one transparent entry, and text before and after the pixels."""
    text = PngImagePlugin.PngInfo()
    text.add_text("Comment", "a comment" * 20)
    text.add_itxt("XML:com.adobe.xmp", "<x:xmpmeta xmlns:x='adobe:ns:meta/'/>", zip=True)
    palette = _face().quantize(64, dither=Image.Dither.NONE)
    palette.save(path, pnginfo=text, transparency=3)


def _save_deep(path: Path) -> None:
    rgb16 = np.asarray(_face())[..., ::-1].astype(np.uint16) * 257
    path.write_bytes(cv2.imencode(path.suffix, rgb16)[1].tobytes())


def _save_turned(path: Path) -> None:
    _face().transpose(Image.Transpose.ROTATE_90).save(
        path, quality=85, exif=_exif(6), icc_profile=_profile()
    )


def _save_mpo(path: Path) -> None:
    """A phone's JPEG, followed by another picture."""
    data = io.BytesIO()
    _face().save(data, "MPO", save_all=True, append_images=[_face().resize((64, 64))])
    path.write_bytes(data.getvalue())


def _save_heic(path: Path) -> None:
    """A phone's HDR photo: tiles, a rotation, EXIF, a gain map."""
    rgb8, small = np.asarray(_face()), np.asarray(_face().resize((64, 64)))
    turned = np.ascontiguousarray(np.rot90(rgb8, -1))
    exif = _exif(1).removeprefix(b"Exif\0\0")
    path.write_bytes(heic(turned, tile_px=128, rotation_degrees=90, exif=exif, gain_map=small))


WRITERS: dict[str, Callable[[Path], None]] = {
    "plain.jpg": partial(_save, quality=85),
    "progressive.jpg": partial(_save, quality=85, progressive=True),
    "cmyk.jpg": partial(_save, mode="CMYK", quality=85),
    "grey.jpg": partial(_save, mode="L", quality=85),
    "turned_icc.jpg": _save_turned,
    "lab_icc.jpg": lambda path: _save(path, quality=85, icc_profile=_profile("LAB")),
    "restarts.jpg": partial(_save, quality=85, subsampling=0, restart_marker_blocks=4),
    "two.jpg": _save_mpo,
    "plain.png": lambda path: _save(path, icc_profile=_profile(), exif=_exif(3)),
    "alpha.png": partial(_save, mode="RGBA", dpi=(72, 72)),
    "palette_text.png": _save_rest,
    "deep.png": _save_deep,
    "lossy.webp": lambda path: _save(path, quality=80, exif=_exif(8), icc_profile=_profile()),
    "lossless.webp": partial(_save, mode="RGBA", lossless=True, method=0),
    "moving.webp": partial(_save, pages=3, duration=100),
    "plain.avif": lambda path: _save(path, quality=60, speed=10, max_threads=1, exif=_exif(6)),
    "alpha.avif": partial(_save, mode="RGBA", quality=60, speed=10, max_threads=1),
    "tiles.heic": _save_heic,
    "raw.tiff": lambda path: _save(path, icc_profile=_profile(), exif=_exif(5)),
    "lzw.tiff": partial(_save, compression="tiff_lzw"),
    "deflate_alpha.tiff": partial(_save, mode="RGBA", compression="tiff_adobe_deflate"),
    "jpeg.tiff": partial(_save, compression="jpeg", quality=85),
    "packbits_cmyk.tiff": partial(_save, mode="CMYK", compression="packbits"),
    "deep.tiff": _save_deep,
    "pages.tiff": partial(_save, pages=2, compression="tiff_lzw"),
    "plain.bmp": partial(_save),
    "still.gif": partial(_save, mode="P"),
    "moving.gif": partial(_save, mode="P", pages=2, duration=100),
}
