"""Colour tags of a frame, and the Coding that they mean, with missing tags filled in.

The maths is in kernels/colour.py, beside its OpenCL twin.
"""

from dataclasses import dataclass
from functools import lru_cache

import av
from makeup_video.kernels.colour import HDR_TRANSFERS, LUMA_WEIGHTS, PRIMARIES, SRGB, Coding
from makeup_video.pipeline.errors import UsageError

FULL_RANGE = 2  # of `range`
_UNSPECIFIED = 2  # of matrix, transfer and primaries
# BT.2020 constant luminance counts as BT.2020: no encoder that we know of writes it.
_SAME = {10: 9}


@dataclass(frozen=True, slots=True)
class ColourTags:
    """How a frame's codes encode colour: code points of ITU-T H.273, as in FFmpeg.

    matrix: 1 BT.709, 5 and 6 BT.601, 9 BT.2020, 2 unspecified.
    range: 1 limited ("MPEG", 16..235), 2 full ("JPEG", 0..255), 0 unspecified.
    transfer: 1 BT.709, 13 sRGB (IEC 61966-2-1), 16 PQ, 18 HLG, 2 unspecified.
    primaries: 1 BT.709, 9 BT.2020, 12 Display P3, 2 unspecified.
    """

    matrix: int = 2
    range: int = 0
    transfer: int = 2
    primaries: int = 2

    @classmethod
    def of(cls, picture: av.VideoFrame) -> "ColourTags":
        """The tags of a picture, or of a codec context, whose fields have the same names."""
        return cls(
            int(picture.colorspace),
            int(picture.color_range),
            int(picture.color_trc),
            int(picture.color_primaries),
        )

    def complete(self, picture: av.VideoFrame) -> None:
        """Give a picture these tags where it has none of its own."""
        if picture.colorspace == _UNSPECIFIED:
            picture.colorspace = self.matrix
        if picture.color_range == 0:
            picture.color_range = self.range
        if picture.color_trc == _UNSPECIFIED:
            picture.color_trc = self.transfer
        if picture.color_primaries == _UNSPECIFIED:
            picture.color_primaries = self.primaries

    @property
    def is_hdr(self) -> bool:
        """True for the transfer functions PQ and HLG."""
        return self.transfer in HDR_TRANSFERS


def is_full_range(range_: int, pix_fmt: str) -> bool:
    """True where the tag says full range, or the name of the pixel format does: "yuvj420p"."""
    return range_ == FULL_RANGE or pix_fmt.startswith("yuvj")


@lru_cache
def resolve(tags: ColourTags, width_px: int, height_px: int, bit_depth: int) -> Coding:
    """The coding that the tags mean, with every missing tag filled in.

    Matrix: BT.2020 for BT.2020 primaries, PQ and HLG; else by size, as players do: BT.709 from 1280
    px of width or 577 lines on, BT.601 below.
    Range: limited.
    Transfer: everything but PQ and HLG counts as sRGB.
    Primaries: BT.2020 with its matrix, else BT.709.

    Raises UsageError for matrices that cannot be painted on (ICtCp, YCgCo).
    """
    hdr = tags.is_hdr
    matrix = _SAME.get(tags.matrix, tags.matrix)
    if matrix == _UNSPECIFIED:
        wide = hdr or tags.primaries == 9
        matrix = 9 if wide else 1 if width_px >= 1280 or height_px > 576 else 6
    if matrix not in LUMA_WEIGHTS:
        raise UsageError(
            f"cannot paint on colours of matrix {tags.matrix} (ITU-T H.273), only on "
            f"{', '.join(map(str, LUMA_WEIGHTS))}: convert the video to BT.709 first"
        )
    primaries = tags.primaries
    if primaries not in PRIMARIES:
        primaries = 9 if matrix == 9 else 1
    return Coding(
        matrix, tags.range == FULL_RANGE, tags.transfer if hdr else SRGB, primaries, bit_depth
    )
