"""Y'CbCr codes <-> R'G'B' <-> linear light: the numpy twin of colour.h, exact where that is quick.

Linear light is display light in the frame's own primaries; 1 is diffuse white. Nothing is clipped:
beyond 0..1 the curves go on, odd about 0, so that colours outside the gamut come back as the
codes they were. Code points are those of ITU-T H.273 (07/2021).

SDR light is what the sRGB curve makes of R'G'B', whatever the transfer tag says (docs/decisions/colour.md
has the reason). HDR light is counted in units of HDR reference white, 203 cd/m2, which is 58 % PQ
and 75 % HLG (ITU-R BT.2408-8, table 1); HLG is seen on its 1000 cd/m2 display.
"""

from dataclasses import dataclass
from functools import lru_cache

import numpy as np

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
REFERENCE_WHITE = 203.0  # cd/m2, ITU-R BT.2408-8

# SMPTE ST 2084:2014, 5.2; PQ_PEAK in cd/m2
PQ_M1, PQ_M2 = 2610 / 16384, 2523 / 4096 * 128
PQ_C1, PQ_C2, PQ_C3 = 3424 / 4096, 2413 / 4096 * 32, 2392 / 4096 * 32
PQ_PEAK = 10000.0
PQ_LARGEST = 1.25  # the curve has a pole at 1.99; no display shows more than 1

# ITU-R BT.2100-2, table 5. The system gamma is that of a display with 1000 cd/m2.
HLG_A = 0.17883277
HLG_B = 1 - 4 * HLG_A
HLG_C = 0.5 - HLG_A * np.log(4 * HLG_A)
HLG_GAMMA = 1.2
HLG_LUMINANCE = (0.2627, 0.6780, 0.0593)
HLG_WHITE = (np.exp((0.75 - HLG_C) / HLG_A) + HLG_B) / 12  # scene light of 75 %
# Below this scene luminance the display's gain is that of this luminance: at 0 its inverse is not
# finite. Far darker than a code of 12 bits can say.
HLG_DARKEST = 2.0**-20


@dataclass(frozen=True)
class Coding:
    """How the codes of a frame mean colour, nothing left open.

    matrix, primaries: a key of LUMA_WEIGHTS, of PRIMARIES. transfer: SRGB, PQ or HLG.
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
    """The codes that are stored: halves go up (ITU-T H.273, Round), the rest is clipped."""
    whole: np.ndarray = np.clip(np.floor(codes + 0.5), 0, coding.max_code).astype(np.int64)
    return whole


@lru_cache
def matrices(coding: Coding) -> tuple[np.ndarray, np.ndarray]:
    """(3, 4) from codes to R'G'B', and (3, 4) back (ITU-T H.273, 8.3)."""
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
    """The colour_coding of colour.h, as a kernel takes it by value: (25,) float32."""
    numbers = [*matrices(coding)[0].flat, *matrices(coding)[1].flat, coding.max_code]
    return np.array(numbers, np.float32)


@lru_cache
def product_linear(rgb: tuple[float, float, float], coding: Coding) -> np.ndarray:
    """Linear light (3,) in the frame's primaries of a colour in sRGB, 0..255, under white light."""
    linear = to_linear(np.array(rgb, np.float64) / 255, SRGB)
    product: np.ndarray = from_srgb_primaries(coding.primaries) @ linear
    return product


@lru_cache
def from_srgb_primaries(primaries: int) -> np.ndarray:
    """(3, 3) from linear light in sRGB's primaries to linear light in others."""
    matrix: np.ndarray = np.linalg.solve(to_xyz(primaries), to_xyz(1))
    return matrix


@lru_cache
def to_xyz(primaries: int) -> np.ndarray:
    """(3, 3) from linear light to CIE 1931 XYZ with Y = 1 for white (SMPTE RP 177)."""
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
        light = np.where(a <= 0.5, a**2 / 3, (np.exp((a - HLG_C) / HLG_A) + HLG_B) / 12) / HLG_WHITE
    else:  # IEC 61966-2-1
        light = np.where(a <= 0.04045, a / 12.92, ((a + 0.055) / 1.055) ** 2.4)
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
        encoded = np.where(a <= 0.0031308, 12.92 * a, 1.055 * a ** (1 / 2.4) - 0.055)
    return np.asarray(np.copysign(encoded, linear))
