"""Converts the planes of a frame for a browser: 8 bits, no larger than a page, as sRGB.

Each plane is converted at its own size, in Y'CbCr, so the frame never becomes RGB.
"""

from functools import lru_cache
from typing import NamedTuple

import cv2
import numpy as np
from makeup_video.kernels.colour import SRGB, Coding, matrices
from makeup_video.pipeline.frames.colour_tags import ColourTags, resolve
from makeup_video.pipeline.frames.sampling import halved
from makeup_video.pipeline.images.hdr_preview import JFIF, standard

# Pictures with a longer side are halved. No page is wider, and 2160p at full size takes three times
# as long.
LIMIT_PX = 2560
# Limited-range BT.709 with sRGB's curve: decoders that ignore a stream's tags assume BT.709.
VIDEO = Coding(1, False)
_FINE = 2  # what chroma adds to luma is stored in halves of a code; it stays below 64 codes
Planes = tuple[np.ndarray, ...] | list[np.ndarray]


def preview_planes(
    planes: Planes,
    chroma: tuple[int, int],
    bit_depth: int,
    tags: ColourTags,
    to: Coding,
    limit_px: int = LIMIT_PX,
) -> list[np.ndarray]:
    """Convert planes, as in Frame.planes, to another coding in 8 bits.

    chroma, bit_depth, tags: the frame's.  to: JFIF or VIDEO.
    limit_px: the picture is halved until no side is longer.
    Returns luma, (H, W) uint8, and Cb and Cr in the frame's subsampling; luma alone for a grey
    frame. Planes that need no change are returned as they were given.
    Raises UsageError for codes that are no linear mix of R'G'B', as `colour_tags.resolve` does.
    """
    height, width = planes[0].shape
    coding = resolve(tags, width, height, bit_depth)
    luma, *rest = _smaller(planes[:3], chroma, limit_px)
    if rest and rest[0].ndim == 3:  # NV12 keeps Cb and Cr in one plane
        rest = list(cv2.split(rest[0]))
    if coding.transfer != SRGB:
        luma, *rest = standard(luma, rest, coding)
        coding = JFIF
    return _mixed(luma, rest, coding, to)


def _smaller(planes: Planes, chroma: tuple[int, int], limit_px: int) -> list[np.ndarray]:
    """Planes halved until no side is longer; odd sizes lose their last row or column."""
    planes = list(planes)
    while max(planes[0].shape) > limit_px:
        across, down = chroma
        high, wide = (
            size // (2 * by) * 2 for size, by in zip(planes[0].shape, (down, across), strict=True)
        )
        if not high or not wide:
            break
        luma, *rest = planes
        planes = [halved(luma[: high * down, : wide * across])]
        planes += [halved(plane[:high, :wide]) for plane in rest]
    return planes


class _Mix(NamedTuple):
    """How a frame's codes become codes of another coding: factors, then a constant to add.

    luma: (factor of luma, constant).
    lift, blue, red: (factor of Cb, factor of Cr, constant) of what chroma adds to luma, of the new
    Cb, and of the new Cr. The lift is in units of 1 / _FINE code, and 128 stands for 0.
    """

    luma: tuple[float, float]
    lift: tuple[float, float, float]
    blue: tuple[float, float, float]
    red: tuple[float, float, float]


@lru_cache
def _mix(coding: Coding, to: Coding) -> _Mix | None:
    """The mix from one coding to another; None when the codes stay as they are."""
    to_rgb, _ = matrices(coding)
    _, to_codes = matrices(to)
    mix = to_codes[:, :3] @ to_rgb[:, :3]
    added = to_codes[:, :3] @ to_rgb[:, 3] + to_codes[:, 3]
    if coding.bit_depth == 8 and np.allclose(mix, np.eye(3)) and np.allclose(added, 0, atol=1e-9):
        return None
    (scale, *lift), (_, *blue), (_, *red) = mix.round(9).tolist()
    neutral = sum(lift) * 2.0 ** (coding.bit_depth - 1)  # what neutral chroma would add
    return _Mix(
        (scale, added[0] + neutral),
        (lift[0] * _FINE, lift[1] * _FINE, 128 - neutral * _FINE),
        (*blue, added[1]),
        (*red, added[2]),
    )


def _mixed(
    luma: np.ndarray, chroma: list[np.ndarray], coding: Coding, to: Coding
) -> list[np.ndarray]:
    """8-bit planes in another coding; the given planes when they already have that coding."""
    mix = _mix(coding, to)
    if mix is None:
        return [luma, *chroma]
    scale, added = mix.luma
    if not chroma:
        return [_sum(luma, scale, luma, 0, added)]
    cb, cr = chroma
    if not any(mix.lift[:2]):
        bright = _sum(luma, scale, luma, 0, added)
    else:
        # linear interpolation, as viewers use to enlarge chroma
        lift = cv2.resize(_plane_sum(cb, cr, mix.lift), luma.shape[::-1])
        bright = _sum(luma, scale, lift, 1 / _FINE, added - 128 / _FINE)
    return [bright, _plane_sum(cb, cr, mix.blue), _plane_sum(cb, cr, mix.red)]


def _plane_sum(cb: np.ndarray, cr: np.ndarray, mix: tuple[float, float, float]) -> np.ndarray:
    return _sum(cb, mix[0], cr, mix[1], mix[2])


def _sum(a: np.ndarray, of_a: float, b: np.ndarray, of_b: float, added: float) -> np.ndarray:
    """The weighted sum of two planes, rounded and clipped to 8 bits.

    OpenCV has nothing quicker, even for a single plane.
    """
    return np.asarray(cv2.addWeighted(a, of_a, b, of_b, added, dtype=cv2.CV_8U))
