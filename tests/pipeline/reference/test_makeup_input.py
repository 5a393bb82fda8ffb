"""The input of the net that reads what is worn."""

import numpy as np
from makeup_video.pipeline.reference.makeup_input import INPUT_WH, PLACES, makeup_input, mirrored
from makeup_video.pipeline.reference.photo_light import photo_light
from people import portrait
from reference_photos import face


def test_the_input_shows_eyes_face_and_lips():
    seen = makeup_input(portrait(), face(), photo_light(portrait(), face()))
    assert seen.shape == (*INPUT_WH[::-1], 3) and seen.dtype == np.uint8
    for left, top, wide, high in PLACES.values():
        assert np.ptp(seen[top : top + high, left : left + wide]) > 60
    np.testing.assert_array_equal(mirrored(mirrored(seen)), seen)
    assert (mirrored(seen) != seen).any()
