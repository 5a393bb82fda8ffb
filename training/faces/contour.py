"""Fills closed contours whose points lie between whole px."""

import cv2
import numpy as np

_SUB_BITS = 4  # fractional bits of OpenCV's coordinates: steps of a sixteenth of a px


def fill(picture: np.ndarray, contour_px: np.ndarray, value: int = 1) -> None:
    """Set the px of a picture (H, W) inside a closed contour (K, 2) px, in place."""
    places = np.rint(contour_px * 2**_SUB_BITS).astype(np.int32)
    cv2.fillPoly(picture, [places], value, shift=_SUB_BITS)
