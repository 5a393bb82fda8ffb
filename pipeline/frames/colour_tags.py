"""Frame -> Coding: what its colour tags mean, and what players make of those that are missing.

The maths is in kernels/colour.py, beside its OpenCL twin: kernels may not import from here.
"""

from makeup_video.kernels.colour import HLG, LUMA_WEIGHTS, PQ, PRIMARIES, SRGB, Coding
from makeup_video.pipeline.errors import UsageError
from makeup_video.pipeline.frame import ColourTags, Frame

_SAME = {10: 9}  # BT.2020 constant luminance -> BT.2020: no encoder we know of writes it
_FULL = 2


def coding_of(frame: Frame) -> Coding:
    """The coding of a frame's codes. Raises UsageError as `resolve` does."""
    return resolve(frame.tags, frame.width_px, frame.height_px, frame.bit_depth)


def resolve(tags: ColourTags, width_px: int, height_px: int, bit_depth: int) -> Coding:
    """Close every gap in the tags.

    Matrix: BT.2020 for BT.2020 primaries, PQ and HLG; else by size, as players do: BT.709 from
    1280 px of width or from 577 lines on, BT.601 below. Range: limited. Transfer: anything that is
    neither PQ nor HLG counts as sRGB. Primaries: BT.2020 with its matrix, else BT.709.
    Raises UsageError for Y'CbCr that is no linear mix of R'G'B' (ICtCp, YCgCo).
    """
    hdr = tags.transfer in (PQ, HLG)
    matrix = _SAME.get(tags.matrix, tags.matrix)
    if matrix == 2:
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
    return Coding(matrix, tags.range == _FULL, tags.transfer if hdr else SRGB, primaries, bit_depth)
