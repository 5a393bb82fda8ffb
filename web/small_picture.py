"""Scales pictures down and encodes them as JPEG, for the page."""

import cv2
import numpy as np

SLOT_PX = 160  # longer side of the picture beside a photo's name
_JPEG = (
    cv2.IMWRITE_JPEG_QUALITY, 90,
    cv2.IMWRITE_JPEG_SAMPLING_FACTOR, cv2.IMWRITE_JPEG_SAMPLING_FACTOR_444,
)  # fmt: skip


def scaled(rgb8: np.ndarray, scale: float) -> np.ndarray:
    """Scale a picture, (H, W, 3) uint8 RGB, down by averaging; never enlarge a picture."""
    if scale >= 1:
        return rgb8
    h, w = rgb8.shape[:2]
    size_wh = max(1, round(scale * w)), max(1, round(scale * h))
    return cv2.resize(rgb8, size_wh, interpolation=cv2.INTER_AREA)


def jpeg(rgb8: np.ndarray) -> bytes:
    """Encode a picture, (H, W, 3) uint8 RGB, as JPEG of quality 90 with chroma in full size."""
    _, data = cv2.imencode(".jpg", rgb8[..., ::-1], _JPEG)
    return data.tobytes()


def small_jpeg(rgb8: np.ndarray, side_px: int = SLOT_PX) -> bytes:
    """Scale a picture down until its longer side is at most `side_px`, and encode it as JPEG."""
    return jpeg(scaled(rgb8, side_px / max(rgb8.shape[:2])))
