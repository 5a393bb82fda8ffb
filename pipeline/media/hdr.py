"""HDR metadata that a frame carries as side data, read and spelled for the encoder."""

import struct
from fractions import Fraction

import av
from makeup_video.pipeline.frames.side_data import all_side_data, side_data
from makeup_video.pipeline.media.codecs import VideoCodec, codecs_with

_DYNAMIC = {
    "DYNAMIC_HDR_PLUS": "HDR10+",
    "DYNAMIC_HDR_VIVID": "HDR Vivid",
    "DOVI_RPU_BUFFER": "Dolby Vision",
    "DOVI_METADATA": "Dolby Vision",
}


def hdr_parameters(picture: av.VideoFrame, codec: VideoCodec) -> tuple[list[str], list[str]]:
    """(parameters for the encoder's library, what is lost) for a picture's HDR10 metadata.

    Encoders do not take static metadata from the frame by themselves. Dynamic metadata (HDR10+,
    Dolby Vision) describes the unpainted picture and is lost by design.
    """
    display = side_data(picture, "MASTERING_DISPLAY_METADATA")
    light = side_data(picture, "CONTENT_LIGHT_LEVEL")
    parameters: list[str] = []
    lost: list[str] = []
    if codec.hdr is None:
        # H.264 has the metadata too, but with its usual 8 bits HDR shows bands
        others = codecs_with(lambda other: other.hdr is not None and other.depth is None)
        for name, data in (("mastering display", display), ("content light level", light)):
            if data is not None:
                lost.append(f"HDR10 {name}: {codec.name} cannot carry it; use {others}")
    else:
        if display is not None and (text := mastering_text(display, codec.hdr.in_units)):
            parameters.append(f"{codec.hdr.mastering_display}={text}")
        if light is not None:
            # AVContentLightMetadata begins with MaxCLL and MaxFALL, in cd/m2
            levels = ",".join(map(str, struct.unpack("2I", light[:8])))
            parameters.append(f"{codec.hdr.content_light}={levels}")
    return parameters, lost + _lost_dynamic(picture)


def _lost_dynamic(picture: av.VideoFrame) -> list[str]:
    names = (kind.name for kind in all_side_data(picture))
    kinds = {_DYNAMIC[name] for name in names if name in _DYNAMIC}
    return [
        f"{kind} dynamic metadata: it describes the unpainted picture" for kind in sorted(kinds)
    ]


def light_levels(picture: av.VideoFrame) -> tuple[float | None, float | None]:
    """Return the brightest pixel and the mastering display's peak, cd/m2; None if unknown."""
    light = side_data(picture, "CONTENT_LIGHT_LEVEL")
    display = side_data(picture, "MASTERING_DISPLAY_METADATA")
    brightest = None if light is None else float(struct.unpack("I", light[:4])[0])
    if display is None:
        return brightest, None
    numbers = struct.unpack("20i2i", display[:88])
    has_luminance = numbers[21] and numbers[19]
    return brightest, numbers[18] / numbers[19] if has_luminance else None


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
