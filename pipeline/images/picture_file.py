"""A still picture through the same path: file -> Frame (4:4:4, full range) -> stages -> file.

Pixels that nobody paints keep their exact values, whatever the depth of the file: planes are
compared before and after, and only what changed is converted back.
"""

from collections.abc import Callable
from fractions import Fraction
from pathlib import Path
from typing import Any, Literal

import av
import numpy as np
from av.video.reformatter import ColorRange, Colorspace
from makeup_video.pipeline.compare import side_by_side
from makeup_video.pipeline.errors import (
    DecodeError,
    InputError,
    OutputError,
    StrictError,
    UsageError,
)
from makeup_video.pipeline.frame import ColourTags, Frame
from makeup_video.pipeline.ordinary import read_ordinary
from makeup_video.pipeline.picture_size import check_size
from makeup_video.pipeline.report import Report
from makeup_video.pipeline.target import Target, write_errors

_WRITERS = {".jpg": "jpeg", ".jpeg": "jpeg", ".png": "png", ".webp": "webp"}
PICTURE_TICK = Fraction(1, 1)
# How a picture's frame means colour: BT.709, full range, the transfer of sRGB.
PICTURE_TAGS = ColourTags(1, 2, 13, 1)
_EXIF_TAG_ORIENTATION = 0x0112
# EXIF orientation -> counter-clockwise degrees that make the picture upright (mirroring aside)
_UPRIGHT_DEGREES = {1: 0, 2: 0, 3: 180, 4: 180, 5: 270, 6: 270, 7: 90, 8: 90}
# APP1 segments of a JPEG say what they hold (XMP specification part 3, section 1.1.3)
_XMP_IN_JPEG = b"http://ns.adobe.com/xap/1.0/\0"
_MOST_BYTES = 1_000_000_000  # the largest picture has no more, even when nothing is compressed
_NO_MEMORY = -4  # cv2.Error.StsNoMem
_KINDS = ("EXIF", "XMP", "ICC profile")  # in the order of OpenCV's numbers


def is_picture(path: Path) -> bool:
    """True when the file begins as a JPEG, PNG or WebP, and is no moving one.

    Motion JPEG without a container begins as a JPEG too: its name tells. Raises DecodeError for an
    animated WebP, which neither OpenCV nor FFmpeg reads as a whole, InputError when the file is gone.
    """
    try:
        with path.open("rb") as file:
            head = file.read(4096)
    except OSError as error:
        raise InputError(f"{path} cannot be read: {error.strerror}") from error
    if head[:4] == b"RIFF" and head[8:12] == b"WEBP":
        if b"ANIM" in head[12:64]:
            raise DecodeError(f"{path} is an animated WebP: convert it to a video first")
        return True
    if head.startswith(b"\x89PNG\r\n\x1a\n"):
        return b"acTL" not in head  # the mark of an animated PNG, which goes the way of videos
    return head.startswith(b"\xff\xd8\xff") and path.suffix.lower() not in (".mjpeg", ".mjpg")


def process_picture(
    src: Path,
    dst: Path,
    paint: Callable[[Frame], Frame],
    *,
    compare: bool = False,
    overwrite: bool = False,
    strict: bool = False,
    on_whole: Callable[[], None] | None = None,
) -> Report:
    """Paint one picture. EXIF (with its orientation), XMP and ICC profile are kept.

    compare: write it twice, as it was and painted, beside each other.  on_whole: as in Settings.
    Raises DecodeError, OutputError, UsageError, StrictError.
    """
    if dst.suffix.lower() not in _WRITERS:
        raise UsageError(
            f"{src} is a picture: the output must end in .jpg, .png or .webp, got {dst}"
        )
    target = Target(dst, src, overwrite=overwrite, on_whole=on_whole)
    try:
        report = _process(src, target, paint, compare, strict)
        target.keep()
    except BaseException:
        target.discard()
        raise
    report.output = str(dst)
    return report


