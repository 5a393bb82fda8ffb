"""Y'CbCr codes <-> R'G'B' <-> linear light: the exact numpy twin of colour.h.

Linear light is display light in the frame's own primaries; 1 is diffuse white. Nothing is clipped:
the curves go on beyond 0..1, odd about 0, so that colours outside the gamut return to their codes.
Code points are those of ITU-T H.273 (07/2021).

SDR light follows the sRGB curve whatever the transfer tag (docs/decisions/colour.md has the
reason). HDR light is in units of HDR reference white, 203 cd/m2, which is 58 % PQ and 75 % HLG
(ITU-R BT.2408-8, table 1); HLG light is that of a display of 1000 cd/m2.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np
from makeup_video.kernels.definitions import Definitions

# ITU-T H.273, 8.3: Kr and Kb
LUMA_WEIGHTS = {
    1: (0.2126, 0.0722),  # BT.709
    4: (0.30, 0.11),  # FCC
    5: (0.299, 0.114),  # BT.601, 625 lines
    6: (0.299, 0.114),  # BT.601, 525 lines
    7: (0.212, 0.087),  # SMPTE ST 240
    9: (0.2627, 0.0593),  # BT.2020
}
# ITU-T H.273, 8.1: x and y of red, green, blue; the white of all of them is D65
PRIMARIES = {
    1: ((0.640, 0.330), (0.300, 0.600), (0.150, 0.060)),  # BT.709, sRGB
    5: ((0.640, 0.330), (0.290, 0.600), (0.150, 0.060)),  # BT.601, 625 lines
    6: ((0.630, 0.340), (0.310, 0.595), (0.155, 0.070)),  # BT.601, 525 lines
    7: ((0.630, 0.340), (0.310, 0.595), (0.155, 0.070)),  # SMPTE ST 240
    9: ((0.708, 0.292), (0.170, 0.797), (0.131, 0.046)),  # BT.2020
    12: ((0.680, 0.320), (0.265, 0.690), (0.150, 0.060)),  # P3-D65, "Display P3"
}
D65 = (0.3127, 0.3290)
SRGB, PQ, HLG = 13, 16, 18  # ITU-T H.273, 8.2
HDR_TRANSFERS = {PQ: "PQ", HLG: "HLG"}  # SMPTE ST 2084 and ARIB STD-B67, by name
BT2020, DISPLAY_P3 = 9, 12  # primaries
WIDE_PRIMARIES = {BT2020: "BT.2020", DISPLAY_P3: "Display P3"}

# IEC 61966-2-1: the straight part near black, in light and in R'G'B', and its slope
SRGB_LINEAR_END, SRGB_ENCODED_END, SRGB_SLOPE = 0.0031308, 0.04045, 12.92

REFERENCE_WHITE = 203.0  # cd/m2, ITU-R BT.2408-8

# SMPTE ST 2084:2014, 5.2; PQ_PEAK in cd/m2
PQ_M1, PQ_M2 = 2610 / 16384, 2523 / 4096 * 128
PQ_C1, PQ_C2, PQ_C3 = 3424 / 4096, 2413 / 4096 * 32, 2392 / 4096 * 32
PQ_PEAK = 10000.0
PQ_WHITES = PQ_PEAK / REFERENCE_WHITE  # the peak in units of diffuse white
PQ_LARGEST = 1.25  # the curve has a pole at 1.99; no display shows more than 1

# ITU-R BT.2100-2, table 5. The system gamma is that of a display with 1000 cd/m2.
HLG_A = 0.17883277
HLG_B = 1 - 4 * HLG_A
HLG_C = 0.5 - HLG_A * np.log(4 * HLG_A)
HLG_GAMMA = 1.2
HLG_LUMINANCE = (0.2627, 0.6780, 0.0593)
HLG_WHITE = (np.exp((0.75 - HLG_C) / HLG_A) + HLG_B) / 12  # scene light of 75 %
# Darker scene luminance gets the display's gain at this luminance: at 0 the inverse of the gain is
# not finite. This luminance is far below one code of 12 bits.
HLG_DARKEST = 2.0**-20
HLG_END = 0.5  # R'G'B' where the curve turns from a square root into a logarithm

# The struct of colour.h: (3, 4) from codes to R'G'B', and back.
CODING = np.dtype([
    ("to_rgb", np.float32, (3, 4)),
    ("to_codes", np.float32, (3, 4)),
    ("max_code", np.float32),
])  # fmt: skip
DEFINITIONS = Definitions(
    {
        "COLOUR_SRGB_LINEAR_END": SRGB_LINEAR_END,
        "COLOUR_SRGB_ENCODED_END": SRGB_ENCODED_END,
        "COLOUR_SRGB_SLOPE": SRGB_SLOPE,
        "COLOUR_PQ_M1": PQ_M1,
        "COLOUR_PQ_M2": PQ_M2,
        "COLOUR_PQ_C1": PQ_C1,
        "COLOUR_PQ_C2": PQ_C2,
        "COLOUR_PQ_C3": PQ_C3,
        "COLOUR_PQ_WHITES": PQ_WHITES,
        "COLOUR_PQ_LARGEST": PQ_LARGEST,
        # of BT.2100's curve in units of diffuse white, with logarithms to base 2
        "COLOUR_HLG_END": HLG_END,
        "COLOUR_HLG_LIGHT_END": 1 / 12 / HLG_WHITE,
        "COLOUR_HLG_PER_WHITE": 12 * HLG_WHITE,
        "COLOUR_HLG_SQUARE": 1 / 3 / HLG_WHITE,
        "COLOUR_HLG_ROOT": 3 * HLG_WHITE,
        "COLOUR_HLG_A": HLG_A * np.log(2),
        "COLOUR_HLG_PER_A": 1 / (HLG_A * np.log(2)),
        "COLOUR_HLG_B": HLG_B,
        "COLOUR_HLG_B_LIGHT": HLG_B / 12 / HLG_WHITE,
        "COLOUR_HLG_C": HLG_C,
        "COLOUR_HLG_RED": HLG_LUMINANCE[0],
        "COLOUR_HLG_GREEN": HLG_LUMINANCE[1],
        "COLOUR_HLG_BLUE": HLG_LUMINANCE[2],
        "COLOUR_HLG_GAMMA": HLG_GAMMA,
        "COLOUR_HLG_GAIN": HLG_GAMMA - 1,
        "COLOUR_HLG_GAIN_BACK": 1 / HLG_GAMMA - 1,
        "COLOUR_HLG_DARKEST": HLG_DARKEST,
        "COLOUR_HLG_DARKEST_LIGHT": HLG_DARKEST**HLG_GAMMA,
    },
    {"colour_coding": CODING},
)


@dataclass(frozen=True)
class Coding:
    """How a frame's codes encode colour, with no tag left unspecified.

    matrix: a key of LUMA_WEIGHTS. primaries: a key of PRIMARIES. transfer: SRGB, PQ or HLG.
    """

    matrix: int = 1
    full_range: bool = False
    transfer: int = SRGB
    primaries: int = 1
    bit_depth: int = 8

    def __post_init__(self) -> None:
        for what, got, known in (
            ("matrix", self.matrix, LUMA_WEIGHTS),
            ("transfer", self.transfer, (SRGB, PQ, HLG)),
            ("primaries", self.primaries, PRIMARIES),
            ("bit depth", self.bit_depth, range(8, 17)),
        ):
            if got not in known:
                raise ValueError(f"{what} must be one of {', '.join(map(str, known))}, got {got}")

    @property
    def max_code(self) -> int:
        return int(2**self.bit_depth - 1)


def decode(codes: np.ndarray, coding: Coding) -> np.ndarray:
    """Y'CbCr codes (..., 3) -> linear light (..., 3), float64."""
    to_rgb, _ = matrices(coding)
    return to_linear(codes @ to_rgb[:, :3].T + to_rgb[:, 3], coding.transfer)


