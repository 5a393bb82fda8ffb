"""A caller who reads strangers' photos sets a lower limit and gets a call before decoding."""

import cv2
import numpy as np
import pytest
from makeup_video.pipeline import PhotoError
from makeup_video.pipeline.images.photo_file import read_photo


def test_a_lower_limit_refuses_before_decoding():
    photo, decoding = cv2.imencode(".png", np.full((30, 40, 3), 90, np.uint8))[1].tobytes(), []
    with pytest.raises(PhotoError, match=r"it has 40 x 30 px, more than"):
        read_photo(photo, "it", 40 * 30 - 1, lambda: decoding.append(1))
    assert decoding == []
    read_photo(photo, "it", 40 * 30, lambda: decoding.append(1))
    assert decoding == [1]