def _process(
    src: Path, target: Target, paint: Callable[[Frame], Frame], compare: bool, strict: bool
) -> Report:
    suffix = target.part.suffix.lower()
    data = _bytes(src)
    stored, metadata = _decode(data, src)
    report = Report(str(src), "", _WRITERS[suffix], is_picture=True, frames_in=1, frames_out=1)
    frame = to_frame(stored, rotation_degrees=_rotation(metadata))
    before = [plane.copy() for plane in frame.planes]
    painted = merge(stored, paint(frame), before)
    if compare:
        untouched = stored if painted.shape == stored.shape else _with_colour(stored)
        painted = side_by_side(untouched, painted, _orientation(metadata))
    written = _encoded(target.part, _fitting(painted, report), metadata)
    report.bytes_in, report.bytes_out = len(data), len(written)
    with write_errors(target.part):
        target.own_path.write_bytes(written)
    report.dropped += _lost_metadata(written, target.part, metadata)
    if strict and (lost := report.dropped + report.conversions):
        raise StrictError(
            f"--strict: {suffix} cannot keep {'; '.join(lost)}. Use .png, or leave --strict out."
        )
    return report


def read_picture(path: Path) -> tuple[np.ndarray, dict[int, np.ndarray]]:
    """(stored pixels, metadata): (H, W, 1, 3 or 4) uint8 or uint16, BGR(A) order, encoded, not
    turned; metadata as OpenCV's {kind: bytes}. Raises InputError, DecodeError."""
    return _decode(_bytes(path), path)


def _bytes(path: Path) -> bytes:
    """Of a picture that is not too large."""
    try:
        data = read_ordinary(path, _MOST_BYTES)
    except OSError as error:
        raise InputError(f"{path} cannot be read: {error.strerror}") from error
    check_size(data, path)
    return data


def _decode(data: bytes, path: Path) -> tuple[np.ndarray, dict[int, np.ndarray]]:
    import cv2

    # our one line says what is wrong; OpenCV's own warnings would come on top
    cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)
    try:
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
    metadata = {
        int(kind): np.asarray(blob).ravel() for kind, blob in zip(kinds, blobs, strict=True)
    }
    if (xmp := metadata.get(int(cv2.IMAGE_METADATA_XMP))) is not None:
        plain = xmp.tobytes().removeprefix(_XMP_IN_JPEG)
        plain = plain[: plain.rfind(b">") + 1]  # OpenCV 5.0 reads a few bytes too many from PNG
        metadata[int(cv2.IMAGE_METADATA_XMP)] = np.frombuffer(plain, np.uint8)
    return pixels, metadata


def to_frame(stored: np.ndarray, rotation_degrees: int = 0) -> Frame:
    """The stored pixels as an 8-bit 4:4:4 full-range BT.709 frame with the transfer of sRGB."""
    eight = stored if stored.dtype == np.uint8 else (stored / 257 + 0.5).astype(np.uint8)
    bgr = np.repeat(eight[..., :1], 3, axis=2) if eight.shape[2] < 3 else eight[..., :3]
    picture = av.VideoFrame.from_ndarray(np.ascontiguousarray(bgr), format="bgr24").reformat(
        format="yuv444p", dst_colorspace=Colorspace.ITU709, dst_color_range=ColorRange.JPEG
    )
    picture.pts = 0
    return Frame(picture, 0, PICTURE_TICK, PICTURE_TAGS, rotation_degrees)


def merge(stored: np.ndarray, frame: Frame, before: list[np.ndarray]) -> np.ndarray:
    """The stored pixels, with those that differ from `before` converted back from the frame."""
    changed = np.zeros(stored.shape[:2], bool)
    for old, new in zip(before, frame.planes, strict=True):
        changed |= old != new
    if not changed.any():
        return stored
    bgr = frame.picture.reformat(
        format="bgr24", src_colorspace=Colorspace.ITU709, src_color_range=ColorRange.JPEG
    ).to_ndarray()
    out = stored if stored.shape[2] >= 3 else _with_colour(stored)
    scale = 1 if out.dtype == np.uint8 else 257
    out = out.copy()
    out[..., :3][changed] = bgr[changed].astype(out.dtype) * scale
    return out


