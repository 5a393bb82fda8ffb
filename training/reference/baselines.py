"""A baseline: moves the mean colour of the lips or lids to that of the reference."""

import warnings

import numpy as np
from skimage.color import lab2rgb, rgb2lab


def transfer_mean_colour(
    reference: np.ndarray, worn: np.ndarray, source: np.ndarray, weight: np.ndarray
) -> np.ndarray:
    """The source with the mean Lab of the reference in its region; its own detail is kept.

    reference, source: (H, W, 3) uint8, sRGB-encoded. worn, weight: (H, W) in [0, 1], the region in
    the reference and in the source. Unchanged when the reference does not show the region.
    """
    inside = weight > 0
    if not inside.any() or worn.sum() == 0:
        return source.copy()
    lab, share = rgb2lab(source[inside]), weight[inside, None]
    shift = _mean(rgb2lab(reference[worn > 0]), worn[worn > 0, None]) - _mean(lab, share)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # about colours beyond sRGB, which are clipped
        moved = 255 * lab2rgb(lab + shift)
    out = source.copy()
    out[inside] = np.rint(source[inside] + share * (moved - source[inside])).clip(0, 255)
    return out


def _mean(lab: np.ndarray, share: np.ndarray) -> np.ndarray:
    mean: np.ndarray = (lab * share).sum(0) / share.sum()
    return mean