def encode(linear: np.ndarray, coding: Coding) -> np.ndarray:
    """Linear light (..., 3) -> Y'CbCr codes (..., 3), float64, neither rounded nor clipped."""
    _, to_codes = matrices(coding)
    codes: np.ndarray = to_encoded(linear, coding.transfer) @ to_codes[:, :3].T + to_codes[:, 3]
    return codes


def rounded(codes: np.ndarray, coding: Coding) -> np.ndarray:
    """Round and clip codes for storage; halves go up (ITU-T H.273, Round)."""
    whole: np.ndarray = np.clip(np.floor(codes + 0.5), 0, coding.max_code).astype(np.int64)
    return whole


@lru_cache
def matrices(coding: Coding) -> tuple[np.ndarray, np.ndarray]:
    """Return the (3, 4) matrices from codes to R'G'B' and back (ITU-T H.273, 8.3)."""
    kr, kb = LUMA_WEIGHTS[coding.matrix]
    kg = 1 - kr - kb
    weights = np.array([
        [kr, kg, kb],
        np.array([-kr, -kg, 1 - kb]) / (2 * (1 - kb)),
        np.array([1 - kr, -kg, -kb]) / (2 * (1 - kr)),
    ])  # fmt: skip
    unit = 2.0 ** (coding.bit_depth - 8)
    top = coding.max_code
    spans = [top, top, top] if coding.full_range else [219 * unit, 224 * unit, 224 * unit]
    offset = np.array([0 if coding.full_range else 16, 128, 128]) * unit
    forward = np.diag(spans) @ weights
    back = np.linalg.inv(forward)
    return np.column_stack([back, -back @ offset]), np.column_stack([forward, offset])


