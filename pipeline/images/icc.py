"""Recognises Display P3 by a picture's ICC profile."""

import struct

import numpy as np

# Red, green and blue of Display P3 in CIE XYZ under D50, as stored in its profiles.
_DISPLAY_P3 = ((0.5151, 0.2412, -0.0011), (0.2919, 0.6922, 0.0419), (0.1572, 0.0666, 0.7841))
_NEARLY = 0.004  # greatest difference of an X, Y or Z that still counts as equal
_COLORANTS = (b"rXYZ", b"gXYZ", b"bXYZ")
_TAGS_AT, _TAG_BYTES, _MOST_TAGS = 128, 12, 100


def is_display_p3(profile: bytes) -> bool:
    """True for a profile whose red, green and blue are those of Display P3.

    The curve is not checked: every profile of that name has sRGB's curve (ICC.1:2010, 9.2.4 and
    10.31).
    """
    try:
        colorants = [_xyz_of(profile, name) for name in _COLORANTS]
    except (struct.error, KeyError):
        return False
    return bool(np.abs(np.subtract(colorants, _DISPLAY_P3)).max() < _NEARLY)


def _xyz_of(profile: bytes, name: bytes) -> tuple[float, ...]:
    """The numbers of an XYZ tag. Raises struct.error or KeyError for a profile without the tag."""
    (count,) = struct.unpack_from(">I", profile, _TAGS_AT)
    for number in range(min(count, _MOST_TAGS)):
        tag, at, _ = struct.unpack_from(">4sII", profile, _TAGS_AT + 4 + _TAG_BYTES * number)
        if tag == name:
            kind, *values = struct.unpack_from(">4s4x3i", profile, at)
            if kind == b"XYZ ":
                return tuple(value / 65536 for value in values)
    raise KeyError(name)
