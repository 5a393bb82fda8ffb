"""The orientation that a picture's EXIF block declares."""

from typing import Any, Literal

import numpy as np

_EXIF_TAG_ORIENTATION = 0x0112
# EXIF orientation -> counter-clockwise degrees that make the picture upright (mirroring aside)
_UPRIGHT_DEGREES = {1: 0, 2: 0, 3: 180, 4: 180, 5: 270, 6: 270, 7: 90, 8: 90}


def rotation_degrees(metadata: dict[int, Any]) -> int:
    """Counter-clockwise degrees to upright."""
    return _UPRIGHT_DEGREES.get(orientation(metadata), 0)


def orientation(metadata: dict[int, Any]) -> int:
    """1 to 8 from EXIF (TIFF structure, Exif 2.32 section 4.6), 1 when it does not say."""
    import cv2

    blob = metadata.get(int(cv2.IMAGE_METADATA_EXIF))
    if blob is None:
        return 1
    data = np.asarray(blob, np.uint8).tobytes().removeprefix(b"Exif\0\0")
    if data[:2] not in (b"II", b"MM"):
        return 1
    order: Literal["little", "big"] = "little" if data[:2] == b"II" else "big"
    at = int.from_bytes(data[4:8], order)
    for entry in range(int.from_bytes(data[at : at + 2], order)):
        field = data[at + 2 + 12 * entry : at + 14 + 12 * entry]
        if int.from_bytes(field[:2], order) == _EXIF_TAG_ORIENTATION:
            return int.from_bytes(field[8:10], order)
    return 1
