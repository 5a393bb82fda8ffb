"""How different two colours look: CIEDE2000, on arrays.

G. Sharma, W. Wu, E. N. Dalal, "The CIEDE2000 Color-Difference Formula: Implementation Notes,
Supplementary Test Data, and Mathematical Observations", Color Res. Appl. 30(1), 2005. Names are
theirs; the weights kL, kC, kH are 1.
"""

import numpy as np
from makeup_video.kernels.colour import SRGB, to_linear, to_xyz

_TO_XYZ = to_xyz(1)  # sRGB's primaries, white is D65
_WHITE = _TO_XYZ.sum(1)
_FROM_XYZ = np.linalg.inv(_TO_XYZ)
_FAR = 25.0**7
_NEAR_BLACK = 6 / 29  # of the cube root, below which L*a*b* is linear


def lab_of(rgb: np.ndarray) -> np.ndarray:
    """sRGB codes 0..255 (..., 3) -> CIE L*a*b* (..., 3) for D65, float64."""
    return lab_of_linear(to_linear(np.asarray(rgb, np.float64) / 255, SRGB))


def lab_of_linear(rgb: np.ndarray) -> np.ndarray:
    """Linear R, G, B of sRGB (..., 3), 1 is white -> CIE L*a*b* (..., 3) for D65, float64."""
    t = np.asarray(rgb, np.float64) @ _TO_XYZ.T / _WHITE
    near_black = t <= _NEAR_BLACK**3
    f = np.where(near_black, t / (3 * _NEAR_BLACK**2) + 4 / 29, np.cbrt(t))
    x, y, z = np.moveaxis(f, -1, 0)
    return np.stack([116 * y - 16, 500 * (x - y), 200 * (y - z)], -1)


def linear_of_lab(lab: np.ndarray) -> np.ndarray:
    """The inverse of lab_of_linear; colours outside the gamut are below 0 or above 1."""
    lightness, a, b = np.moveaxis(np.asarray(lab, np.float64), -1, 0)
    y = (lightness + 16) / 116
    f = np.stack([y + a / 500, y, y - b / 200], -1)
    t = np.where(f <= _NEAR_BLACK, (f - 4 / 29) * (3 * _NEAR_BLACK**2), f**3)
    linear: np.ndarray = (t * _WHITE) @ _FROM_XYZ.T
    return linear


def ciede2000(lab1: np.ndarray, lab2: np.ndarray) -> np.ndarray:
    """Delta E00 of CIE L*a*b* colours (..., 3), which may be broadcast; about 1 is just visible."""
    L1, a1, b1 = np.moveaxis(np.asarray(lab1, np.float64), -1, 0)
    L2, a2, b2 = np.moveaxis(np.asarray(lab2, np.float64), -1, 0)
    C_bar7 = ((np.hypot(a1, b1) + np.hypot(a2, b2)) / 2) ** 7
    G = 0.5 * (1 - np.sqrt(C_bar7 / (C_bar7 + _FAR)))
    a1, a2 = (1 + G) * a1, (1 + G) * a2
    C1, C2 = np.hypot(a1, b1), np.hypot(a2, b2)
    h1, h2 = np.degrees(np.arctan2(b1, a1)) % 360, np.degrees(np.arctan2(b2, a2)) % 360

    no_hue = C1 * C2 == 0
    dh = (h2 - h1 + 180) % 360 - 180
    # at exactly half a turn the sign is the paper's: that of h2 - h1
    dh = np.where(np.abs(h2 - h1) == 180, h2 - h1, dh)
    dh = np.where(no_hue, 0, dh)
    dL, dC = L2 - L1, C2 - C1
    dH = 2 * np.sqrt(C1 * C2) * np.sin(np.radians(dh / 2))

    L, C = (L1 + L2) / 2, (C1 + C2) / 2
    h = (h1 + h2) / 2
    h = np.where(np.abs(h1 - h2) <= 180, h, np.where(h1 + h2 < 360, h + 180, h - 180))
    h = np.where(no_hue, h1 + h2, h)
    T = (
        1
        - 0.17 * np.cos(np.radians(h - 30))
        + 0.24 * np.cos(np.radians(2 * h))
        + 0.32 * np.cos(np.radians(3 * h + 6))
        - 0.20 * np.cos(np.radians(4 * h - 63))
    )
    off = (L - 50) ** 2
    S_L = 1 + 0.015 * off / np.sqrt(20 + off)
    S_C, S_H = 1 + 0.045 * C, 1 + 0.015 * C * T
    turn = np.radians(60 * np.exp(-(((h - 275) / 25) ** 2)))
    R_T = -2 * np.sqrt(C**7 / (C**7 + _FAR)) * np.sin(turn)
    l_, c_, h_ = dL / S_L, dC / S_C, dH / S_H
    squared = l_**2 + c_**2 + h_**2 + R_T * c_ * h_
    difference: np.ndarray = np.sqrt(np.maximum(squared, 0))  # rounding may go below 0
    return difference