def _encoded(path: Path, pixels: np.ndarray, metadata: dict[int, np.ndarray]) -> bytes:
    """BGR(A) pixels as a file, by the path's extension: JPEG at quality 95 in 4:4:4, WebP lossless,
    PNG. Raises OutputError."""
    import cv2

    suffix = path.suffix.lower()
    options = {
        ".png": [],
        ".webp": [cv2.IMWRITE_WEBP_QUALITY, 101],  # over 100 means lossless
    }.get(
        suffix,
        [
            cv2.IMWRITE_JPEG_QUALITY, 95,
            cv2.IMWRITE_JPEG_SAMPLING_FACTOR, cv2.IMWRITE_JPEG_SAMPLING_FACTOR_444,
        ],
    )  # fmt: skip
    try:
        data = _encode(suffix, pixels, metadata, options)
        if data is None:  # libpng refuses the whole picture for a malformed profile
            rest = {k: v for k, v in metadata.items() if k != cv2.IMAGE_METADATA_ICCP}
            data = _encode(suffix, pixels, rest, options)
    except cv2.error as error:
        raise OutputError(f"{path} cannot be encoded: {error.err}. Choose .png") from error
    if data is None:
        advice = "make it smaller" if suffix == ".png" else "choose .png"
        size = f"{pixels.shape[1]} x {pixels.shape[0]} px"
        raise OutputError(f"{path}: {size} cannot be encoded as {suffix}: {advice}")
    return data


def _encode(
    suffix: str, pixels: np.ndarray, metadata: dict[int, np.ndarray], options: list[int]
) -> bytes | None:
    import cv2

    blobs = dict(metadata)
    xmp = int(cv2.IMAGE_METADATA_XMP)
    if suffix in (".jpg", ".jpeg") and xmp in blobs:
        blobs[xmp] = np.concatenate([np.frombuffer(_XMP_IN_JPEG, np.uint8), blobs[xmp]])
    ok, data = cv2.imencodeWithMetadata(suffix, pixels, list(blobs), list(blobs.values()), options)
    return data.tobytes() if ok else None


def _with_colour(grey: np.ndarray) -> np.ndarray:
    """(H, W, 1 or 2) -> BGR or BGRA."""
    colour = np.repeat(grey[..., :1], 3, axis=2)
    return np.concatenate([colour, grey[..., 1:]], axis=2)


def _fitting(pixels: np.ndarray, report: Report) -> np.ndarray:
    """What the output format can hold: PNG everything, WebP 8 bits, JPEG 8 bits and no alpha."""
    name = {"jpeg": "JPEG", "webp": "WebP"}.get(report.codec)
    if name is None:
        return pixels
    if pixels.dtype != np.uint8:
        report.conversions.append(f"16 bits -> 8 bits ({name})")
        pixels = (pixels / 257 + 0.5).astype(np.uint8)
    if pixels.shape[2] == 4 and name == "JPEG":
        report.dropped.append("transparency: JPEG has none; laid on white (use .png to keep it)")
        weight = pixels[..., 3:] / 255
        pixels = (pixels[..., :3] * weight + 255 * (1 - weight) + 0.5).astype(np.uint8)
    return pixels


def _lost_metadata(data: bytes, path: Path, metadata: dict[int, np.ndarray]) -> list[str]:
    """Blocks that the format's library left out, a malformed ICC profile for one."""
    kept = _decode(data, path)[1] if metadata else {}
    return [
        f"{_KINDS[kind]}: not accepted in {path.suffix}" for kind in metadata if kind not in kept
    ]


def _rotation(metadata: dict[int, Any]) -> int:
    """Counter-clockwise degrees to upright."""
    return _UPRIGHT_DEGREES.get(_orientation(metadata), 0)


def _orientation(metadata: dict[int, Any]) -> int:
    """1 to 8 from EXIF (TIFF structure, Exif 2.32 section 4.6), 1 when it does not say."""
    import cv2

    blob = metadata.get(int(cv2.IMAGE_METADATA_EXIF))
    if blob is None:
        return 1
    data = np.asarray(blob, np.uint8).tobytes().removeprefix(b"Exif\0\0")
    if data[:2] not in (b"II", b"MM"):
        return 1
    order: Literal["little", "big"] = "little" if data[:2] == b"II" else "big"
    at = int.from_bytes(data[4:8], order)
    for entry in range(int.from_bytes(data[at : at + 2], order)):
        field = data[at + 2 + 12 * entry : at + 14 + 12 * entry]
        if int.from_bytes(field[:2], order) == _EXIF_TAG_ORIENTATION:
            return int.from_bytes(field[8:10], order)
    return 1
