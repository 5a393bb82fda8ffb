"""The orientation that a picture's EXIF block declares."""

import warnings
from typing import Any

from makeup_video.pipeline.frames.orientation import UPRIGHT, Orientation, orientation_of

_ORIENTATION_TAG = 0x0112


def orientation(metadata: dict[int, Any]) -> Orientation:
    """The orientation in OpenCV's metadata {kind: bytes}; upright when none is declared."""
    import cv2

    block = metadata.get(int(cv2.IMAGE_METADATA_EXIF))
    if block is None:
        return UPRIGHT
    from PIL import Image  # late: videos do not need Pillow

    exif = Image.Exif()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # Pillow's, about damaged blocks
            exif.load(bytes(block))
            return orientation_of(exif.get(_ORIENTATION_TAG, 1))
    except Exception:  # noqa: BLE001  # a damaged block may make Pillow raise anything
        return UPRIGHT