@lru_cache
def coding_argument(coding: Coding) -> np.ndarray:
    """Make the colour_coding of colour.h, which kernels take by value: (1,) CODING."""
    return np.array([(*matrices(coding), coding.max_code)], CODING)


@lru_cache
def product_linear(rgb: tuple[float, float, float], coding: Coding) -> np.ndarray:
    """Convert a colour in sRGB, 0..255, to linear light (3,) in the frame's primaries."""
    linear = to_linear(np.array(rgb, np.float64) / 255, SRGB)
    product: np.ndarray = from_srgb_primaries(coding.primaries) @ linear
    return product


@lru_cache
def from_srgb_primaries(primaries: int) -> np.ndarray:
    """Return the (3, 3) matrix from linear light in sRGB's primaries to linear light in others."""
    if primaries == 1:  # sRGB's own: with the rounding of `solve`, black channels would be negative
        return np.eye(3)
    matrix: np.ndarray = np.linalg.solve(to_xyz(primaries), to_xyz(1))
    return matrix


@lru_cache
def to_srgb_primaries(primaries: int) -> np.ndarray:
    """Return the (3, 3) matrix from linear light in primaries to linear light in sRGB's."""
    matrix: np.ndarray = np.linalg.inv(from_srgb_primaries(primaries))
    return matrix


@lru_cache
def to_xyz(primaries: int) -> np.ndarray:
    """Return the (3, 3) matrix from linear light to CIE 1931 XYZ, white at Y = 1 (RP 177)."""
    columns = np.array([[x / y, 1, (1 - x - y) / y] for x, y in (*PRIMARIES[primaries], D65)]).T
    scaled: np.ndarray = columns[:, :3] * np.linalg.solve(columns[:, :3], columns[:, 3])
    return scaled


def to_linear(encoded: np.ndarray, transfer: int) -> np.ndarray:
    """R'G'B' (..., 3) -> linear light (..., 3)."""
    a = np.abs(encoded)
    if transfer == PQ:
        p = np.minimum(a, PQ_LARGEST) ** (1 / PQ_M2)
        y = (np.maximum(p - PQ_C1, 0) / (PQ_C2 - PQ_C3 * p)) ** (1 / PQ_M1)
        light = y * PQ_PEAK / REFERENCE_WHITE
    elif transfer == HLG:
        light = (
            np.where(a <= HLG_END, a**2 / 3, (np.exp((a - HLG_C) / HLG_A) + HLG_B) / 12) / HLG_WHITE
        )
    else:  # IEC 61966-2-1
        light = np.where(a <= SRGB_ENCODED_END, a / SRGB_SLOPE, ((a + 0.055) / 1.055) ** 2.4)
    light = np.asarray(np.copysign(light, encoded))
    if transfer == HLG:  # the display multiplies by a power of the luminance (BT.2100: OOTF)
        luminance = np.maximum(light @ HLG_LUMINANCE, HLG_DARKEST)
        light = light * luminance[..., None] ** (HLG_GAMMA - 1)
    return light


def to_encoded(linear: np.ndarray, transfer: int) -> np.ndarray:
    """Linear light (..., 3) -> R'G'B' (..., 3)."""
    if transfer == HLG:
        luminance = np.maximum(linear @ HLG_LUMINANCE, HLG_DARKEST**HLG_GAMMA)
        linear = linear * luminance[..., None] ** (1 / HLG_GAMMA - 1)
    a = np.abs(linear)
    if transfer == PQ:
        y = (a * REFERENCE_WHITE / PQ_PEAK) ** PQ_M1
        encoded = ((PQ_C1 + PQ_C2 * y) / (1 + PQ_C3 * y)) ** PQ_M2
    elif transfer == HLG:
        scene = a * HLG_WHITE
        high = HLG_A * np.log(np.maximum(12 * scene - HLG_B, HLG_B)) + HLG_C
        encoded = np.where(scene <= 1 / 12, np.sqrt(3 * scene), high)
    else:  # IEC 61966-2-1
        encoded = np.where(a <= SRGB_LINEAR_END, SRGB_SLOPE * a, 1.055 * a ** (1 / 2.4) - 0.055)
    return np.asarray(np.copysign(encoded, linear))
