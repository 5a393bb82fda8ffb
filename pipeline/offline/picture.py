"""Paints a picture file and keeps its metadata.

The picture becomes a Frame (4:4:4, full range) for the painter. Pixels that are not painted keep
their exact values, whatever the depth of the file: planes are compared before and after, and only
what changed is converted back.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from makeup_video.pipeline.errors import UsageError, cannot_keep
from makeup_video.pipeline.files.output_file import OutputFile, write_errors
from makeup_video.pipeline.frames.frame import Frame
from makeup_video.pipeline.frames.orientation import Orientation
from makeup_video.pipeline.frames.rgb import (
    P3_PICTURE_TAGS,
    PICTURE_TAGS,
    as_uint8,
    merge,
    to_frame,
    with_colour,
)
from makeup_video.pipeline.images.exif import orientation, without_thumbnail
from makeup_video.pipeline.images.file_tags import FileTags, file_tags, with_file_tags
from makeup_video.pipeline.images.heif import bit_depth, is_heif
from makeup_video.pipeline.images.icc import is_display_p3
from makeup_video.pipeline.images.picture_file import (
    EXIF,
    ICC_PROFILE,
    WRITERS,
    Metadata,
    decode_picture,
    encode_picture,
    is_exif_too_long,
    read_bytes,
)
from makeup_video.pipeline.media.side_by_side import side_by_side
from makeup_video.pipeline.offline.report import Report
from makeup_video.pipeline.offline.settings import Settings


@dataclass(frozen=True, slots=True)
class OpenedPicture:
    """A picture file that was read.

    stored, metadata: as decode_picture returns them.  frame: the same pixels for the painter.
    tags: what else the file holds.  bytes_in: size of the file.
    depth: bits per sample in the file; `stored` has 16 bits for deep photos.
    """

    path: Path
    stored: np.ndarray
    metadata: Metadata
    orientation: Orientation
    frame: Frame
    tags: FileTags
    bytes_in: int
    depth: int


def open_picture(path: Path) -> OpenedPicture:
    """Read a picture. Raises InputError, DecodeError."""
    data = read_bytes(path)
    stored, metadata = decode_picture(data, path)
    stored_as = orientation(metadata.get(EXIF))
    profile = metadata.get(ICC_PROFILE)
    is_wide = profile is not None and is_display_p3(profile)
    tags = P3_PICTURE_TAGS if is_wide else PICTURE_TAGS
    frame = to_frame(stored, stored_as, tags)
    depth = bit_depth(data) if is_heif(data) else 8 * stored.itemsize
    return OpenedPicture(
        path, stored, metadata, stored_as, frame, file_tags(data), len(data), depth
    )


def check_suffix(src: Path, dst: Path) -> None:
    """Raises UsageError for an output whose name is not that of a picture."""
    if dst.suffix.lower() not in WRITERS:
        is_bare = dst.name.lower() in WRITERS  # a hidden file, to Python and to shells
        raise UsageError(
            f"{src} is a picture: the output must end in .jpg, .png or .webp, got "
            f"{dst.suffix or dst.name}{' without a name before it' if is_bare else ''}"
        )


def process_picture(
    src: Path, dst: Path, paint: Callable[[Frame], Frame], settings: Settings
) -> Report:
    """Paint one picture and keep its EXIF (with the orientation), XMP, ICC profile and file tags.

    Raises InputError, DecodeError, OutputError, UsageError, StrictError.
    """
    check_suffix(src, dst)
    target = OutputFile(dst, src, overwrite=settings.overwrite, on_whole=settings.on_whole)
    with target:
        picture = open_picture(src)
        before = [plane.copy() for plane in picture.frame.planes]
        return _write(picture, dst, target, paint(picture.frame), before, settings)


def write_picture(picture: OpenedPicture, dst: Path, painted: Frame, settings: Settings) -> Report:
    """Write a painted copy of the picture's frame, with the picture's metadata.

    `on_whole` of the settings is not called: there may be more copies to write.
    Raises OutputError, UsageError, StrictError.
    """
    with OutputFile(dst, picture.path, overwrite=settings.overwrite) as target:
        return _write(picture, dst, target, painted, picture.frame.planes, settings)


def _write(
    picture: OpenedPicture,
    dst: Path,
    target: OutputFile,
    frame: Frame,
    before: Sequence[np.ndarray],
    settings: Settings,
) -> Report:
    """Write the painted frame as a picture to an open output.

    dst: the output's name for the report.  before: the planes of the frame before painting.
    """
    suffix, stored = target.part.suffix.lower(), picture.stored
    codec = WRITERS[suffix]
    report = Report(str(picture.path), str(dst), codec, is_picture=True, frames_in=1, frames_out=1)
    painted = merge(stored, frame, before)
    if settings.compare:
        untouched = stored if painted.shape == stored.shape else with_colour(stored)
        painted = side_by_side(untouched, painted, picture.orientation)
    is_grey = painted.shape[2] < 3
    if is_grey and codec == "webp":  # which holds no grey
        painted = with_colour(painted)
    metadata = _of_these_colours(_without_thumbnail(picture.metadata), painted, report)
    report.conversions += picture.tags.conversions
    if stored.shape[2] < 3 <= painted.shape[2]:
        report.conversions.append("grey -> RGB")
    is_lost = bool(report.dropped or report.conversions)
    # a PNG could hold grey; everything else noted so far would be lost in a PNG, too
    is_lost_in_png = (is_lost and not is_grey) or _loses_tags(picture.tags)
    written = encode_picture(target.part, _fitting(painted, picture.depth, report), metadata)
    report.dropped += _lost_metadata(written, target.part, metadata)
    written, lost_tags = with_file_tags(written, codec, picture.tags)
    report.dropped += lost_tags
    report.bytes_in, report.bytes_out = picture.bytes_in, len(written)
    with write_errors(target.part):
        target.own_path.write_bytes(written)
    if settings.strict and (lost := report.dropped + report.conversions):
        advice = "Leave" if suffix == ".png" or is_lost_in_png else "Use .png, or leave"
        raise cannot_keep(suffix, "; ".join(lost), advice)
    return report


def _loses_tags(tags: FileTags) -> bool:
    """True for tags that a PNG cannot hold."""
    return bool(tags.lost or (tags.names and tags.kind != "png"))


def _fitting(pixels: np.ndarray, depth: int, report: Report) -> np.ndarray:
    """Pixels that the output format can hold: PNG all, WebP 8 bits, JPEG 8 bits without alpha.

    depth: bits per sample of the source, for the report.
    """
    name = {"jpeg": "JPEG", "webp": "WebP"}.get(report.codec)
    if name is None:
        return pixels
    if pixels.dtype != np.uint8:
        report.conversions.append(f"{depth} bits -> 8 bits ({name})")
        pixels = as_uint8(pixels)
    if pixels.shape[2] == 4 and name == "JPEG":
        report.dropped.append("transparency: JPEG has none; laid on white (use .png to keep it)")
        weight = pixels[..., 3:] / 255
        pixels = (pixels[..., :3] * weight + 255 * (1 - weight) + 0.5).astype(np.uint8)
    return pixels


def _without_thumbnail(metadata: Metadata) -> Metadata:
    if EXIF not in metadata:
        return metadata
    return metadata | {EXIF: without_thumbnail(metadata[EXIF])}


def _of_these_colours(metadata: Metadata, pixels: np.ndarray, report: Report) -> Metadata:
    """The metadata, without an ICC profile for other colours than those of the pixels.

    CMYK is read as RGB, and a grey picture that is painted, or written as WebP, becomes RGB.
    """
    # the data colour space (ICC.1:2022, section 7.2.8)
    found = metadata.get(ICC_PROFILE, b"")[16:20]
    if found != b"CMYK" and (found != b"GRAY" or pixels.shape[2] < 3):
        return metadata
    report.dropped.append(
        f"{ICC_PROFILE}: it is of {found.decode()}, and the picture is written as RGB"
    )
    return {kind: blob for kind, blob in metadata.items() if kind != ICC_PROFILE}


def _lost_metadata(data: bytes, path: Path, metadata: Metadata) -> list[str]:
    """Blocks that the format's library left out, such as a malformed ICC profile.

    The file is decoded for that: reading its headers alone would find blocks, such as a malformed
    EXIF block of a PNG, that libpng refuses.
    """
    kept = decode_picture(data, path)[1] if metadata else {}
    lost = {kind for kind in metadata if kind not in kept}
    if EXIF in metadata and is_exif_too_long(path.suffix, metadata[EXIF]):
        lost.add(EXIF)
    return [f"{kind}: not accepted in {path.suffix}" for kind in metadata if kind in lost]
