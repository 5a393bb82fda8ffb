"""Those who read strangers' photos set a lower limit, and hear when decoding begins."""

import cv2
import numpy as np
import pytest
from makeup_video.pipeline import PhotoError
from makeup_video.pipeline.images.photo_file import read_photo


def test_who_asks_for_fewer_pixels_refuses_larger_photos_before_any_is_decoded():
    photo, decoding = cv2.imencode(".png", np.full((30, 40, 3), 90, np.uint8))[1].tobytes(), []
    with pytest.raises(PhotoError, match=r"it has 40 x 30 px, more than"):
        read_photo(photo, "it", 40 * 30 - 1, lambda: decoding.append(1))
    assert decoding == []
    read_photo(photo, "it", 40 * 30, lambda: decoding.append(1))
    assert decoding == [1]
