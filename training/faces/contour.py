"""Fills closed contours more finely than whole px."""

import cv2
import numpy as np

_SUB_BITS = 4  # of the places that OpenCV takes: a sixteenth of a px


def fill(picture: np.ndarray, contour_px: np.ndarray, value: int = 1) -> None:
    """Set what lies inside a closed contour (K, 2) of a picture (H, W), in place."""
    places = np.rint(contour_px * 2**_SUB_BITS).astype(np.int32)
    cv2.fillPoly(picture, [places], value, shift=_SUB_BITS)
