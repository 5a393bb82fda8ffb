"""Paints one picture file and keeps its metadata.

The picture becomes a Frame (4:4:4, full range) for the painter. Pixels that are not painted keep
their exact values, whatever the depth of the file: planes are compared before and after, and only
what changed is converted back.
"""

from collections.abc import Callable
from pathlib import Path

import numpy as np
from makeup_video.pipeline.errors import StrictError, UsageError, option
from makeup_video.pipeline.files.output_file import OutputFile, write_errors
from makeup_video.pipeline.frames.frame import Frame
from makeup_video.pipeline.frames.rgb import merge, to_frame, with_colour
from makeup_video.pipeline.images.exif import orientation
from makeup_video.pipeline.images.picture_file import (
    WRITERS,
    decode_picture,
    encode_picture,
    read_bytes,
)
from makeup_video.pipeline.media.side_by_side import side_by_side
from makeup_video.pipeline.offline.report import Report

_KINDS = ("EXIF", "XMP", "ICC profile")  # in the order of OpenCV's numbers


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
    """Paint one picture and keep its EXIF (with the orientation), XMP and ICC profile.

    compare: write the picture as it was and as painted, beside each other.  on_whole: as in
    Settings.
    Raises DecodeError, OutputError, UsageError, StrictError.
    """
    if dst.suffix.lower() not in WRITERS:
        raise UsageError(
            f"{src} is a picture: the output must end in .jpg, .png or .webp, got {dst}"
        )
    target = OutputFile(dst, src, overwrite=overwrite, on_whole=on_whole)
    try:
        report = _process(src, target, paint, compare, strict)
        target.keep()
    except BaseException:
        target.discard()
        raise
    report.output = str(dst)
    return report


def _process(
    src: Path, target: OutputFile, paint: Callable[[Frame], Frame], compare: bool, strict: bool
) -> Report:
    suffix = target.part.suffix.lower()
    data = read_bytes(src)
    stored, metadata = decode_picture(data, src)
    report = Report(str(src), "", WRITERS[suffix], is_picture=True, frames_in=1, frames_out=1)
    stored_as = orientation(metadata)
    frame = to_frame(stored, rotation_degrees=stored_as.turn_degrees)
    before = [plane.copy() for plane in frame.planes]
    painted = merge(stored, paint(frame), before)
    if compare:
        untouched = stored if painted.shape == stored.shape else with_colour(stored)
        painted = side_by_side(untouched, painted, stored_as)
    written = encode_picture(target.part, _fitting(painted, report), metadata)
    report.bytes_in, report.bytes_out = len(data), len(written)
    with write_errors(target.part):
        target.own_path.write_bytes(written)
    report.dropped += _lost_metadata(written, target.part, metadata)
    if strict and (lost := report.dropped + report.conversions):
        raise StrictError(
            f"{option('strict')}: {suffix} cannot keep {'; '.join(lost)}. Use .png, or leave "
            f"{option('strict')} out."
        )
    return report


def _fitting(pixels: np.ndarray, report: Report) -> np.ndarray:
    """Pixels that the output format can hold: PNG all, WebP 8 bits, JPEG 8 bits without alpha."""
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
    """Blocks that the format's library left out, such as a malformed ICC profile."""
    kept = decode_picture(data, path)[1] if metadata else {}
    return [
        f"{_KINDS[kind]}: not accepted in {path.suffix}" for kind in metadata if kind not in kept
    ]
