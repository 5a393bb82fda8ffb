"""Measures how much the upper lids of a photo shimmer: by how far fine highlights stand out.

On lids the light of powder is even, while what shimmers has bright specks and edges. They are
compared with the lid around them and with the lid as a whole, or the gaps between dark lashes would
count.
"""

import cv2
import numpy as np
from makeup_video.kernels.colour import SRGB, to_linear
from makeup_video.pipeline.reference.flat_lids import flat_heights, flat_places_across
from makeup_video.pipeline.reference.neutral_face import LUMINANCE

_HEIGHTS = 0.25, 1.8  # of the skin that counts: lash line 0, crease 1, fold 2
_BESIDE = 0.42  # how far from the eye's middle it goes on, in widths of the eye
_FINE_PX = 1.5  # sigma of the blur that takes what is fine away
_DARK = 0.01  # light, linear, below which differences do not count
_PERCENTILE = 95
# What is measured, in logarithms of light, and how strong the shimmer is that is painted for it: by
# what people say of the lids of photos, and of painted ones.
_MEASURED = (0.12, 0.2, 0.3)
_SHIMMER = (0.0, 0.4, 1.0)


def lid_shimmer(lids: np.ndarray) -> float:
    """How strong the shimmer of eyeshadow is, 0..1.

    lids: (64, 160, 3) uint8, R'G'B', both lids laid flat, as of flat_lids.
    """
    return float(np.interp(fine_highlights(lids), _MEASURED, _SHIMMER))


def fine_highlights(lids: np.ndarray) -> float:
    """By how much fine highlights are brighter than the lid, in logarithms of light.

    lids: as of lid_shimmer.
    """
    light = np.log(to_linear(lids / 255, SRGB) @ LUMINANCE + _DARK).astype(np.float32)
    low, high = _HEIGHTS
    rows, columns = flat_heights(), np.abs(flat_places_across())
    there = np.ix_((rows > low) & (rows < high), columns < _BESIDE)
    around = np.maximum(cv2.GaussianBlur(light, (0, 0), _FINE_PX), np.median(light[there]))
    return float(np.percentile((light - around)[there], _PERCENTILE))
