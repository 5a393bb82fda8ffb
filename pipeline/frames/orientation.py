"""How stored pictures become upright: EXIF's eight orientations (Exif 2.32, section 4.6.5)."""

from typing import Any, NamedTuple


class Orientation(NamedTuple):
    """How a stored picture becomes upright: turned first, then mirrored.

    turn_degrees: counter-clockwise, 0, 90, 180 or 270.  is_mirrored: left and right change places.
    transposition: both in one step, as a name of Pillow's `Image.Transpose`; "" for none.
    """

    turn_degrees: int
    is_mirrored: bool
    transposition: str


ORIENTATIONS = {
    1: Orientation(0, False, ""),
    2: Orientation(0, True, "FLIP_LEFT_RIGHT"),
    3: Orientation(180, False, "ROTATE_180"),
    4: Orientation(180, True, "FLIP_TOP_BOTTOM"),
    5: Orientation(270, True, "TRANSPOSE"),
    6: Orientation(270, False, "ROTATE_270"),
    7: Orientation(90, True, "TRANSVERSE"),
    8: Orientation(90, False, "ROTATE_90"),
}
UPRIGHT = ORIENTATIONS[1]


def orientation_of(value: Any) -> Orientation:
    """The orientation that a number in an EXIF block means; upright for any number but 1 to 8."""
    return ORIENTATIONS.get(int(value), UPRIGHT)
