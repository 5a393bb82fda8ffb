"""HDR metadata that travels beside the picture: what it says, and how encoders spell it."""

import struct
from dataclasses import dataclass
from fractions import Fraction
from typing import Any

import av
from av.sidedata.sidedata import Type as SideDataType

_DYNAMIC = {
    "DYNAMIC_HDR_PLUS": "HDR10+",
    "DYNAMIC_HDR_VIVID": "HDR Vivid",
    "DOVI_RPU_BUFFER": "Dolby Vision",
    "DOVI_METADATA": "Dolby Vision",
}


@dataclass(frozen=True)
class _Spelling:
    """The encoder's option that takes its own parameters, and the names of two of those.

    in_units: chromaticity counted in 1/50000 and luminance in 1/10000 cd/m2, as in the SEI message
    of SMPTE ST 2086; else plain numbers.
    """

    option: str
    display: str
    light: str
    in_units: bool


_SPELLINGS = {
    "hevc": _Spelling("x265-params", "master-display", "max-cll", True),
    "h264": _Spelling("x264-params", "mastering-display", "cll", True),
    "av1": _Spelling("svtav1-params", "mastering-display", "content-light", False),
}


def side_data(picture: av.VideoFrame, name: str) -> bytes | None:
    """The bytes of a kind of FFmpeg's frame side data, None when the frame has none."""
    everything: Any = picture.side_data
    data = everything.get(SideDataType[name])
    return None if data is None else bytes(data)


def hdr_options(picture: av.VideoFrame, codec: str) -> tuple[str, list[str], list[str]]:
    """(encoder option, its parts, what is lost) for the static HDR10 metadata of a picture.

    Encoders do not take it from the frame by themselves. Dynamic metadata (HDR10+, Dolby Vision)
    describes the unpainted picture and is lost by design.
    """
    display = side_data(picture, "MASTERING_DISPLAY_METADATA")
    light = side_data(picture, "CONTENT_LIGHT_LEVEL")
    spelling, parts, lost = _SPELLINGS.get(codec), [], []
    for what, data in (("mastering display", display), ("content light level", light)):
        if data is not None and spelling is None:
            lost.append(f"HDR10 {what}: {codec} cannot carry it; use hevc")
    if spelling is not None:
        if display is not None and (text := mastering_text(display, spelling.in_units)):
            parts.append(f"{spelling.display}={text}")
        if light is not None:
            # AVContentLightMetadata begins with MaxCLL and MaxFALL, in cd/m2
            parts.append(f"{spelling.light}={','.join(map(str, struct.unpack('2I', light[:8])))}")
    everything: Any = picture.side_data
    kinds = {_DYNAMIC[data.type.name] for data in everything if data.type.name in _DYNAMIC}
    lost += [
        f"{kind} dynamic metadata: it describes the unpainted picture" for kind in sorted(kinds)
    ]
    return (spelling.option if spelling else "", parts, lost)


def light_levels(picture: av.VideoFrame) -> tuple[float | None, float | None]:
    """(the film's brightest pixel, the peak of its mastering display) in cd/m2; None: not told."""
    light = side_data(picture, "CONTENT_LIGHT_LEVEL")
    display = side_data(picture, "MASTERING_DISPLAY_METADATA")
    brightest = None if light is None else float(struct.unpack("I", light[:4])[0])
    if display is None:
        return brightest, None
    numbers = struct.unpack("20i2i", display[:88])
    is_told = numbers[21] and numbers[19]
    return brightest, numbers[18] / numbers[19] if is_told else None


def mastering_text(data: bytes, in_units: bool) -> str | None:
    """G(x,y)B(x,y)R(x,y)WP(x,y)L(max,min) from the bytes of AVMasteringDisplayMetadata.

    None when primaries or luminance are missing: the message needs both.
    """
    numbers = struct.unpack("20i2i", data[:88])
    if not (numbers[20] and numbers[21]):
        return None
    values = [Fraction(a, b or 1) for a, b in zip(numbers[0:20:2], numbers[1:20:2], strict=True)]

    def pair(a: Fraction, b: Fraction, scale: int) -> str:
        if in_units:
            return f"({round(a * scale)},{round(b * scale)})"
        return f"({float(a):.5f},{float(b):.5f})"

    red, green, blue, white = (values[i : i + 2] for i in (0, 2, 4, 6))
    text = "".join(
        name + pair(x, y, 50000)
        for name, (x, y) in (("G", green), ("B", blue), ("R", red), ("WP", white))
    )
    return text + "L" + pair(values[9], values[8], 10000)
