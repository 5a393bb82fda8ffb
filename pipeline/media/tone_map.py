"""Maps HDR colours to SDR: the tone curve of ITU-R BT.2390, and BT.2020's gamut into BT.709's.

Light is counted in units of HDR reference white, 203 cd/m2 (ITU-R BT.2408), which is also the white
of the SDR picture. Light below about half of white keeps its brightness; everything from there to
the peak of the HDR picture is rolled off into the rest.
"""

import numpy as np
from makeup_video.kernels.colour import (
    PQ,
    PQ_PEAK,
    REFERENCE_WHITE,
    SRGB,
    from_srgb_primaries,
    to_encoded,
    to_linear,
    to_xyz,
)

_SRGB_PRIMARIES = 1  # BT.709 has the same
_DARK = 1e-9  # avoids a division of black by black


def tone_curve(light: np.ndarray, peak: float) -> np.ndarray:
    """Map light 0..peak to 0..1: the EETF of ITU-R BT.2390-11, section 5.4, black to black.

    light, peak: in units of 203 cd/m2. A peak of at most 1 leaves everything as it is.
    """
    if peak <= 1:
        return np.asarray(np.minimum(light, 1.0))
    top, white = to_encoded(np.array([peak, 1.0]), PQ)
    signal = np.clip(to_encoded(light, PQ) / top, 0, 1)
    largest = white / top
    knee = 1.5 * largest - 0.5
    t = np.clip((signal - knee) / (1 - knee), 0, 1)
    # the Hermite spline of BT.2390: from slope 1 at the knee to slope 0 at the largest value
    rolled = (
        (2 * t**3 - 3 * t**2 + 1) * knee
        + (t**3 - 2 * t**2 + t) * (1 - knee)
        + (3 * t**2 - 2 * t**3) * largest
    )
    curve: np.ndarray = to_linear(np.where(signal < knee, signal, rolled) * top, PQ)
    return curve


def to_sdr(rgb: np.ndarray, transfer: int, primaries: int, peak: float) -> np.ndarray:
    """Map R'G'B' (..., 3) of PQ or HLG to R'G'B' (..., 3) of sRGB in BT.709's primaries, both 0..1.

    transfer, primaries: code points of ITU-T H.273.  peak: of the HDR picture, in units of
    203 cd/m2. The curve is applied to the largest of red, green and blue, so hues stay. Colours
    outside BT.709 move towards grey of the same luminance until they fit.
    """
    light = np.maximum(to_linear(rgb, transfer), 0)
    largest = light.max(-1, keepdims=True)
    light = light * (tone_curve(largest, peak) / np.maximum(largest, _DARK))
    light = light @ np.linalg.inv(from_srgb_primaries(primaries)).T
    return to_encoded(_into_gamut(light), SRGB)


def _into_gamut(light: np.ndarray) -> np.ndarray:
    """Desaturate light (..., 3) in BT.709's primaries until it is in 0..1."""
    grey = np.clip(light @ to_xyz(_SRGB_PRIMARIES)[1], 0, 1)[..., None]
    below, above = light.min(-1, keepdims=True), light.max(-1, keepdims=True)
    keep_below = np.where(below < 0, grey / np.maximum(grey - below, _DARK), 1)
    keep_above = np.where(above > 1, (1 - grey) / np.maximum(above - grey, _DARK), 1)
    kept: np.ndarray = grey + np.minimum(keep_below, keep_above) * (light - grey)
    return np.asarray(np.clip(kept, 0, 1))


def sdr_table(size: int, transfer: int, primaries: int, peak: float) -> np.ndarray:
    """`to_sdr` of an even grid over 0..1: (size**3, 3), red running fastest, as in .cube files."""
    axis = np.linspace(0, 1, size)
    blue, green, red = np.meshgrid(axis, axis, axis, indexing="ij")
    return to_sdr(np.stack([red, green, blue], -1), transfer, primaries, peak).reshape(-1, 3)


def peak_of(max_content_nits: float | None, max_display_nits: float | None) -> float:
    """The peak of a picture by its HDR10 metadata, in units of 203 cd/m2.

    The brightest pixel (MaxCLL), if it is declared and at least white; else the peak of the display
    on which the video was graded; else the 1000 cd/m2 of most videos and of HLG.
    """
    for nits in (max_content_nits, max_display_nits):
        if nits and REFERENCE_WHITE <= nits <= PQ_PEAK:
            return nits / REFERENCE_WHITE
    return 1000 / REFERENCE_WHITE
